// Figures 22 to 24 and table 1: histograms of the distances between samples, and their errors.
#include "jobs/laboratory/figures/histogram_figures.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/table/text_table.h"
#include "kernels/describe/distance_histogram.h"

namespace meander {

namespace {

const std::string published = "all vertices", deduplicated = "all vertices, no duplicates",
                  weighted = "vertices by area", curved = "curved surface",
                  flat = "curved surface, flat samples";
const std::vector<std::string> table_truths = {published, weighted, curved};

std::vector<float> positions_of(const HistogramModel& model, const std::vector<std::uint32_t>& vertices) {
  std::vector<float> points;
  points.reserve(3 * vertices.size());
  for (const std::uint32_t v : vertices)
    for (std::size_t k = 0; k < 3; ++k)
      points.push_back(static_cast<float>(model.vertices[3 * std::size_t{v} + k]));
  return points;
}

// In figures 22 and 23.
bool is_shown(HistogramMethod method) { return method != HistogramMethod::stratified; }

struct ModelHistograms {
  std::vector<HistogramErrors> errors;
  std::vector<TableCell> floors;
};

ModelHistograms draw_one_model(FigureSet& figures, const FigureMesh& mesh, const EmbreeDevice& device,
                               Table& tensor_charts) {
  HistogramModel model(mesh, figures.seed);
  model.chart_isotropic_tensor();
  add_tensor_charts(tensor_charts, model);
  const std::size_t vertices = model.charted.surface.vertex_count();
  const KdTree<3> tree(model.vertices);

  // The ground truths, all over the bins of the vertices' largest distance.
  DistanceHistogramParameters bins;
  bins.bins = histogram_bins;
  const DistanceHistogram of_vertices =
      distance_histogram(std::vector<float>(model.vertices.begin(), model.vertices.end()), bins);
  bins.range = of_vertices.range;
  const DistanceHistogram of_areas = weighted_distance_histogram(model.vertices, model.vertex_area, bins);
  const std::uint32_t many = figures.quick ? 20000 : 400000;
  const DistanceHistogram of_surface = distance_histogram(
      curved_points(model, draw_samples(model, HistogramMethod::shifted, many, reference_run, device)), bins);
  figures.note("  ground truths made");

  std::vector<HistogramErrors> all;
  ShownHistograms shown{of_vertices.shares, of_areas.shares, {}};  // one run of samples each
  constexpr std::uint32_t shown_points = 100;
  const std::vector<std::uint32_t> counts = histogram_counts(figures.quick ? 2000 : 100000);
  for (const HistogramMethod method : all_histogram_methods) {
    figures.note(fmt::format("  {}", name_of(method)));
    HistogramErrors snapped{published, name_of(method)}, unique{deduplicated, name_of(method)},
        by_area{weighted, name_of(method)}, on_surface{curved, name_of(method)},
        on_chords{flat, name_of(method)};
    for (const std::uint32_t count : counts) {
      // Snapped samples have reached their floor long before; and flat ones are compared by one method.
      const bool snap = count <= 20000, on_flat = method == HistogramMethod::shifted;
      if (snap)
        for (HistogramErrors* errors : {&snapped, &by_area}) errors->open(count);
      const bool deduplicate = snap && !follows_tensor(method);
      if (deduplicate) unique.open(count);
      on_surface.open(count);
      if (on_flat) on_chords.open(count);
      const std::uint32_t runs = histogram_runs(figures, count);
      for (std::uint32_t run = 0; run < runs; ++run) {
        const MeshSamples samples = draw_samples(model, method, count, run, device);
        on_surface.add(distance_histogram(curved_points(model, samples), bins).shares, of_surface.shares);
        if (on_flat)
          on_chords.add(distance_histogram(flat_points(model, samples), bins).shares, of_surface.shares);
        if (!snap) continue;
        std::vector<std::uint32_t> nearest = nearest_vertices(tree, model, samples);
        const std::vector<double> shares = distance_histogram(positions_of(model, nearest), bins).shares;
        snapped.add(shares, of_vertices.shares);
        by_area.add(shares, of_areas.shares);
        if (run == 0 && count == shown_points && is_shown(method))
          shown.samples.emplace_back(name_of(method), shares);
        if (!deduplicate) continue;
        std::sort(nearest.begin(), nearest.end());
        nearest.erase(std::unique(nearest.begin(), nearest.end()), nearest.end());
        if (nearest.size() > 1)
          unique.add(distance_histogram(positions_of(model, nearest), bins).shares, of_vertices.shares);
      }
    }
    for (HistogramErrors* errors : {&snapped, &unique, &by_area, &on_surface, &on_chords})
      all.push_back(std::move(*errors));
  }

  const double range = bins.range * model.charted.surface.unit;
  const Plot histograms = histogram_plot(mesh.name + fmt::format(": distances, {} samples", shown_points),
                                         "distance", shown, range);
  figures.plot("figure22_histograms_" + mesh.name, histograms,
               "Ground truths over the vertices, and one set of each kind, snapped to vertices");

  // With ever more samples their snapped histogram goes to that of the vertices by area.
  const HistogramError floor = histogram_error(of_areas.shares, of_vertices.shares);
  std::vector<HistogramErrors> as_published;
  for (const HistogramErrors& errors : all)
    if (errors.truth == published && errors.method != name_of(HistogramMethod::stratified))
      as_published.push_back(errors);
  for (const HistogramErrors& errors : all)
    if (errors.truth == deduplicated && !errors.relative.counts.empty() &&
        errors.method != name_of(HistogramMethod::stratified)) {
      as_published.push_back(errors);
      as_published.back().truth = published;
      for (ErrorSeries* series : {&as_published.back().relative, &as_published.back().largest})
        series->name += ", no duplicates";
    }
  std::vector<HistogramErrors> on_curved;
  for (const HistogramErrors& errors : all)
    if (errors.truth == curved) on_curved.push_back(errors);
  for (const HistogramErrors& errors : all)
    if (errors.truth == flat && errors.method == name_of(HistogramMethod::shifted)) {
      on_curved.push_back(errors);
      on_curved.back().truth = curved;
      for (ErrorSeries* series : {&on_curved.back().relative, &on_curved.back().largest})
        series->name += ", flat";
    }
  for (const bool relative : {true, false}) {
    const std::string suffix = mesh.name + (relative ? "_relative" : "_largest");
    Plot plot =
        histogram_error_plot(mesh.name + ": as published", as_published, published, relative, vertices);
    plot.guides.push_back({relative ? floor.relative : floor.largest, false, "vertices by area"});
    figures.plot("figure23_published_" + suffix, plot,
                 "Samples snapped to vertices against all pairs of vertices; the line is where they go");
    figures.plot("figure24_weighted_" + suffix,
                 histogram_error_plot(mesh.name + ": vertices weighted by their area", all, weighted,
                                      relative, vertices),
                 "Samples snapped to vertices against vertices weighted by area");
    figures.plot(
        "figure24_curved_" + suffix,
        histogram_error_plot(mesh.name + ": samples on the curved surface", on_curved, curved, relative, 0),
        fmt::format("Samples lifted to the curved surface against {} others", many));
  }
  figures.data("figure24_errors_" + mesh.name + ".csv", csv_text(histogram_error_table(all)));

  std::vector<TableCell> floors = {mesh.name, vertices, 100 * floor.relative};
  for (const std::string& truth : {published, deduplicated, weighted, flat, curved})
    for (const HistogramErrors& errors : all)
      if (errors.truth == truth && errors.method == name_of(HistogramMethod::shifted)) {
        floors.emplace_back(static_cast<std::uint64_t>(errors.relative.counts.back()));
        floors.emplace_back(100 * spread_of(errors.relative.runs.back()).mean);
      }
  figures.text(
      "Measured",
      "Means and standard errors over 40 runs to 1,000 points, 5 to 20,000, 3 above (5 throughout with "
      "--quick). Every run of every method has randomness of its own.");
  return {std::move(all), std::move(floors)};
}

}  // namespace

void draw_distance_histograms(FigureSet& figures) {
  const EmbreeDevice device;
  Table table = table_one(), claims = claim_table(), charts = tensor_chart_table();
  Table floors{{{"model"}, {"vertices"}, {"vertices by area from all %", 3}}, {}};
  for (const char* truth :
       {"all vertices", "no duplicates", "vertices by area", "flat from curved", "curved"}) {
    floors.columns.push_back({fmt::format("points of {}", truth)});
    floors.columns.push_back({fmt::format("{} %", truth), 3});
  }
  for (const FigureMesh& mesh : figures.meshes) {
    figures.begin("Figures 22 to 24, distances between samples: " + mesh.name);
    figures.attempt(mesh.name, [&] {
      ModelHistograms histograms = draw_one_model(figures, mesh, device, charts);
      add_to_table_one(table, mesh.name, histograms.errors, table_truths);
      add_claims(claims, mesh.name, histograms.errors, table_truths);
      floors.rows.push_back(std::move(histograms.floors));
    });
  }
  figures.begin("Table 1: errors of the histograms of distances");
  std::string missing;
  for (const std::string& name : published_models()) {
    const auto is_model = [&](const FigureMesh& mesh) { return mesh.name.starts_with(name); };
    if (std::none_of(figures.meshes.begin(), figures.meshes.end(), is_model))
      missing += (missing.empty() ? "" : ", ") + name;
  }
  if (!missing.empty())
    figures.text("Skipped", "models of the survey that --models does not name: " + missing);
  figures.table("table1_histograms",
                "Errors at 100 and 500 points; gap: random - low discrepancy in standard errors", table);
  figures.table("table1_floors", "Relative error of low discrepancy samples at the largest number of points",
                floors);
  figures.table("table1_claims", "Claims, decided at two standard errors of the difference", claims);
  figures.table("table1_charts", "Charts of the isotropic tensor", charts);
  write_json(figures, "table1",
             {{"errors", table}, {"floors", floors}, {"claims", claims}, {"charts", charts}});
  figures.note(text_table(table));
  figures.note(text_table(floors));
  figures.text(
      "Ground truths",
      "All vertices: as published, samples snapped to their nearest vertex (with multiplicity) against "
      "all pairs of vertices. Vertices by area: the same samples against pairs weighted by their mixed "
      "areas, to which samples of the surface converge. Curved surface: samples lifted to the surface "
      "that the normals tell of, not snapped, against many of them. All have 32 bins on the largest "
      "distance of the vertices.");
  figures.text(
      "Charts",
      "The survey sampled by its anisotropic algorithm with the isotropic tensor. Isotropic tensor: charts "
      "conformal in its metric, one a component to begin with. Isotropic tensor by gradient: along its "
      "directions, from 16 segments. Both equal the conformal charts where the gap is within two standard "
      "errors; one comparison in twenty of equal methods is not.");
  figures.text(
      "The survey",
      "Low discrepancy samples have smaller errors than random ones at 100 and 500 points. Its percentages "
      "cannot be sums of absolute errors of histograms of sum 1, of which the largest error is at most half: "
      "three of its rows have more. They have the size of the root of the sum of squares, which stands in "
      "the "
      "last columns; its largest errors have the size of ours.");
}

}  // namespace meander
