#include <algorithm>
#include <chrono>
#include <cmath>

#include "jobs/laboratory/figures/spaced_sets.h"
#include "kernels/analyse/spacing.h"
#include "kernels/pointset/sample_elimination.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

constexpr std::uint32_t candidates_per_sample = 5;  // Yuksel's choice

std::vector<double> chosen(const std::vector<double>& values, const std::vector<std::uint32_t>& points) {
  std::vector<double> result;
  for (const std::uint32_t p : points)
    for (std::size_t k = 0; k < 3; ++k) result.push_back(values[3 * std::size_t{p} + k]);
  return result;
}

}  // namespace

ComparedModel::ComparedModel(const FigureMesh& mesh, std::uint32_t most)
    : parameters_(parameters_for("auto")) {
  set_samples(parameters_, candidates_per_sample * most);
  staged_ = staged_model(mesh, parameters_);
}

ComparedSet ComparedModel::set(const ComparedMethod& method, std::uint32_t count, std::uint64_t seed) const {
  SampleParameters parameters = parameters_;
  parameters.place.sequence = method.sequence;
  parameters.place.order = method.order;
  parameters.place.spacing = method.spacing;
  set_samples(parameters, method.eliminated ? candidates_per_sample * count : count);
  parameters.seed = seed;
  Model model = staged_;
  model.key = make_random_key(seed, {});
  const auto start = std::chrono::steady_clock::now();
  run_stages(placing_stages(parameters, &device_), model);
  const Samples& samples = model.row.samples;
  ComparedSet set{working_points(model.row.report, samples.points, staged_.surface),
                  {samples.normals.begin(), samples.normals.end()}};
  if (method.eliminated) {
    const std::vector<std::uint32_t> kept = eliminate_samples(set.points, count, staged_.surface.total_area);
    set.points = chosen(set.points, kept);
    set.normals = chosen(set.normals, kept);
  }
  set.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return set;
}

std::vector<RotatedBox> ComparedModel::boxes(std::uint32_t count, std::uint64_t seed) const {
  BoxParameters parameters;
  parameters.boxes = count;
  parameters.seed = seed;
  const PreparedMesh& mesh = staged_.surface;
  std::vector<RotatedBox> boxes = random_boxes(mesh.x, mesh.y, mesh.z, mesh.triangles, parameters);
  if (boxes.empty()) throw ItemError(Status::zero_area, "hardly any box holds a share of the surface");
  return boxes;
}

void SetMeasures::add(const ComparedModel& model, std::span<const RotatedBox> boxes, const ComparedSet& set) {
  ++sets;
  squared_error += std::pow(box_error_ratio(boxes, set.points), 2);
  const double area = model.surface().total_area;
  const std::uint64_t count = set.points.size() / 3;
  const Spacing spacing = spacing_of(nearest_distances(set.points), area);
  rho += spacing.rho;
  least_rho = std::min(least_rho, spacing.rho);
  mean_distance += spacing.mean / hexagonal_spacing(area, count);
  seconds += set.seconds;
}

double SetMeasures::error() const { return std::sqrt(squared_error / sets); }

}  // namespace meander
