// Parametric surfaces by their names on the command line.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface.h"

namespace meander {

struct HeightFieldOptions {
  double extent_x = 1, extent_y = 1;  // > 0
  double scale = 0.25;                // height of white
};

struct SurfaceSource {
  std::unique_ptr<ParametricSurface> surface;
  std::array<std::uint8_t, 32> content_sha256{};  // of the file, or of the name of a surface without one
};

enum class SurfaceKind { formula, nurbs, height_field };
// The kind by the extension, in any case.
SurfaceKind surface_kind(const std::string& argument);

// Throws UsageError, with a suggestion, unless the argument is a name of surface_names(), FILE.nurbs,
// FILE.png or three formulas (make_formula_surface).
void check_surface_name(const std::string& argument);

// Opens the surface of an argument that check_surface_name accepts. Throws ItemError for an invalid file.
SurfaceSource open_surface(const std::string& argument, const HeightFieldOptions& height_field = {});

// The id of its row: the name, the name of the file, or the formulas without blanks and with %2F for a slash.
std::string surface_id(const std::string& argument);

}  // namespace meander
