// Internal to differential domain analysis: a map of differences that blocks of samples fill in parallel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/require.h"
#include "kernels/core/parallel.h"

namespace meander::differences {

inline constexpr std::size_t most_blocks = 32;
inline constexpr std::size_t most_map_cells =
    std::size_t{1} << 22;                    // of the maps of all blocks, while there are more than two
inline constexpr double cut_off = 3;         // standard deviations of the kernel
inline constexpr double widest_kernel = 64;  // cells
inline constexpr std::size_t most_weights = 2 * static_cast<std::size_t>(cut_off * widest_kernel) + 2;

inline void check_finite(std::span<const double> values) {
  for (const double value : values)
    require(std::isfinite(value), "differences: coordinates, normals and frames must be finite");
}

// The kernel along one axis: weights of the cells first .. first + count - 1, which may lie beyond the map.
// They sum to one, so that every pair counts alike wherever in its cell it falls.
struct AxisWeights {
  std::ptrdiff_t first = 0;
  std::size_t count = 0;
  std::array<double, most_weights> weight;
};

// at: position in cells from the middle of cell 0.
inline void weigh(double at, double kernel, AxisWeights& out) {
  const double low = std::ceil(at - cut_off * kernel), high = std::floor(at + cut_off * kernel);
  if (!(low < high)) {  // narrower than a cell
    out.first = static_cast<std::ptrdiff_t>(std::floor(at + 0.5));
    out.count = 1;
    out.weight[0] = 1;
    return;
  }
  out.first = static_cast<std::ptrdiff_t>(low);
  out.count = static_cast<std::size_t>(high - low) + 1;
  // exp(-(d + i)^2 / 2 k^2): the ratio of neighbors changes by a constant factor.
  const double h = 1 / (kernel * kernel), d = low - at;
  double value = std::exp(-0.5 * h * d * d), ratio = std::exp(-h * (d + 0.5)), sum = 0;
  const double step = std::exp(-h);
  for (std::size_t i = 0; i < out.count; ++i) {
    out.weight[i] = value;
    sum += value;
    value *= ratio;
    ratio *= step;
  }
  for (std::size_t i = 0; i < out.count; ++i) out.weight[i] /= sum;
}

// A map being filled by one block of samples.
class MapBlock {
 public:
  explicit MapBlock(const DifferenceParameters& parameters)
      : parameters_(parameters),
        scale_(parameters.cells / (2 * parameters.range)),
        sums_(std::size_t{parameters.cells} * parameters.cells, 0.0) {}

  void add(double qx, double qy, double weight) {
    const double margin = cut_off * parameters_.kernel + 1;
    const double x = (qx + parameters_.range) * scale_ - 0.5, y = (qy + parameters_.range) * scale_ - 0.5;
    const double cells = parameters_.cells;
    if (!(x > -margin && x < cells + margin && y > -margin && y < cells + margin)) return;
    weigh(x, parameters_.kernel, across_);
    weigh(y, parameters_.kernel, up_);
    const auto side = static_cast<std::ptrdiff_t>(parameters_.cells);
    const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, -across_.first);
    const std::ptrdiff_t to =
        std::min(static_cast<std::ptrdiff_t>(across_.count), side - across_.first);  // exclusive
    for (std::size_t j = 0; j < up_.count; ++j) {
      const std::ptrdiff_t row = up_.first + static_cast<std::ptrdiff_t>(j);
      if (row < 0 || row >= side) continue;
      const double w = weight * up_.weight[j];
      double* out = sums_.data() + row * side + across_.first;
      for (std::ptrdiff_t i = from; i < to; ++i) out[i] += w * across_.weight[static_cast<std::size_t>(i)];
    }
  }

  const std::vector<double>& sums() const { return sums_; }

 private:
  DifferenceParameters parameters_;
  double scale_;  // cells per unit
  std::vector<double> sums_;
  AxisWeights across_, up_;
};

// Largest |q| that can touch the map: its corner and the tail of the kernel.
inline double reach_of(const DifferenceParameters& parameters) {
  const double cell = 2 * parameters.range / parameters.cells;
  return std::numbers::sqrt2 * (parameters.range + cut_off * parameters.kernel * cell);
}

// Calls visit(block map, position in the tree's order) for every sample, in fixed blocks, then adds the maps
// and their mirror images: each unordered pair was visited once.
template <class Visit>
void add_blocks(DifferenceMap& map, std::size_t samples, const Visit& visit) {
  const std::size_t affordable = std::max<std::size_t>(2, most_map_cells / map.sum.size());
  const std::size_t blocks = std::clamp<std::size_t>(samples / 64, 1, std::min(most_blocks, affordable));
  std::vector<std::vector<double>> sums(blocks);
  parallel_tasks(blocks, [&](std::size_t b) {
    MapBlock block(map.parameters);
    for (std::size_t p = samples * b / blocks; p < samples * (b + 1) / blocks; ++p) visit(block, p);
    sums[b] = block.sums();
  });
  const std::size_t cells = map.sum.size();
  for (const std::vector<double>& block : sums)
    for (std::size_t c = 0; c < cells; ++c) map.sum[c] += block[c] + block[cells - 1 - c];
  ++map.sets;
}

inline void check_spacing(std::span<const double> spacing, std::size_t samples) {
  require(spacing.size() == samples, "differences: as many spacings as samples");
  for (const double r : spacing) require(r > 0 && std::isfinite(r), "differences: spacings must be positive");
}

inline double square(const std::array<double, 2>& v) { return v[0] * v[0] + v[1] * v[1]; }

// The weight of the deposit in the frame of each sample: one half where it is counted.
inline std::vector<double> half_weights(std::span<const std::uint8_t> counted, std::size_t samples) {
  require(counted.empty() || counted.size() == samples, "differences: `counted` is one a sample, or none");
  std::vector<double> weight(samples, 0.5);
  for (std::size_t i = 0; i < counted.size(); ++i) weight[i] = counted[i] != 0 ? 0.5 : 0;
  return weight;
}

}  // namespace meander::differences
