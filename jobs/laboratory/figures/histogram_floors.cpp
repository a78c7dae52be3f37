// What remains of the error of a histogram of distances with many points: samples of chords and of the curved
// surface, on shapes whose histogram is known.
#include <fmt/format.h>

#include <algorithm>

#include "io/table/text_table.h"
#include "jobs/laboratory/figures/histogram_figures.h"
#include "kernels/analyse/distance_shares.h"
#include "kernels/describe/distance_histogram.h"

namespace meander {

namespace {

struct KnownShape {
  FigureMesh mesh;
  std::vector<double> shares;
  double range;  // of the bins, units of the mesh
};

}  // namespace

void draw_histogram_floors(FigureSet& figures) {
  figures.begin("Histograms of distances with many points: what remains of the error");
  const EmbreeDevice device;
  const KnownShape shapes[] = {{sphere_mesh(12), sphere_distance_shares(histogram_bins), 2},
                               {torus_mesh(32, 16), torus_distance_shares(histogram_bins, 0.5), 3}};
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
