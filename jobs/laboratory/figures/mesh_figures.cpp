// Figures 4 (meshes) and 21: samplings of meshes and distances between meshes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "jobs/laboratory/figures/figure_models.h"
#include "jobs/laboratory/figures/figure_set.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/discrepancy_rings.h"
#include "kernels/analyse/mesh_distance.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

void draw_one_mesh(FigureSet& figures, const FigureMesh& mesh, const EmbreeDevice& device) {
  const std::uint32_t most = figures.quick ? 1536 : 24576, runs = 3;
  SampleParameters conformal = parameters_for("conformal");
  const SampleParameters direct = parameters_for("direct");
  set_samples(conformal, most);
  SampleParameters vertex = conformal, random = conformal;
  vertex.locate = LocatorKind::first_hit;
  vertex.place.place = PlaceKind::vertex;
  vertex.locator.curve.leaves_per_sample = 64;
  random.place.sequence = SequenceKind::random;
  const Model charted = staged_model(mesh, conformal), plain = staged_model(mesh, direct),
              located = staged_model(mesh, vertex);
  const PreparedMesh& surface = charted.surface;
  std::vector<std::uint32_t> triangle_of(mesh.faces.size() / 3, 0);
  for (std::size_t t = 0; t < surface.polygon.size(); ++t)
    triangle_of[surface.polygon[t]] = static_cast<std::uint32_t>(t);
  BoxParameters box_parameters;
  box_parameters.boxes = figures.quick ? 200 : 1000;
  box_parameters.seed = figures.seed;
  const std::vector<RotatedBox> boxes =
      random_boxes(surface.x, surface.y, surface.z, surface.triangles, box_parameters);
  if (boxes.empty()) throw ItemError(Status::zero_area, "hardly any box holds a share of the surface");
  double variance = 0;  // of the indicator, mean over the boxes
  for (const RotatedBox& box : boxes)
    variance += box.share * (1 - box.share) / static_cast<double>(boxes.size());
  const VertexTriangles around =
      triangles_around_vertices(surface.triangles, static_cast<std::uint32_t>(surface.x.size()));
  const std::vector<std::uint32_t> seeds =
      ring_seeds(surface.triangles, figures.quick ? 32 : 256, figures.seed);

  std::vector<ErrorSeries> box_errors, ring_errors;
  const auto measure = [&](const char* name, const Model& model, const SampleParameters& parameters) {
    figures.note(fmt::format("  {}", name));
    ErrorSeries by_boxes{name, {}, {}}, by_rings{name, {}, {}};
    for (const std::uint32_t count : survey_counts(most, 32)) {
      by_boxes.counts.push_back(count);
      by_rings.counts.push_back(count);
      by_boxes.runs.emplace_back();
      by_rings.runs.emplace_back();
      for (std::uint32_t run = 0; run < runs; ++run) {
        const Row row = sampled_row(model, parameters, count, figures.seed + run, device);
        std::vector<std::uint32_t> hits(surface.triangle_count(), 0);
        for (const std::uint32_t face : row.samples.face) ++hits[triangle_of[face]];
        const std::vector<double> points = working_points(row.report, row.samples.points, surface);
        by_boxes.runs.back().push_back(box_error_ratio(boxes, points) *
                                       std::sqrt(variance / static_cast<double>(count)));
        by_rings.runs.back().push_back(
            ring_discrepancy(surface.triangles, around, surface.area, hits, seeds).discrepancy);
      }
    }
    box_errors.push_back(std::move(by_boxes));
    ring_errors.push_back(std::move(by_rings));
  };
  measure("random", charted, random);
  measure("conformal", charted, conformal);
  measure("direct", plain, direct);
  measure("curve vertices, first hit", located, vertex);
  const std::string stem = "figure04_mesh_" + mesh.name;
  figures.plot(stem + "_boxes",
               error_plot(mesh.name + ": rotated boxes", box_errors, "RMS error of the share"),
               fmt::format("{} boxes with exactly clipped areas", boxes.size()));
  figures.plot(stem + "_rings", error_plot(mesh.name + ": rings of triangles", ring_errors, "discrepancy"),
               fmt::format("Patches grown ring by ring from {} triangles", seeds.size()));
  figures.table(stem + "_boxes_slopes", "Boxes: slopes from 32 points", slope_table(box_errors, 32, {1024}));
  figures.table(stem + "_rings_slopes", "Rings: slopes from 32 points", slope_table(ring_errors, 32, {1024}));
  figures.text("Measured",
               "Means of three runs. Boxes do not know the triangulation; rings have borders as ragged "
               "as the triangles are large, which flattens their slope on coarse meshes.");
  figures.text("The survey",
               "Samples of meshes have the rate of the plane, measured on ring-grown patches; it "
               "places them at curve vertices that rays locate.");
}

}  // namespace

