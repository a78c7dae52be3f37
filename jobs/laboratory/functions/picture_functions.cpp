// Pictures of surfaces with marks on them.
#include <cmath>
#include <stdexcept>

#include "io/plot/color.h"
#include "jobs/laboratory/functions/laboratory_functions.h"
#include "kernels/render/default_view.h"
#include "kernels/render/sampled_surface.h"

namespace meander {

namespace {

SrgbColor color_at(std::span<const std::uint8_t> colors, std::size_t i) {
  const std::size_t at = colors.size() == 3 ? 0 : 3 * i;
  if (at + 3 > colors.size()) throw std::invalid_argument("there are too few colors");
  return {colors[at], colors[at + 1], colors[at + 2]};
}

double width_at(std::span<const double> widths, std::size_t i) {
  if (widths.size() != 1 && i >= widths.size()) throw std::invalid_argument("there are too few widths");
  return widths[widths.size() == 1 ? 0 : i];
}

Vector3 vector_at(std::span<const double> values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

Vector3 direction(const LaboratoryArguments& given, const char* name, Vector3 otherwise) {
  if (!given.has(name)) return otherwise;
  const std::span<const double> values = given.reals(name);
  if (values.size() != 3) throw std::invalid_argument(std::string(name) + " must be three numbers");
  return vector_at(values, 0);
}

SurfacePictureParameters look_of(const LaboratoryArguments& given) {
  SurfacePictureParameters look;
  look.size = static_cast<std::uint32_t>(given.whole("size", look.size));
  look.margin = given.real("margin", look.margin);
  look.crease = given.real("crease", look.crease);
  look.view = direction(given, "view", look.view);
  look.up = direction(given, "up", look.up);
  return look;
}

// Takes vertices (V, 3), faces (T, 3) and, optionally, face_colors (T, 3); lines (L, 6) from x y z to x y z,
// line_colors, line_widths in pixels; discs (D, 9), center and two half-axes, disc_colors; dots (P, 3),
// dot_colors, dot_radii in pixels. Colors are uint8; one color (1, 3) or width (1,) applies to all. size,
// margin, crease, view, up: see surface_picture.h. Returns image (size, size, 3) as rows of pixels.
LaboratoryResult picture(const LaboratoryArguments& given) {
  SurfaceScene scene{given.reals("vertices", 3), given.numbers("faces", 3), {}};
  if (given.has("face_colors")) {
    const std::span<const std::uint8_t> colors = given.bytes("face_colors", 3);
    for (std::size_t t = 0; t < scene.faces.size() / 3; ++t) scene.face_colors.push_back(color_at(colors, t));
  }
  if (given.has("lines")) {
    const std::span<const double> lines = given.reals("lines", 6), widths = given.reals("line_widths");
    const std::span<const std::uint8_t> colors = given.bytes("line_colors", 3);
    for (std::size_t i = 0; i < lines.size() / 6; ++i)
      scene.lines.push_back(
          {vector_at(lines, 2 * i), vector_at(lines, 2 * i + 1), width_at(widths, i), color_at(colors, i)});
  }
  if (given.has("discs")) {
    const std::span<const double> discs = given.reals("discs", 9);
    const std::span<const std::uint8_t> colors = given.bytes("disc_colors", 3);
    for (std::size_t i = 0; i < discs.size() / 9; ++i)
      scene.ellipses.push_back({vector_at(discs, 3 * i), vector_at(discs, 3 * i + 1),
                                vector_at(discs, 3 * i + 2), color_at(colors, i)});
  }
  if (given.has("dots")) {
    const std::span<const double> dots = given.reals("dots", 3), radii = given.reals("dot_radii");
    const std::span<const std::uint8_t> colors = given.bytes("dot_colors", 3);
    for (std::size_t i = 0; i < dots.size() / 3; ++i)
      scene.dots.push_back({vector_at(dots, i), width_at(radii, i), color_at(colors, i)});
  }
  LaboratoryResult result;
  result.add("image", surface_picture(scene, look_of(given)).pixels);
  return result;
}

// Returns view (3,), from a model whose axis `up` (x, y or z) points up towards the eye.
LaboratoryResult view_by_default(const LaboratoryArguments& given) {
  const std::string up = given.text("up");
  if (up != "x" && up != "y" && up != "z") throw std::invalid_argument("up must be x, y or z");
  const auto [x, y, z] = default_view_of(up.front());
  LaboratoryResult result;
  result.add("view", std::vector<double>{x, y, z});
  return result;
}

// Returns colors (n, 3), as many of the palette as are distinct.
LaboratoryResult palette(const LaboratoryArguments&) {
  std::vector<std::uint8_t> colors;
  for (std::size_t i = 0; i < distinct_colors; ++i) {
    const auto [red, green, blue] = palette_color(i);
    colors.insert(colors.end(), {red, green, blue});
  }
  LaboratoryResult result;
  result.add("colors", std::move(colors), 3);
  return result;
}

constexpr LaboratoryFunction picture_table[] = {
    {"picture", picture}, {"default_view", view_by_default}, {"palette", palette}};

}  // namespace

const std::span<const LaboratoryFunction> picture_functions = picture_table;

}  // namespace meander
