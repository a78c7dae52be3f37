#include "kernels/query/curve_order.h"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/curve/curve_key.h"

namespace meander {

namespace {

// The order of points takes those beyond as lying there, so that few of them do not spoil that of the others.
constexpr double curve_extent = 1.5;

}  // namespace

std::vector<std::uint32_t> order_along_curve(std::span<const double> points) {
  if (points.size() % 3 != 0) throw std::invalid_argument("order_along_curve: three coordinates a point");
  const std::size_t count = points.size() / 3;
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("order_along_curve: at most 2^32 - 1 points");
  std::array<double, 3> low, high;
  low.fill(curve_extent);
  high.fill(-curve_extent);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double at = std::clamp(points[i], -curve_extent, curve_extent);
    low[i % 3] = std::min(low[i % 3], at);
    high[i % 3] = std::max(high[i % 3], at);
  }
  const double half = 0.5 * std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const double scale = half > 0 ? 1 / half : 0;
  // The leading bits of a key, and the number.
  std::vector<std::uint64_t> words(count), scratch;
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    std::vector<float> unit(3 * (end - begin));
    std::vector<std::uint64_t> key(end - begin);
    for (std::size_t i = 0; i < unit.size(); ++i) {
      const std::size_t k = i % 3;
      const double at = std::clamp(points[3 * begin + i], -curve_extent, curve_extent);
      unit[i] = static_cast<float>(scale * (at - 0.5 * (low[k] + high[k])));
    }
    coarse_hilbert_keys_3d({unit.data(), 3}, key);
    for (std::size_t i = begin; i < end; ++i) words[i] = key[i - begin] >> (coarse_key_bits - 32) << 32 | i;
  });
  radix_sort_words(words, scratch, 32);
  std::vector<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<std::uint32_t>(words[i]);
  return order;
}

CurvePoints along_curve(std::span<const double> points) {
  CurvePoints along;
  along.order = order_along_curve(points);
  along.points.resize(points.size());
  parallel_blocks(along.order.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        along.points[3 * i + k] = points[3 * std::size_t{along.order[i]} + k];
  });
  return along;
}

}  // namespace meander
