// What the histogram figures share: samples of a model in every form that is counted, errors of histograms.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/table/csv_writer.h"
#include "jobs/laboratory/figures/figure_models.h"
#include "jobs/laboratory/figures/staged_model.h"
#include "kernels/analyse/histogram_error.h"
#include "kernels/analyse/kd_tree.h"

namespace meander {

inline constexpr std::uint32_t histogram_bins = 32;  // the survey's

// A model whose samples are counted. Positions are in working units of the prepared mesh.
struct HistogramModel {
  std::string name;
  Model charted;
  // By the method anisotropic with the isotropic tensor: in its metric, along its directions.
  std::vector<Model> tensor_charted;
  std::vector<double> creased;                                // 9 T corner normals, split at creases
  SampleParameters parameters = parameters_for("conformal");  // but for points, sequence and seed
  std::vector<double> vertices;                               // 3 W
  std::vector<double> vertex_area;                            // W mixed areas
  std::uint64_t seed = 1;
  HistogramModel(const FigureMesh& mesh, std::uint64_t seed);
  // From now on samples are uniform on the lifted surface: their density is the area of the lifted triangle
  // over that of the flat one. The share of either differs by O((edge x curvature)^2).
  void weigh_by_lifted_area();
  // Makes the charts of the methods tensor_metric and tensor_gradient, for the uniform density.
  void chart_isotropic_tensor();
};

// The two methods of table 1, another low-discrepancy sequence, and the first one's on charts of the
// isotropic tensor, as the survey had them: conformal in its metric, and along its directions (16 segments);
// samples that keep their distance. They number the streams of randomness: new ones at the end.
enum class HistogramMethod : std::uint8_t {
  shifted,
  stratified,
  random,
  tensor_metric,
  tensor_gradient,
  spaced
};
inline constexpr HistogramMethod tensor_histogram_methods[] = {HistogramMethod::tensor_metric,
                                                               HistogramMethod::tensor_gradient};
inline constexpr HistogramMethod all_histogram_methods[] = {
    HistogramMethod::shifted,       HistogramMethod::random,          HistogramMethod::stratified,
    HistogramMethod::tensor_metric, HistogramMethod::tensor_gradient, HistogramMethod::spaced};
const char* name_of(HistogramMethod method);
bool follows_tensor(HistogramMethod method);
// What decides its samples, but for points and seed.
SampleParameters parameters_of(const HistogramModel& model, HistogramMethod method);

// Samples by triangle and weights of corners 1 and 2. Runs and methods share no randomness.
struct MeshSamples {
  std::vector<std::uint32_t> triangle;
  std::vector<float> barycentric;
};
inline constexpr std::uint32_t reference_run = 1000;  // of the many samples that others are compared with
MeshSamples draw_samples(const HistogramModel& model, HistogramMethod method, std::uint32_t count,
                         std::uint32_t run, const EmbreeDevice& device);
std::vector<float> flat_points(const HistogramModel& model, const MeshSamples& samples);
std::vector<float> curved_points(const HistogramModel& model, const MeshSamples& samples);
// The working vertex nearest to each sample.
std::vector<std::uint32_t> nearest_vertices(const KdTree<3>& tree, const HistogramModel& model,
                                            const MeshSamples& samples);

// Errors of histograms against a ground truth, over the number of points, several runs each (see
// HistogramError). norm is what table 1 could have under `relative`.
struct HistogramErrors {
  std::string truth, method;
  ErrorSeries relative, largest, norm;
  HistogramErrors(std::string against, std::string by)
      : truth(std::move(against)),
        method(std::move(by)),
        relative{method, {}, {}},
        largest{method, {}, {}},
        norm{method, {}, {}} {}
  void open(std::uint32_t count);
  void add(std::span<const double> measured, std::span<const double> ground_truth);
  // The runs at a number of points; empty where there are none.
  std::vector<double> relative_at(std::uint32_t count) const;
  std::vector<double> largest_at(std::uint32_t count) const;
  std::vector<double> norm_at(std::uint32_t count) const;
};

// Runs at a number of points: 40 to 1,000, 5 to 20,000, 3 above; 5 with --quick.
std::uint32_t histogram_runs(const FigureSet& figures, std::uint32_t count);
// 100, 200, 500, 1000, ... up to `most`.
std::vector<std::uint32_t> histogram_counts(std::uint32_t most);
// Truth, method, points, runs; mean, deviation and standard error of both errors.
Table histogram_error_table(const std::vector<HistogramErrors>& all);
// Histograms as steps over [0, range]: the ground truths over all vertices and by area, and sets of samples
// by the names of their methods.
struct ShownHistograms {
  std::vector<double> alike, by_area;
  std::vector<std::pair<std::string, std::vector<double>>> samples;
};
Plot histogram_plot(const std::string& title, const std::string& distance, const ShownHistograms& shown,
                    double range);
// The error plot of one ground truth, with a line at the number of vertices (0: none).
Plot histogram_error_plot(const std::string& title, const std::vector<HistogramErrors>& all,
                          const std::string& truth, bool relative, std::size_t vertices);

// What the names of the survey's models start with.
std::vector<std::string> published_models();
// Rows of table 1 and the claims that they bear out or not, for one model: low discrepancy samples on every
// kind of charts against random ones, and those of the isotropic tensor against the conformal ones.
Table table_one();
void add_to_table_one(Table& table, const std::string& model, const std::vector<HistogramErrors>& all,
                      const std::vector<std::string>& truths);
Table claim_table();
void add_claims(Table& table, const std::string& model, const std::vector<HistogramErrors>& all,
                const std::vector<std::string>& truths);
// What the charts of the isotropic tensor came to.
Table tensor_chart_table();
void add_tensor_charts(Table& table, const HistogramModel& model);
// Writes tables as members of one JSON object, linked from the page.
void write_json(FigureSet& figures, const std::string& stem,
                const std::vector<std::pair<std::string, Table>>& tables);

}  // namespace meander