void draw_mesh_discrepancy(FigureSet& figures) {
  const EmbreeDevice device;
  for (const FigureMesh& mesh : figures.meshes) {
    figures.begin("Figure 4, mesh: " + mesh.name);
    figures.attempt(mesh.name, [&] { draw_one_mesh(figures, mesh, device); });
  }
}

void draw_mesh_distances(FigureSet& figures) {
  figures.begin("Figure 21: distance between a surface and its approximation");
  const EmbreeDevice device;
  // A sphere by latitude and longitude: its own triangulations, against a fine one.
  const auto sphere = [](std::uint32_t rings) {
    FigureMesh mesh;
    const std::uint32_t sectors = 2 * rings;
    for (std::uint32_t i = 0; i <= rings; ++i)
      for (std::uint32_t j = 0; j < sectors; ++j) {
        const double polar = std::numbers::pi * i / rings, around = 2 * std::numbers::pi * j / sectors;
        mesh.positions.insert(mesh.positions.end(), {std::sin(polar) * std::cos(around),
                                                     std::sin(polar) * std::sin(around), std::cos(polar)});
      }
    for (std::uint32_t i = 0; i < rings; ++i)
      for (std::uint32_t j = 0; j < sectors; ++j) {
        const std::uint32_t a = i * sectors + j, b = i * sectors + (j + 1) % sectors, c = a + sectors,
                            d = b + sectors;
        if (i > 0) mesh.faces.insert(mesh.faces.end(), {a, c, b});
        if (i + 1 < rings) mesh.faces.insert(mesh.faces.end(), {b, c, d});
      }
    return mesh;
  };
  const auto arrays = [](const FigureMesh& mesh) {
    std::array<std::vector<double>, 3> at;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) at[i % 3].push_back(mesh.positions[i]);
    return at;
  };
  const FigureMesh fine = sphere(figures.quick ? 256 : 512);
  const auto fine_at = arrays(fine);
  ErrorSeries mean{"mean", {}, {}}, rms{"RMS", {}, {}}, largest{"largest", {}, {}};
  for (std::uint32_t rings = 8; rings <= 64; rings *= 2) {
    const FigureMesh coarse = sphere(rings);
    const auto at = arrays(coarse);
    MeshDistanceParameters parameters;
    parameters.samples = figures.quick ? 20000 : 200000;
    parameters.seed = figures.seed;
    const MeshDistance distance = mesh_distance(device, {at[0], at[1], at[2], coarse.faces},
                                                {fine_at[0], fine_at[1], fine_at[2], fine.faces}, parameters);
    for (ErrorSeries* series : {&mean, &rms, &largest})
      series->counts.push_back(static_cast<double>(coarse.faces.size() / 3));
    mean.runs.push_back({distance.percent(distance.forward.mean)});
    rms.runs.push_back({distance.percent(distance.forward.rms)});
    largest.runs.push_back({distance.percent(distance.max())});
  }
  Plot plot = error_plot("Triangulated sphere against a fine one", {mean, rms, largest}, "% of the diagonal");
  plot.x.label = "triangles";
  figures.plot("figure21_mesh_distance", plot, "Sampled distances with exact nearest points");
  figures.table("figure21_mesh_distance_slopes", "Slopes", slope_table({mean, rms, largest}, 1, {}));
  figures.text("Measured",
               "Mean, root mean square and largest distance from the coarse to the fine sphere; the "
               "largest over both directions. All fall as 1 / triangles.");
  figures.text("The survey",
               "Its equation (1) is the mean one-sided distance, which it reports under the name of "
               "Hausdorff; here the three are told apart.");
}

}  // namespace meander
