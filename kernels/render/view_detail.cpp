#include "kernels/render/view_detail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

struct ViewedDirection {
  float x, y, z;  // unit
  float back;     // -1: what faces away counts with |n . v|; 0: not at all
  float least, rest;
  float fade, inverse_fade;  // of what faces away; 0: no fade
};

ViewedDirection viewed_direction(Vector3 towards, const ViewDetailParameters& parameters) {
  const double length = norm(towards);
  const Vector3 v = length > 0 ? (1 / length) * towards : Vector3{0, 0, 1};
  const auto least = static_cast<float>(parameters.least);
  const auto fade = parameters.both_sides ? 0.0f : static_cast<float>(parameters.fade);
  return {static_cast<float>(v.x),
          static_cast<float>(v.y),
          static_cast<float>(v.z),
          parameters.both_sides ? -1.0f : 0.0f,
          least,
          1 - least,
          fade,
          fade > 0 ? 1 / fade : 0.0f};
}

inline float cosine_of(const ViewedDirection& v, float x, float y, float z) {
  return v.x * x + v.y * y + v.z * z;
}
// |n . v| of a sample that may be seen; 0 otherwise, and for normals that are not finite.
inline float facing_of(const ViewedDirection& v, float cosine) {
  const float facing = cosine > 0 ? cosine : v.back * cosine;
  return facing > 0 ? (facing < 1 ? facing : 1.0f) : 0.0f;
}
inline float weight_of(const ViewedDirection& v, float cosine) {
  const float facing = facing_of(v, cosine), rim = 1 - facing, square = rim * rim;
  const float front = v.least + v.rest * (square * square), left = 1 + v.inverse_fade * cosine;
  const float behind = cosine > -v.fade ? left * left : 0.0f;
  return facing > 0 ? front : behind;
}

struct ViewSums {
  double weight = 0, projected = 0;
};

// Eight running sums a block, so that the loop goes by vectors whatever the compiler may reorder.
ViewSums block_sums(const ViewedSamples& samples, const ViewedDirection& v, std::size_t begin,
                    std::size_t end) {
  constexpr std::size_t lanes = 8;
  std::array<float, lanes> weight{}, projected{};
  const auto add = [&](std::size_t i, std::size_t lane) {
    const float cosine = cosine_of(v, samples.nx[i], samples.ny[i], samples.nz[i]);
    weight[lane] += weight_of(v, cosine);
    projected[lane] += facing_of(v, cosine) * samples.area[i];
  };
  std::size_t i = begin;
  for (; i + lanes <= end; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) add(i + lane, lane);
  for (; i < end; ++i) add(i, 0);
  ViewSums sums;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    sums.weight += weight[lane];
    sums.projected += projected[lane];
  }
  return sums;
}

}  // namespace

float view_weight(Vector3 normal, Vector3 v, const ViewDetailParameters& parameters) {
  const ViewedDirection direction = viewed_direction(v, parameters);
  return weight_of(direction, cosine_of(direction, static_cast<float>(normal.x), static_cast<float>(normal.y),
                                        static_cast<float>(normal.z)));
}

double mean_view_weight(const ViewDetailParameters& parameters) {
  // n . v is uniform in [-1, 1].
  const double front = parameters.least + (1 - parameters.least) / 5;
  return parameters.both_sides ? front : 0.5 * (front + parameters.fade / 3);
}

ViewDetail view_detail(const ViewedSamples& samples, Vector3 towards,
                       const ViewDetailParameters& parameters) {
  const std::size_t count = samples.nx.size();
  if (samples.ny.size() != count || samples.nz.size() != count || samples.area.size() != count)
    throw std::invalid_argument("normals and areas are not as many as the samples");
  const ViewedDirection v = viewed_direction(towards, parameters);
  std::vector<ViewSums> blocks((count + sum_block - 1) / sum_block);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    blocks[begin / sum_block] = block_sums(samples, v, begin, end);
  });
  ViewDetail detail;
  for (const ViewSums& block : blocks) {
    detail.weight_sum += block.weight;
    detail.projected_area += block.projected;
  }
  if (!(detail.weight_sum > 0) || !(detail.projected_area > 0)) return detail;
  detail.share = parameters.samples_per_area * detail.projected_area / detail.weight_sum;
  // No weight is above 1: the samples after that have no chance.
  const double last =
      std::min(static_cast<double>(count), std::ceil(detail.share * static_cast<double>(count)));
  const auto candidates = static_cast<std::size_t>(last);
  const double step = 1 / (detail.share * static_cast<double>(count));
  for (std::size_t i = 0; i < candidates; ++i) {
    const float weight = weight_of(v, cosine_of(v, samples.nx[i], samples.ny[i], samples.nz[i]));
    if ((static_cast<double>(i) + 0.5) * step < double{weight})
      detail.kept.push_back(static_cast<std::uint32_t>(i));
  }
  return detail;
}

std::size_t samples_that_stay(std::span<const std::uint32_t> before, std::span<const std::uint32_t> after) {
  std::size_t stay = 0;
  for (std::size_t a = 0, b = 0; a < before.size() && b < after.size();) {
    stay += before[a] == after[b];
    const std::uint32_t x = before[a], y = after[b];
    a += x <= y;
    b += y <= x;
  }
  return stay;
}

}  // namespace meander
