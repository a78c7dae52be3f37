// Internal to io/mesh: the textures of a glTF scene.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "io/mesh/gltf_data.h"
#include "io/mesh/gltf_document.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

// The textures of materials, read when the first triangle has one. Images that are lost are noted.
class SceneTextures {
 public:
  SceneTextures(const GltfDocument& document, GltfData& data, std::span<const CompanionFile> companions,
                const CancelToken& cancel, Notes& notes)
      : document_(document),
        data_(data),
        companions_(companions),
        cancel_(cancel),
        notes_(notes),
        numbers_(document.materials.size(), no_index) {}

  // The bytes that decoding the embedded images takes, by their headers.
  std::uint64_t embedded_bytes();
  // The number of the material's texture; no_index where it has none.
  std::uint32_t of(std::uint32_t material);
  SurfaceTextures& made() { return *textures_; }
  std::shared_ptr<const SurfaceTextures> take() { return std::move(textures_); }

 private:
  // Calls use(bytes) for an image inside the file, unless it cannot be found.
  void with_bytes(std::uint32_t number, const std::function<void(std::string_view)>& use);
  ColorImage read(std::uint32_t number);
  void note_lost(std::uint32_t number, const ColorImage& image);
  // The number of an image that has been read, perhaps lost; no_index: there is none.
  std::uint32_t image(std::uint32_t number, bool is_foreign);
  std::uint32_t image_of(std::uint32_t number);

  const GltfDocument& document_;
  GltfData& data_;
  std::span<const CompanionFile> companions_;
  const CancelToken& cancel_;
  Notes& notes_;
  std::vector<std::uint32_t> numbers_;             // of textures, by material
  std::map<std::uint32_t, std::uint32_t> images_;  // of those that were read
  std::shared_ptr<SurfaceTextures> textures_ = std::make_shared<SurfaceTextures>();
};

}  // namespace meander
