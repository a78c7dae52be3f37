#include "kernels/density/formula_density.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/core/ordered_blocks.h"
#include "kernels/density/density_pieces.h"
#include "kernels/density/mesh_variables.h"

namespace meander {

namespace {

constexpr double pixels_of_diagonal = 512;
constexpr double rounding = 1e-12;  // of the largest value beside, or of 1
constexpr std::size_t formula_block = 1024;

bool is_density(double value) { return value >= 0 && value <= largest_density; }

// Sets to 0 what rounding makes of it, as of 1 + cos at its minimum.
void drop_rounding(std::span<double> value) {
  double largest = 1;
  for (const double v : value) largest = std::max(largest, v);
  for (double& v : value)
    if (v < 0 && v >= -rounding * largest) v = 0;
}

// The first of these points of a triangle whose value is no density, in a sentence.
std::string problem_of(const PreparedMesh& mesh, const MeshVariables& variables, const Expression& formula,
                       bool unit_box, std::size_t t, std::span<const std::array<double, 2>> weight,
                       std::span<const double> value) {
  const auto bad = std::ranges::find_if_not(value, is_density);
  const auto [x, y, z] = variables.place(t, weight[static_cast<std::size_t>(bad - value.begin())]);
  char text[192];
  std::snprintf(text, sizeof text, "` is %.6g on face %u, at x = %.6g, y = %.6g, z = %.6g%s", *bad,
                mesh.polygon[t], x, y, z, unit_box ? " of the unit box" : "");
  return "the density `" + formula.text() + text +
         (*bad > largest_density && std::isfinite(*bad)
              ? ", which is too large: densities are stored in float32, up to 3.4e38"
              : "; a density must be finite and not negative");
}

std::optional<Expression> compiled(const DensityParameters& parameters) {
  if (!is_formula(parameters.kind)) return std::nullopt;
  try {
    return formula_of(parameters);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

bool is_linear(const Expression& formula) { return formula.degree(degrees_over_triangles) <= 1; }

// The powers of two of the pixels of triangles; one without an area has no points, and its values are
// nobody's.
std::vector<std::uint8_t> levels_of(const PreparedMesh& mesh) {
  const double pixel = mesh.diagonal / mesh.unit / pixels_of_diagonal;
  std::vector<std::uint8_t> level(mesh.triangle_count(), no_pixels);
  for (std::uint32_t t = 0; t < level.size(); ++t) {
    if (!(mesh.area[t] > 0)) continue;
    double pixels = mesh.area[t] / (pixel * pixel);
    for (std::uint32_t k = 0; k < 3; ++k) pixels = std::max(pixels, mesh.length_in_space(3 * t + k) / pixel);
    level[t] = pixel_level(pixels);
  }
  return level;
}

}  // namespace

Expression formula_of(const DensityParameters& parameters) {
  return Expression(parameters.formula, mesh_variables);
}

bool uses_curvature(const DensityParameters& parameters) {
  const std::optional<Expression> formula = compiled(parameters);
  return formula && uses_curvature(*formula);
}

bool uses_coordinates(const DensityParameters& parameters) {
  const std::optional<Expression> formula = compiled(parameters);
  return formula && uses_coordinates(*formula);
}

bool is_in_pieces(const DensityParameters& parameters) {
  const std::optional<Expression> formula = compiled(parameters);
  return reads_textures(parameters.kind) || (formula && !is_linear(*formula));
}

Density make_formula_density(const PolygonMesh& file, const PreparedMesh& mesh,
                             const DensityParameters& parameters, const CancelToken& cancel) {
  const Expression formula = formula_of(parameters);
  const bool unit_box = parameters.kind == DensityKind::unit_formula;
  const MeshVariables variables(file, mesh, {&formula, 1}, unit_box, cancel);
  const std::size_t count = mesh.triangle_count();
  const auto check = [&](std::size_t t, std::span<const std::array<double, 2>> weight,
                         std::span<double> value) {
    drop_rounding(value);
    if (std::ranges::all_of(value, is_density)) return;
    throw ItemError(Status::unreadable, problem_of(mesh, variables, formula, unit_box, t, weight, value));
  };
  Density density;
  if (is_linear(formula)) {
    constexpr std::array<std::array<double, 2>, 3> corners = {{{0, 0}, {1, 0}, {0, 1}}};
    density.corner.resize(3 * count);
    ordered_blocks(count, formula_block, [&](std::size_t begin, std::size_t end) {
      cancel.check();
      const std::span<double> values = std::span(density.corner).subspan(3 * begin, 3 * (end - begin));
      variables.evaluate_corners(formula, begin, end, values);
      for (std::size_t t = begin; t < end; ++t) check(t, corners, values.subspan(3 * (t - begin), 3));
    });
  } else {
    density = density_in_pieces(
        mesh, levels_of(mesh),
        [&](std::size_t t, std::span<const std::array<double, 2>> weight, std::span<double> value) {
          variables.evaluate(formula, t, weight, value);
          check(t, weight, value);
        },
        cancel);
  }
  if (std::ranges::none_of(triangle_masses(mesh, density), [](double mass) { return mass > 0; }))
    throw ItemError(Status::zero_density,
                    "the density `" + formula.text() + "` is zero on the whole surface");
  return density;
}

}  // namespace meander
