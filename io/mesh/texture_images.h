// Internal to io/mesh: the images that textures of a model show.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "io/mesh/mesh_reader.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

// The image in this file (CompanionFile::path), or none, with the reason: see decode_color_image.
ColorImage image_of_file(std::span<const CompanionFile> companions, const std::string& path,
                         const CancelToken& cancel);

// What is said of an image that is lost: the name, and the problem that it has, or that it is.
std::string text_of_loss(const std::string& name, const std::string& problem);

// The images in files that the textures of a model show, each read when it is first asked for. One that is
// lost is noted.
class FileImages {
 public:
  FileImages(std::span<const CompanionFile> companions, const CancelToken& cancel, SurfaceTextures& textures,
             Notes& notes)
      : companions_(companions), cancel_(cancel), textures_(textures), notes_(notes) {}

  // The number, in the textures, of the image of this file (CompanionFile::path); `name` as the model has it.
  std::uint32_t number_of(const std::string& path, const std::string& name);

 private:
  std::span<const CompanionFile> companions_;
  const CancelToken& cancel_;
  SurfaceTextures& textures_;
  Notes& notes_;
  std::map<std::string, std::uint32_t> numbers_;
};

inline constexpr const char* untextured_faces = "textured faces without texture coordinates";
// How many polygons that have a texture have a corner without texture coordinates.
std::uint64_t count_lacking_coordinates(const PolygonMesh& mesh, const SurfaceTextures& textures);

}  // namespace meander
