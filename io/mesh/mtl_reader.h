// Internal to io/mesh: the materials in material libraries (MTL) of OBJ files, as far as colours need them.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "io/mesh/mesh_reader.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

inline constexpr std::array<float, 3> no_material_color = {std::numeric_limits<float>::quiet_NaN(),
                                                           std::numeric_limits<float>::quiet_NaN(),
                                                           std::numeric_limits<float>::quiet_NaN()};

struct MtlMaterial {
  std::array<float, 3> color = no_material_color;  // Kd: red, green, blue as the file has them, in [0, 1]
  // map_Kd. The image below the model's folder; empty where it leads elsewhere.
  bool has_image = false;
  std::string image;
  Texture texture;  // without the number of the image
};

// By name; the names are views of the libraries.
using MtlMaterials = std::unordered_map<std::string_view, MtlMaterial>;

// The materials of all libraries; of those of one name the first. `Kd r` means r three times; spectral and
// CIE XYZ colours are none. Of map_Kd the options -s, -o, -clamp and -mm are honoured; -blendu, -blendv,
// -boost, -bm, -cc, -imfchan, -t, -texres and -type are read over. Images repeat, are bilinear, and v points
// up in them. Nothing is an error: a line that cannot be read has no colour, a library with a problem or
// beyond 16 MiB no materials, and after 16384 materials the rest have none. Images (CompanionFile::is_image)
// are skipped.
MtlMaterials read_materials(std::span<const CompanionFile> libraries);
// Of a name that is not there, one without anything.
const MtlMaterial& material_of(const MtlMaterials& materials, std::string_view name);

// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

}  // namespace meander
