#include "io/mesh/texture_images.h"

#include <algorithm>

#include "io/image/color_image.h"

namespace meander {

ColorImage image_of_file(std::span<const CompanionFile> companions, const std::string& path,
                         const CancelToken& cancel) {
  using Loss = CompanionFile::Loss;
  ColorImage lost;
  lost.problem = "is not there";
  lost.loss = Note::image_missing;
  for (const CompanionFile& file : companions) {
    if (!file.is_image || file.path != path) continue;
    if (file.problem.empty()) return decode_color_image(file.bytes, cancel);
    if (file.loss == Loss::missing) break;
    lost.problem = file.loss == Loss::outside ? file.problem : "cannot be read";
    lost.loss = file.loss == Loss::outside ? Note::image_outside : Note::image_unreadable;
  }
  return lost;
}

std::string text_of_loss(const std::string& name, const std::string& problem) {
  for (const std::string_view verb : {"is ", "leads ", "cannot "})
    if (problem.starts_with(verb)) return name + " " + problem;
  return name + ": " + problem;
}

std::uint32_t FileImages::number_of(const std::string& path, const std::string& name) {
  const auto [at, is_new] = numbers_.try_emplace(path, static_cast<std::uint32_t>(textures_.images.size()));
  if (!is_new) return at->second;
  const ColorImage& image = textures_.images.emplace_back(image_of_file(companions_, path, cancel_));
  if (image.is_lost()) notes_.add(image.loss, text_of_loss("`" + name + "`", image.problem));
  return at->second;
}

std::uint64_t count_lacking_coordinates(const PolygonMesh& mesh, const SurfaceTextures& textures) {
  std::uint64_t lacking = 0;
  for (std::size_t p = 0; p < textures.face.size(); ++p) {
    const auto corners =
        std::span(textures.corner)
            .subspan(mesh.polygon_begin[p], mesh.polygon_begin[p + 1] - mesh.polygon_begin[p]);
    lacking +=
        textures.face[p] != no_index && std::find(corners.begin(), corners.end(), no_index) != corners.end();
  }
  return lacking;
}

}  // namespace meander
