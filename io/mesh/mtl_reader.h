// Internal to io/mesh: the materials in material libraries (MTL) of OBJ files, as far as colors need them.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "io/mesh/mesh_reader.h"
#include "kernels/core/notes.h"
#include "kernels/mesh/surface_textures.h"

namespace meander {

inline constexpr std::array<float, 3> no_material_color = {std::numeric_limits<float>::quiet_NaN(),
                                                           std::numeric_limits<float>::quiet_NaN(),
                                                           std::numeric_limits<float>::quiet_NaN()};

struct MtlMaterial {
  std::array<float, 3> color = no_material_color;  // Kd: red, green, blue as the file has them, in [0, 1]
  // map_Kd, and the path of the image from the model's folder; empty where the line names none.
  bool has_image = false;
  std::string image;
  Texture texture;  // without the number of the image
};

struct MtlMaterials {
  std::unordered_map<std::string, MtlMaterial> by_name;
  Notes notes;            // on libraries that are lost
  bool any_read = false;  // a library

  // A comment behind the name is left out. Null: there is none.
  const MtlMaterial* find(std::string_view name) const;
  // The only material there is; null where there are others or none. Faces of an OBJ file that names no
  // material have it: programs that export scans leave `usemtl` out.
  const std::pair<const std::string, MtlMaterial>* only() const {
    return by_name.size() == 1 ? &*by_name.begin() : nullptr;
  }
};

// The materials of all libraries; of those of one name the first. Libraries are texts as OBJ files are, with
// any line ends, in UTF-8 or UTF-16; keywords may be in capitals. `Kd r` means r three times; spectral and
// CIE XYZ colors are none. Of map_Kd the options -s, -o, -clamp and -mm are honored; -blendu, -blendv,
// -boost, -bm, -cc, -colorspace, -imfchan, -t, -texres and -type are read over, also behind the name. Images
// repeat, are bilinear, and v points up in them. Nothing is an error: a line that cannot be read has no
// color, a library with a problem or beyond 16 MiB no materials, which is noted, and after 16384 materials
// the rest have none. Images (CompanionFile::is_image) are skipped.
MtlMaterials read_materials(std::span<const CompanionFile> libraries);

// FormatRow::color_companions and library_images of OBJ files.
std::vector<std::string> library_paths(std::span<const std::byte> obj);
std::vector<std::string> images_of_libraries(std::span<const std::byte> obj,
                                             std::span<const CompanionFile> libraries);

// Without blanks at both ends.
std::string_view trimmed(std::string_view text);
// What stands behind this keyword, in any case, on a trimmed line; nothing where the line has another one.
std::optional<std::string_view> behind_keyword(std::string_view line, std::string_view lower_case);
// The path from the model's folder that people's files mean by the name of an image or a library: without
// quotation marks, and of an absolute path, which is one of the machine that the file was made on, the file's
// name alone. The folder is that of the file which names it, from the model's. Empty where there is no path.
std::string meant_path(std::string_view folder, std::string_view name);

}  // namespace meander
