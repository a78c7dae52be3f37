#include "pipeline/work_estimate.h"

#include <algorithm>
#include <cmath>

namespace meander {

namespace {

constexpr double bytes_per_triangle = 30;

// Seconds of a model, of each of its samples, of each of its triangles, and of each sqrt(triangles x
// samples): triangles are cut by the cells of samples.
struct WorkCosts {
  double model, sample, triangle, cut;
};

WorkCosts costs_of(const SampleParameters& parameters) {
  const double samples = parameters.samples;
  WorkCosts costs = {1e-3, 0.4e-6, 0.4e-6, 0};  // direct
  if (parameters.method == MethodChoice::anisotropic)
    costs = {1e-3, 3.5e-6, 3e-6, 2.5e-6};
  else if (method_of(parameters).makes_charts)
    costs = {1e-3, 2e-6, 2e-6, 2.5e-6};
  else if (order_of(parameters) == ElementOrder::balanced)
    costs = {0.5e-3, 1e-6, 0.03e-9 * std::min(samples, 32768.0), 1.5e-6};
  if (parameters.sequence == SequenceKind::spaced) {
    costs.sample += 12e-6;
    costs.cut += 2.8e-6;
  }
  if (parameters.sharp.samples > 0) {
    costs.model += 0.3e-6 * parameters.sharp.samples;
    costs.triangle += 1e-6;
  }
  if (parameters.queries.any()) {
    costs.model += 2e-6 * query_count(parameters.queries.terms) + 0.01;
    costs.triangle += 3e-6;
  }
  // Descriptors of single samples and those of all pairs, on average.
  costs.sample += 1.1e-6 * static_cast<double>(parameters.describe.descriptors.size());
  return costs;
}

double seconds_of(double triangles, const SampleParameters& parameters) {
  if (triangles == 0) return 0;
  const WorkCosts costs = costs_of(parameters);
  const double samples = parameters.samples;
  // Of a fine mesh most triangles lie within a cell, and are only read.
  constexpr double cut_per_sample = 25, read = 0.3e-6;
  const double cut = std::min(triangles, cut_per_sample * samples);
  return costs.model + costs.sample * samples + costs.triangle * triangles +
         costs.cut * std::sqrt(cut * samples) + (costs.cut > 0 ? read * (triangles - cut) : 0);
}

}  // namespace

double estimated_seconds(const MeshEstimate& mesh, const SampleParameters& parameters) {
  return seconds_of(static_cast<double>(mesh.triangles), parameters);
}

double estimated_seconds(std::uint64_t file_bytes, const SampleParameters& parameters) {
  return seconds_of(static_cast<double>(file_bytes) / bytes_per_triangle, parameters);
}

}  // namespace meander
