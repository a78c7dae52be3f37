#include "io/mesh/gltf_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "io/image/color_image.h"
#include "io/mesh/gltf_extensions.h"
#include "io/mesh/texture_images.h"

namespace meander {

std::uint64_t SceneTextures::embedded_bytes() {
  std::uint64_t bytes = 0, working = 0;
  std::vector<bool> counted(document_.images.size(), false);
  const auto add = [&](std::uint32_t image) {
    if (image >= counted.size() || counted[image]) return;
    counted[image] = true;
    with_bytes(image, [&](std::string_view content) {
      const ImageMemory memory = memory_of_image(std::as_bytes(std::span(content)));
      bytes += memory.kept_bytes;
      working = std::max(working, memory.working_bytes + content.size());
    });
  };
  for (const GltfMaterial& material : document_.materials) {
    add(material.image);
    add(material.other_image);
  }
  return bytes + working;
}

std::uint32_t SceneTextures::of(std::uint32_t material) {
  if (material >= numbers_.size() || !document_.materials[material].has_texture) return no_index;
  std::uint32_t& number = numbers_[material];
  if (number != no_index) return number;
  number = static_cast<std::uint32_t>(textures_->textures.size());
  textures_->textures.push_back(document_.materials[material].texture);
  textures_->textures.back().image = image_of(material);
  return number;
}

void SceneTextures::with_bytes(std::uint32_t number, const std::function<void(std::string_view)>& use) {
  const GltfImage& image = document_.images[number];
  try {
    if (image.uri && is_data_uri(*image.uri))
      use(std::string_view(decode_data_uri(*image.uri)));
    else if (!image.uri && image.view != no_index)
      use(data_.view(image.view));
  } catch (const ItemError& error) {
    if (error.status() != Status::unreadable) throw;
  }
}

ColorImage SceneTextures::read(std::uint32_t number) {
  const std::optional<std::string_view>& uri = document_.images[number].uri;
  if (uri && !is_data_uri(*uri)) {
    std::string reason;
    const std::string path = companion_path(*uri, reason);
    ColorImage image = image_of_file(companions_, path, cancel_);
    if (path.empty()) {
      image.problem = reason;
      image.loss = Note::image_outside;
    }
    return image;
  }
  ColorImage read;
  read.problem = "is not there";
  read.loss = Note::image_missing;
  with_bytes(number, [&](std::string_view content) {
    read = decode_color_image(std::as_bytes(std::span(content)), cancel_);
  });
  return read;
}

void SceneTextures::note_lost(std::uint32_t number, const ColorImage& image) {
  const std::optional<std::string_view>& uri = document_.images[number].uri;
  const std::string name =
      uri && !is_data_uri(*uri) ? "`" + shown_text(*uri) + "`" : fmt::format("image {}", number);
  notes_.add(image.loss, shown_text(text_of_loss(name, image.problem), Notes::longest_note_example));
}

std::uint32_t SceneTextures::image(std::uint32_t number, bool is_foreign) {
  if (number >= document_.images.size()) return no_index;
  const auto [at, is_new] = images_.try_emplace(number, static_cast<std::uint32_t>(textures_->images.size()));
  if (!is_new) return at->second;
  ColorImage made = read(number);
  if (made.is_lost()) {
    if (is_foreign && made.loss == Note::image_unreadable) made.loss = Note::image_unsupported;
    note_lost(number, made);
  }
  textures_->images.push_back(std::move(made));
  return at->second;
}

std::uint32_t SceneTextures::image_of(std::uint32_t number) {
  const GltfMaterial& material = document_.materials[number];
  const std::uint32_t first = image(material.image, material.is_foreign);
  if (first != no_index && !textures_->images[first].is_lost()) return first;
  const std::uint32_t other = image(material.other_image, false);
  if (first == no_index && other == no_index)
    notes_.add(Note::image_missing, fmt::format("the texture of material {} has no image", number));
  return other != no_index ? other : first;
}

}  // namespace meander
