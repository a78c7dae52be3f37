// Point sets beside each other on solid models.
#include "jobs/laboratory/figures/spaced_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "io/plot/picture_row.h"
#include "kernels/render/sampled_surface.h"

namespace meander {

namespace {

// Small discs painted on the surface, in parts of sqrt(area / n).
constexpr double disc_radius = 0.22;
constexpr SrgbColour disc_colour = {196, 62, 28};

RgbImage set_picture(const FigureMesh& mesh, const PreparedMesh& surface, const ComparedSet& set,
                     std::uint32_t size) {
  const std::size_t count = set.points.size() / 3;
  const double radius =
      disc_radius * surface.unit * std::sqrt(surface.total_area / static_cast<double>(count));
  const std::array<double, 3> centre = {surface.centre.x, surface.centre.y, surface.centre.z};
  std::vector<double> points(3 * count);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = centre[i % 3] + surface.unit * set.points[i];
  const std::vector<float> normals(set.normals.begin(), set.normals.end());
  SurfacePictureParameters look;
  look.size = size;
  return sampled_surface_picture(
      {mesh.positions, mesh.faces, points, normals, std::span(&disc_colour, 1), std::span(&radius, 1)}, look);
}

// Pictures of one view cut to what is painted in any of them.
void trim(std::vector<CaptionedPicture>& pictures) {
  const std::uint32_t width = pictures.front().image.width, height = pictures.front().image.height;
  std::uint32_t left = width, right = 0, top = height, bottom = 0;
  for (const CaptionedPicture& picture : pictures)
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; ++x) {
        const std::uint8_t* pixel = picture.image.pixel(x, y);
        if (pixel[0] == 255 && pixel[1] == 255 && pixel[2] == 255) continue;
        left = std::min(left, x);
        right = std::max(right, x + 1);
        top = std::min(top, y);
        bottom = std::max(bottom, y + 1);
      }
  if (left >= right) return;
  for (CaptionedPicture& picture : pictures) {
    RgbImage cut(right - left, bottom - top);
    for (std::uint32_t y = 0; y < cut.height; ++y)
      std::copy_n(picture.image.pixel(left, top + y), std::size_t{3} * cut.width, cut.pixel(0, y));
    picture.image = std::move(cut);
  }
}

void draw_on(FigureSet& figures, const FigureMesh& mesh) {
  constexpr std::uint32_t count = 1500;
  const std::uint32_t sets = figures.quick ? 4 : 16;
  const ComparedModel model(mesh, count);
  const std::vector<RotatedBox> boxes = model.boxes(figures.quick ? 200 : 1000, figures.seed);
  std::vector<CaptionedPicture> pictures;
  Table table{{{"samples"}, {"points"}, {"sets"}, {"rho", 3}, {"least rho", 3}, {"error", 3}}, {}};
  const auto add = [&](std::size_t method, const char* title, const char* how) {
    figures.note(fmt::format("  {}", title));
    SetMeasures measures;
    ComparedSet first;
    for (std::uint32_t s = 0; s < sets; ++s) {
      ComparedSet set = model.set(compared_methods[method], count, figures.seed + s);
      measures.add(model, boxes, set);
      if (s == 0) first = std::move(set);
    }
    pictures.push_back(
        {set_picture(mesh, model.surface(), first, figures.quick ? 280 : 460),
         title,
         {how, fmt::format("rho {:.2f}    error {:.2f}", measures.mean_rho(), measures.error())}});
    table.rows.push_back({compared_methods[method].name, count, sets, measures.mean_rho(), measures.least_rho,
                          measures.error()});
  };
  add(random_method, "random", "independent points");
  add(eliminated_method, "Poisson disk", "sample elimination");
  add(spaced_method, "spaced", "--sequence spaced --order curve");
  trim(pictures);
  PictureRowParameters look;
  look.gap = 30;
  look.title_size = 24;
  look.line_size = 17;
  const std::string stem = "spaced_sets_" + mesh.name;
  figures.picture(stem, picture_row(pictures, look), fmt::format("{} points on {}", count, mesh.name));
  figures.table(stem, fmt::format("Means of {} sets: the first of each is drawn", sets), table);
}

}  // namespace

void draw_spaced_sets(FigureSet& figures) {
  figures.begin("Spaced samples beside others");
  for (const FigureMesh& mesh : figures.meshes) figures.attempt(mesh.name, [&] { draw_on(figures, mesh); });
  figures.text(
      "Shown",
      "Random samples; Poisson disk samples, of sample elimination; samples of the sequence `spaced`. "
      "rho: smallest distance over that of the hexagonal lattice. Error: root mean square over rotated "
      "boxes, that of random samples being 1.");
}

}  // namespace meander
