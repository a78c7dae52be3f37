// What remains of the error of a histogram of distances with many points: samples of chords and of the curved
// surface, on shapes whose histogram is known.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/table/text_table.h"
#include "jobs/laboratory/figures/histogram_figures.h"
#include "kernels/describe/distance_histogram.h"

namespace meander {

namespace {

// Shares of the distances between points of the unit sphere: their density on [0, 2] is d / 2.
std::vector<double> sphere_shares() {
  std::vector<double> shares;
  for (std::uint32_t b = 0; b < histogram_bins; ++b)
    shares.push_back((2 * b + 1) / static_cast<double>(histogram_bins * histogram_bins));
  return shares;
}

// The same for the torus of radii 1 and 0.5 on [0, 3]. Two circles around the axis, rho_1 and rho_2 from it
// and h apart in height, have the distances d^2 = rho_1^2 + rho_2^2 + h^2 - 2 rho_1 rho_2 cos(angle), the
// angle uniform; the mean over pairs of circles, weighted by rho_1 rho_2, is taken by the midpoint rule.
std::vector<double> torus_shares() {
  constexpr std::uint32_t circles = 1024;
  std::vector<double> cumulative(histogram_bins, 0), radius, height;
  for (std::uint32_t i = 0; i < circles; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / circles;
    radius.push_back(1 + 0.5 * std::cos(angle));
    height.push_back(0.5 * std::sin(angle));
  }
  for (std::uint32_t i = 0; i < circles; ++i)
    for (std::uint32_t j = i; j < circles; ++j) {
      const double rise = height[i] - height[j], twice = 2 * radius[i] * radius[j];
      const double squares = radius[i] * radius[i] + radius[j] * radius[j] + rise * rise;
      const double weight = (i == j ? 1 : 2) * radius[i] * radius[j];
      for (std::uint32_t b = 0; b < histogram_bins; ++b) {
        const double end = 3 * (b + 1.0) / histogram_bins;
        const double cosine = std::clamp((squares - end * end) / twice, -1.0, 1.0);
        cumulative[b] += weight * (cosine >= 1 ? 0 : cosine <= -1 ? 1 : std::acos(cosine) / std::numbers::pi);
      }
    }
  std::vector<double> shares;
  for (std::uint32_t b = 0; b < histogram_bins; ++b)
    shares.push_back((cumulative[b] - (b > 0 ? cumulative[b - 1] : 0)) / cumulative.back());
  return shares;
}

struct KnownShape {
  FigureMesh mesh;
  std::vector<double> shares;
  double range;  // of the bins, units of the mesh
};

}  // namespace

void draw_histogram_floors(FigureSet& figures) {
  figures.begin("Histograms of distances with many points: what remains of the error");
  const EmbreeDevice device;
  const KnownShape shapes[] = {{sphere_mesh(12), sphere_shares(), 2},
                               {torus_mesh(32, 16), torus_shares(), 3}};
  Table floors{{{"shape"},
                {"triangles"},
                {"samples"},
                {"points"},
                {"flat %", 3},
                {"its error", 2},
                {"curved %", 3},
                {"error of curved", 2},
                {"by lifted area %", 3},
                {"error of by area", 2},
                {"flat / by area", 3}},
               {}};
  const std::vector<std::uint32_t> counts = histogram_counts(figures.quick ? 10000 : 100000);
  for (const KnownShape& shape : shapes) {
    figures.note("  " + shape.mesh.name);
    const HistogramModel model(shape.mesh, figures.seed);
    HistogramModel by_area = model;
    by_area.weigh_by_lifted_area();
    DistanceHistogramParameters bins;
    bins.bins = histogram_bins;
    bins.range = shape.range / model.charted.surface.unit;
    const std::string truth = "closed form";
    std::vector<HistogramErrors> all;
    for (const HistogramMethod method : {HistogramMethod::shifted, HistogramMethod::random}) {
      HistogramErrors chords{truth, name_of(method) + std::string(", flat")},
          lifted{truth, name_of(method) + std::string(", curved")},
          even{truth, name_of(method) + std::string(", curved by area")};
      for (const std::uint32_t count : counts) {
        for (HistogramErrors* errors : {&chords, &lifted, &even}) errors->open(count);
        const std::uint32_t runs = figures.quick ? 3 : std::min(histogram_runs(figures, count), 5u);
        for (std::uint32_t run = 0; run < runs; ++run) {
          const MeshSamples samples = draw_samples(model, method, count, run, device);
          chords.add(distance_histogram(flat_points(model, samples), bins).shares, shape.shares);
          lifted.add(distance_histogram(curved_points(model, samples), bins).shares, shape.shares);
          const MeshSamples spread = draw_samples(by_area, method, count, run, device);
          even.add(distance_histogram(curved_points(by_area, spread), bins).shares, shape.shares);
        }
      }
      std::vector<TableCell> row = {shape.mesh.name, shape.mesh.faces.size() / 3, name_of(method),
                                    counts.back()};
      for (const HistogramErrors* errors : {&chords, &lifted, &even}) {
        const Spread spread = spread_of(errors->relative_at(counts.back()));
        row.insert(row.end(), {100 * spread.mean, 100 * spread.error});
      }
      row.emplace_back(row[4].number / row[8].number);
      floors.rows.push_back(std::move(row));
      for (HistogramErrors* errors : {&chords, &lifted, &even}) all.push_back(std::move(*errors));
    }
    for (const bool relative : {true, false})
      figures.plot(
          "histogram_floor_" + shape.mesh.name + (relative ? "_relative" : "_largest"),
          histogram_error_plot(
              fmt::format("{} of {} triangles", shape.mesh.name, shape.mesh.faces.size() / 3), all, truth,
              relative, 0),
          "Errors against the histogram of the smooth shape; means of 5 runs, 3 above 20,000 points");
    figures.data("histogram_floor_" + shape.mesh.name + ".csv", csv_text(histogram_error_table(all)));
  }
  figures.table("histogram_floors", "Relative errors at the largest number of points", floors);
  figures.note(text_table(floors));
  write_json(figures, "histogram_floors", {{"floors", floors}});
  figures.text(
      "Measured",
      "Samples of the chords keep the error of the tessellation, however many they are. Lifted by the "
      "vertex normals they keep that of their density, which is uniform on the flat triangles and so "
      "off by the square of edge x curvature: nothing on a sphere, a third of the error on a torus. "
      "Drawn by the lifted areas only the fourth order is left, 0.02 % here.");
  figures.text(
      "The survey",
      "It snaps samples to vertices and proposes, as future work, to project interior samples to the "
      "surface by its curvature.");
}

}  // namespace meander
