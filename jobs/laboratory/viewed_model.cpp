#include "jobs/laboratory/viewed_model.h"

#include <algorithm>
#include <utility>

namespace meander {

namespace {

// The mean of |n . v| over the directions of view, for a sample that may be visible.
double mean_facing(const ViewDetailParameters& parameters) { return parameters.both_sides ? 0.5 : 0.25; }

}  // namespace

ViewedModel::ViewedModel(const Row& row, const ViewDetailParameters& detail, std::uint32_t samples)
    : row_(row), parameters_(detail), areas_(sample_areas(row, row.samples.count())) {
  const std::size_t count = row.samples.count();
  for (std::size_t i = 0; i < count; ++i) {
    nx_.push_back(row.samples.normals[3 * i]);
    ny_.push_back(row.samples.normals[3 * i + 1]);
    nz_.push_back(row.samples.normals[3 * i + 2]);
  }
  double area = 0;
  for (const float a : areas_) area += a;
  const double wanted =
      samples > 0 ? static_cast<double>(samples) : static_cast<double>(count) * mean_view_weight(detail);
  parameters_.samples_per_area = wanted / std::max(area * mean_facing(detail), 1e-300);
}

ViewDetail ViewedModel::detail(Vector3 towards) const {
  return view_detail({nx_, ny_, nz_, areas_}, towards, parameters_);
}

double ViewedModel::behind(const ViewDetail& kept, Vector3 towards) const {
  std::size_t behind = 0;
  for (const std::uint32_t i : kept.kept) behind += dot({nx_[i], ny_[i], nz_[i]}, towards) <= 0;
  return static_cast<double>(behind) / static_cast<double>(std::max<std::size_t>(1, kept.kept.size()));
}

void TurnCounts::add(std::vector<std::uint32_t> kept) {
  fewest = std::min(fewest, kept.size());
  most = std::max(most, kept.size());
  if (!before_.empty())
    stay_.push_back(static_cast<double>(samples_that_stay(before_, kept)) /
                    static_cast<double>(before_.size()));
  before_ = std::move(kept);
}

double TurnCounts::quantile(double q) const {
  std::vector<double> sorted(stay_);
  std::sort(sorted.begin(), sorted.end());
  return sorted.at(static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1)));
}

RgbImage ViewedModel::draw(const ViewDetail& kept, const SplatView& view, const SplatSizes& sizes,
                           std::span<const SrgbColor> colors) const {
  const Samples& samples = row_.samples;
  std::vector<float> areas(areas_);
  for (const std::uint32_t i : kept.kept) {
    const double weight = view_weight({nx_[i], ny_[i], nz_[i]}, view.back, parameters_);
    areas[i] /= static_cast<float>(std::clamp(kept.share * weight, 1e-6, 1.0));
  }
  const std::vector<float> all_axes = splat_half_axes(row_, areas, sizes);
  std::vector<float> centers, normals, directions, half_axes;
  for (const std::uint32_t i : kept.kept) {
    for (std::size_t k = 3 * std::size_t{i}; k < 3 * std::size_t{i} + 3; ++k) {
      centers.push_back(samples.points[k]);
      normals.push_back(samples.normals[k]);
      if (!samples.tensor_direction.empty()) directions.push_back(samples.tensor_direction[k]);
    }
    half_axes.push_back(all_axes[2 * std::size_t{i}]);
    half_axes.push_back(all_axes[2 * std::size_t{i} + 1]);
  }
  std::vector<SrgbColor> own;
  if (colors.size() > 1) {
    for (const std::uint32_t i : kept.kept) own.push_back(colors[i]);
    colors = own;
  }
  limit_overlap(half_axes, view);
  return draw_splats({centers, normals, directions, half_axes, colors}, view,
                     {.backs = parameters_.both_sides})
      .image;
}

void turn(SplatView& view, Vector3 towards, Vector3 up) {
  static_cast<PictureAxes&>(view) = picture_axes(towards, up);
}

}  // namespace meander
