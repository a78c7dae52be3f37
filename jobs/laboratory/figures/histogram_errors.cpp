// Samples, errors, tables and plots of the histogram figures.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/json_writer.h"
#include "io/table/json_table.h"
#include "jobs/laboratory/figures/histogram_figures.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "kernels/analyse/lifted_area.h"
#include "kernels/analyse/nearest_points.h"
#include "kernels/density/curvature.h"
#include "kernels/describe/curved_samples.h"

namespace meander {

namespace {

// Charts for the largest sets that are drawn.
SampleParameters charting_parameters() {
  SampleParameters parameters = parameters_for("conformal");
  set_samples(parameters, 100000);
  return parameters;
}

}  // namespace

HistogramModel::HistogramModel(const FigureMesh& mesh, std::uint64_t seed_of_all)
    : name(mesh.name), charted(staged_model(mesh, charting_parameters())), seed(seed_of_all) {
  const PreparedMesh& surface = charted.surface;
  creased = crease_normals(surface.x, surface.y, surface.z, surface.triangles);
  vertex_area = vertex_curvature(surface).mixed_area;
  for (std::size_t v = 0; v < surface.vertex_count(); ++v)
    vertices.insert(vertices.end(), {surface.x[v], surface.y[v], surface.z[v]});
}

void HistogramModel::weigh_by_lifted_area() {
  const PreparedMesh& mesh = charted.surface;
  const std::vector<double> lifted = lifted_areas(mesh.x, mesh.y, mesh.z, mesh.triangles, creased);
  ScalarAttribute ratio{"lifted area / flat area", std::vector<double>(charted.file.polygon_count(), 1)};
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    if (mesh.area[t] > 0) ratio.values[mesh.polygon[t]] = lifted[t] / mesh.area[t];
  charted.file.face_attributes = {std::move(ratio)};
  parameters.density.kind = DensityKind::face_attribute;
  parameters.density.attribute = charted.file.face_attributes.front().name;
  charted.measure = measure_of(mesh, make_density(charted.file, mesh, parameters.density));
}

void HistogramModel::chart_isotropic_tensor() {
  const PolygonMesh& file = charted.file;
  FigureMesh mesh;
  mesh.name = name;
  for (std::size_t v = 0; v < file.vertex_count(); ++v)
    mesh.positions.insert(mesh.positions.end(), {file.x[v], file.y[v], file.z[v]});
  mesh.faces = file.corners;
  for (const HistogramMethod method : tensor_histogram_methods)
    tensor_charted.push_back(staged_model(mesh, parameters_of(*this, method)));
}

namespace {

struct HistogramSampling {
  const char* name;
  const char* charts;
  SequenceKind sequence;
};
// By the numbers of HistogramMethod.
constexpr HistogramSampling samplings[] = {
    {"low discrepancy", "conformal", SequenceKind::shifted},
    {"stratified", "conformal", SequenceKind::stratified},
    {"random", "conformal", SequenceKind::random},
    {"isotropic tensor", "isotropic tensor", SequenceKind::shifted},
    {"isotropic tensor by gradient", "isotropic tensor by gradient", SequenceKind::shifted},
    {"spaced", "conformal", SequenceKind::spaced}};

const HistogramSampling& sampling_of(HistogramMethod method) {
  return samplings[static_cast<std::size_t>(method)];
}

// Of low discrepancy, each on charts of its own.
constexpr HistogramMethod chart_methods[] = {HistogramMethod::shifted, HistogramMethod::tensor_metric,
                                             HistogramMethod::tensor_gradient};

const Model& charted_by(const HistogramModel& model, HistogramMethod method) {
  if (!follows_tensor(method)) return model.charted;
  return model.tensor_charted.at(method == HistogramMethod::tensor_gradient);
}

}  // namespace

const char* name_of(HistogramMethod method) { return sampling_of(method).name; }

bool follows_tensor(HistogramMethod method) {
  return method == HistogramMethod::tensor_metric || method == HistogramMethod::tensor_gradient;
}

SampleParameters parameters_of(const HistogramModel& model, HistogramMethod method) {
  SampleParameters parameters = model.parameters;
  parameters.place.sequence = sampling_of(method).sequence;
  if (!follows_tensor(method)) return parameters;
  parameters.method = parameters_for("anisotropic").method;
  parameters.tensor.kind = TensorKind::isotropic;
  parameters.seed = model.seed;
  if (method == HistogramMethod::tensor_gradient) {
    parameters.tensor_charts.form = AlignmentForm::gradient;
    parameters.tensor_charts.segment.count = 16;
  }
  return parameters;
}

MeshSamples draw_samples(const HistogramModel& model, HistogramMethod method, std::uint32_t count,
                         std::uint32_t run, const EmbreeDevice& device) {
  const auto number = static_cast<std::uint32_t>(method);
  const std::uint64_t seed = model.seed + (std::uint64_t{number} << 32) + (std::uint64_t{run} << 40);
  Row row = sampled_row(charted_by(model, method), parameters_of(model, method), count, seed, device);
  return {std::move(row.samples.triangle), std::move(row.samples.barycentric)};
}

namespace {

std::vector<double> points_of(const HistogramModel& model, const MeshSamples& samples,
                              std::span<const double> normals) {
  const PreparedMesh& mesh = model.charted.surface;
  return lift_samples(mesh.x, mesh.y, mesh.z, mesh.triangles, normals, samples.triangle, samples.barycentric);
}

std::vector<double> flat_positions(const HistogramModel& model, const MeshSamples& samples) {
  return points_of(model, samples, std::vector<double>(model.creased.size()));
}

std::vector<float> to_float(const std::vector<double>& values) { return {values.begin(), values.end()}; }

}  // namespace

std::vector<float> flat_points(const HistogramModel& model, const MeshSamples& samples) {
  return to_float(flat_positions(model, samples));
}

std::vector<float> curved_points(const HistogramModel& model, const MeshSamples& samples) {
  return to_float(points_of(model, samples, model.creased));
}

std::vector<std::uint32_t> nearest_vertices(const KdTree<3>& tree, const HistogramModel& model,
                                            const MeshSamples& samples) {
  return nearest_points(tree, flat_positions(model, samples));
}

void HistogramErrors::open(std::uint32_t count) {
  for (ErrorSeries* series : {&relative, &largest, &norm}) {
    series->counts.push_back(count);
    series->runs.emplace_back();
  }
}

void HistogramErrors::add(std::span<const double> measured, std::span<const double> ground_truth) {
  const HistogramError error = histogram_error(measured, ground_truth);
  relative.runs.back().push_back(error.relative);
  largest.runs.back().push_back(error.largest);
  norm.runs.back().push_back(error.norm);
}

namespace {

std::vector<double> runs_at(const ErrorSeries& series, std::uint32_t count) {
  const auto at = std::find(series.counts.begin(), series.counts.end(), static_cast<double>(count));
  if (at == series.counts.end()) return {};
  return series.runs[static_cast<std::size_t>(at - series.counts.begin())];
}

}  // namespace

std::vector<double> HistogramErrors::relative_at(std::uint32_t count) const {
  return runs_at(relative, count);
}

std::vector<double> HistogramErrors::largest_at(std::uint32_t count) const { return runs_at(largest, count); }

std::vector<double> HistogramErrors::norm_at(std::uint32_t count) const { return runs_at(norm, count); }

std::uint32_t histogram_runs(const FigureSet& figures, std::uint32_t count) {
  return figures.quick ? 5 : count <= 1000 ? 40 : count <= 20000 ? 5 : 3;
}

std::vector<std::uint32_t> histogram_counts(std::uint32_t most) {
  std::vector<std::uint32_t> counts;
  for (std::uint32_t decade = 100; decade <= most; decade *= 10)
    for (const std::uint32_t step : {1u, 2u, 5u})
      if (step * decade <= most) counts.push_back(step * decade);
  return counts;
}

Table histogram_error_table(const std::vector<HistogramErrors>& all) {
  Table table{{{"ground truth"},
               {"samples"},
               {"points"},
               {"runs"},
               {"relative"},
               {"its deviation", 2},
               {"its error", 2},
               {"largest"},
               {"deviation of largest", 2},
               {"error of largest", 2},
               {"root of squares"}},
              {}};
  for (const HistogramErrors& errors : all)
    for (std::size_t i = 0; i < errors.relative.counts.size(); ++i) {
      const Spread relative = spread_of(errors.relative.runs[i]), largest = spread_of(errors.largest.runs[i]);
      table.rows.push_back(
          {errors.truth, errors.method, static_cast<std::uint64_t>(errors.relative.counts[i]),
           errors.relative.runs[i].size(), relative.mean, relative.deviation, relative.error, largest.mean,
           largest.deviation, largest.error, spread_of(errors.norm.runs[i]).mean});
    }
  return table;
}

Plot histogram_plot(const std::string& title, const std::string& distance, const ShownHistograms& shown,
                    double range) {
  Plot plot;
  plot.title = title;
  plot.x.label = distance;
  plot.y = {"share of the pairs", AxisScale::linear, 0.0, {}};
  plot.width = 720;
  const auto add = [&](const char* name, const std::vector<double>& shares) -> PlotSeries& {
    PlotSeries series;
    series.name = name;
    series.style = SeriesStyle::steps;
    for (std::size_t b = 0; b <= shares.size(); ++b) {
      series.x.push_back(range * static_cast<double>(b) / static_cast<double>(shares.size()));
      series.y.push_back(shares[std::min(b, shares.size() - 1)]);
    }
    plot.series.push_back(std::move(series));
    return plot.series.back();
  };
  const auto add_truth = [&](const char* name, const std::vector<double>& shares, LineDash dash) {
    PlotSeries& series = add(name, shares);
    series.neutral = true;
    series.dash = dash;
    series.line_width = 2.4;
  };
  add_truth("all vertices", shown.alike, LineDash::dotted);
  add_truth("vertices by area", shown.by_area, LineDash::solid);
  for (std::size_t s = 0; s < shown.samples.size(); ++s)
    add(shown.samples[s].first.c_str(), shown.samples[s].second).colour = s;
  return plot;
}

Plot histogram_error_plot(const std::string& title, const std::vector<HistogramErrors>& all,
                          const std::string& truth, bool relative, std::size_t vertices) {
  std::vector<ErrorSeries> chosen;
  for (const HistogramErrors& errors : all)
    if (errors.truth == truth) chosen.push_back(relative ? errors.relative : errors.largest);
  Plot plot = error_plot(title, chosen, relative ? "relative error" : "largest error of a bin");
  if (vertices > 0)
    plot.guides.push_back({static_cast<double>(vertices), true, fmt::format("{} vertices", vertices)});
  plot.legend = LegendPlace::automatic;
  return plot;
}

namespace {

constexpr std::uint32_t table_points[] = {100, 500};

// Table 1 of the survey: points 100, then 500; low discrepancy, then random.
struct PublishedErrors {
  const char* model;  // what the names of its files start with
  double percent[2][2], largest[2][2];
};
constexpr PublishedErrors published_errors[] = {
    {"bunny", {{1.997, 2.250}, {1.068, 1.492}}, {{0.0086, 0.0090}, {0.0053, 0.0063}}},
    {"maxplanck", {{4.481, 5.485}, {4.024, 4.390}}, {{0.0159, 0.0177}, {0.0133, 0.0142}}},
    {"fandisk", {{1.463, 2.260}, {0.629, 1.121}}, {{0.0080, 0.0117}, {0.0033, 0.0036}}},
    {"hand", {{1.974, 2.543}, {1.316, 1.436}}, {{0.0073, 0.0087}, {0.0042, 0.0057}}},
};

const HistogramErrors* find_errors(const std::vector<HistogramErrors>& all, const std::string& truth,
                                   HistogramMethod method) {
  for (const HistogramErrors& errors : all)
    if (errors.truth == truth && errors.method == name_of(method)) return &errors;
  return nullptr;
}

// The kinds of charts that were measured against a truth.
std::vector<HistogramMethod> measured_charts(const std::vector<HistogramErrors>& all,
                                             const std::string& truth) {
  std::vector<HistogramMethod> methods;
  for (const HistogramMethod method : chart_methods)
    if (find_errors(all, truth, method) != nullptr) methods.push_back(method);
  return methods;
}

// Relative, largest and norm of a method at a number of points.
using Measured = std::array<Spread, 3>;
Measured measured(const std::vector<HistogramErrors>& all, const std::string& truth, HistogramMethod method,
                  std::uint32_t points) {
  const HistogramErrors* const errors = find_errors(all, truth, method);
  return {spread_of(errors->relative_at(points)), spread_of(errors->largest_at(points)),
          spread_of(errors->norm_at(points))};
}

// Of the conformal charts, random samples and those of the given charts.
struct Compared {
  Measured conformal, random, regular;
};
Compared compared(const std::vector<HistogramErrors>& all, const std::string& truth, HistogramMethod method,
                  std::uint32_t points) {
  return {measured(all, truth, HistogramMethod::shifted, points),
          measured(all, truth, HistogramMethod::random, points), measured(all, truth, method, points)};
}

}  // namespace

std::vector<std::string> published_models() {
  std::vector<std::string> names;
  for (const PublishedErrors& published : published_errors) names.emplace_back(published.model);
  return names;
}

Table table_one() {
  Table table{{{"model"},
               {"points"},
               {"ground truth"},
               {"charts"},
               {"low discrepancy %", 4},
               {"its error", 2},
               {"random %", 4},
               {"error of random", 2},
               {"gap", 2},
               {"largest", 3},
               {"error of largest", 2},
               {"random largest", 3},
               {"error of random largest", 2},
               {"largest gap", 2},
               {"root of squares %", 4},
               {"random root of squares %", 4},
               {"gap to conformal", 2}},
              {}};
  return table;
}

void add_to_table_one(Table& table, const std::string& model, const std::vector<HistogramErrors>& all,
                      const std::vector<std::string>& truths) {
  for (std::size_t k = 0; k < std::size(table_points); ++k) {
    const std::uint32_t points = table_points[k];
    for (const PublishedErrors& published : published_errors)
      if (model.starts_with(published.model))
        table.rows.push_back({model,
                              points,
                              "the survey's table 1",
                              {},
                              published.percent[k][0],
                              {},
                              published.percent[k][1],
                              {},
                              {},
                              published.largest[k][0],
                              {},
                              published.largest[k][1]});
    for (const std::string& truth : truths)
      for (const HistogramMethod method : measured_charts(all, truth)) {
        const Compared c = compared(all, truth, method, points);
        table.rows.push_back({model, points, truth, sampling_of(method).charts, 100 * c.regular[0].mean,
                              100 * c.regular[0].error, 100 * c.random[0].mean, 100 * c.random[0].error,
                              gap_of(c.random[0], c.regular[0]), c.regular[1].mean, c.regular[1].error,
                              c.random[1].mean, c.random[1].error, gap_of(c.random[1], c.regular[1]),
                              100 * c.regular[2].mean, 100 * c.random[2].mean});
        if (follows_tensor(method)) table.rows.back().emplace_back(gap_of(c.regular[0], c.conformal[0]));
      }
  }
}

Table claim_table() {
  return {{{"claim"},
           {"charts"},
           {"model"},
           {"points"},
           {"ground truth"},
           {"error"},
           {"holds"},
           {"low discrepancy"},
           {"random"},
           {"gap", 2},
           {"conformal"}},
          {}};
}

void add_claims(Table& table, const std::string& model, const std::vector<HistogramErrors>& all,
                const std::vector<std::string>& truths) {
  constexpr const char* measures[] = {"relative", "largest"};
  for (const std::string& truth : truths)
    for (const std::uint32_t points : table_points)
      for (const HistogramMethod method : measured_charts(all, truth)) {
        const Compared c = compared(all, truth, method, points);
        const char* const charts = sampling_of(method).charts;
        for (std::size_t m = 0; m < 2; ++m) {
          const double gap = gap_of(c.random[m], c.regular[m]);
          table.rows.push_back({"smaller error", charts, model, points, truth, measures[m],
                                gap > 2    ? "yes"
                                : gap < -2 ? "no"
                                           : "undecided",
                                c.regular[m].mean, c.random[m].mean, gap});
        }
        // The deviation of a run is known to 1 / sqrt(2 (runs - 1)); no more than an order is claimed.
        for (std::size_t m = 0; m < 2; ++m)
          table.rows.push_back({"smaller deviation over runs", charts, model, points, truth, measures[m],
                                c.regular[m].deviation < c.random[m].deviation ? "yes" : "no",
                                c.regular[m].deviation, c.random[m].deviation});
        for (std::size_t m = 0; m < 2 && follows_tensor(method); ++m) {
          const double gap = gap_of(c.regular[m], c.conformal[m]);
          table.rows.push_back({"equals conformal",
                                charts,
                                model,
                                points,
                                truth,
                                measures[m],
                                std::abs(gap) <= 2 ? "yes" : "no",
                                c.regular[m].mean,
                                {},
                                gap,
                                c.conformal[m].mean});
        }
      }
}

Table tensor_chart_table() {
  return {{{"model"},
           {"charts"},
           {"segments"},
           {"accepted share", 3},
           {"chart ratio", 4},
           {"overlap", 3},
           {"flips"}},
          {}};
}

void add_tensor_charts(Table& table, const HistogramModel& model) {
  for (const HistogramMethod method : tensor_histogram_methods) {
    const Model& charted = charted_by(model, method);
    const AnisotropyReport& found = charted.segments.report;
    table.rows.push_back({model.name, sampling_of(method).charts, found.segments, found.accepted_share,
                          found.mean_chart_ratio, charted.row.report.overlap, charted.row.report.flips});
  }
}

void write_json(FigureSet& figures, const std::string& stem,
                const std::vector<std::pair<std::string, Table>>& tables) {
  JsonWriter json;
  json.begin_object();
  for (const auto& [key, table] : tables) {
    json.key(key);
    write_table(json, table);
  }
  json.end_object();
  figures.data(stem + ".json", json.text() + "\n");
}

}  // namespace meander
