// Internal to io/mesh: the colours in material libraries (MTL) of OBJ files.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <string_view>
#include <unordered_map>

#include "io/mesh/mesh_reader.h"

namespace meander {

// Red, green, blue as the file has them, in [0, 1]. The names are views of the libraries.
using MaterialColors = std::unordered_map<std::string_view, std::array<float, 3>>;

inline constexpr std::array<float, 3> no_material_color = {std::numeric_limits<float>::quiet_NaN(),
                                                           std::numeric_limits<float>::quiet_NaN(),
                                                           std::numeric_limits<float>::quiet_NaN()};

// The diffuse colours (Kd) of all materials; of materials of one name the first. `Kd r` means r three times;
// spectral and CIE XYZ colours are none. Nothing is an error: a line that cannot be read has no colour, a
// library with a problem or beyond 16 MiB no materials, and after 16384 materials the rest have none.
MaterialColors read_material_colors(std::span<const CompanionFile> libraries);
std::array<float, 3> color_of(const MaterialColors& materials, std::string_view name);

// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

}  // namespace meander
