#include "pipeline/work_estimate.h"

namespace meander {

namespace {

constexpr double bytes_per_triangle = 30;

// Seconds of a model, of each of its triangles and of each of its samples.
struct WorkCosts {
  double model, triangle, sample;
};

WorkCosts costs_of(const SampleParameters& parameters) {
  const double samples = parameters.samples;
  WorkCosts costs = {1e-3, 0.4e-6, 0.4e-6};  // direct
  if (parameters.method == MethodChoice::anisotropic)
    costs = {1e-3, 3.5e-6, 3.5e-6};
  else if (method_of(parameters).makes_charts)
    costs = {1e-3, 2.1e-6, 3.5e-6};
  else if (order_of(parameters) == ElementOrder::balanced)
    costs = {2e-3, 0.3e-6 + 0.09e-9 * samples, 1.15e-6};
  // Of one by one or all pairs of the samples, on average.
  costs.sample += 1.1e-6 * static_cast<double>(parameters.describe.descriptors.size());
  if (parameters.sequence == SequenceKind::spaced) {
    costs.triangle += 0.6e-6;
    costs.sample += 12.5e-6;
  }
  return costs;
}

double seconds_of(double triangles, const SampleParameters& parameters) {
  if (triangles == 0) return 0;
  const WorkCosts costs = costs_of(parameters);
  return costs.model + costs.triangle * triangles + costs.sample * parameters.samples;
}

}  // namespace

double estimated_seconds(const MeshEstimate& mesh, const SampleParameters& parameters) {
  return seconds_of(static_cast<double>(mesh.triangles), parameters);
}

double estimated_seconds(std::uint64_t file_bytes, const SampleParameters& parameters) {
  return seconds_of(static_cast<double>(file_bytes) / bytes_per_triangle, parameters);
}

}  // namespace meander
