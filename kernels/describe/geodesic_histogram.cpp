#include "kernels/describe/geodesic_histogram.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace meander {

namespace {

constexpr std::size_t max_kept = std::size_t{1} << 25;  // distances

}  // namespace

GeodesicHistogram geodesic_histogram(const HeatGeodesics& geodesics, PointsOnMesh samples,
                                     const GeodesicHistogramParameters& parameters,
                                     const CancelToken& cancel) {
  if (parameters.bins < 8 || parameters.bins > 1024)
    throw std::invalid_argument("geodesic_histogram: bins must lie in 8..1024");
  const std::size_t count = samples.count();
  const std::size_t sources =
      parameters.sources == 0 ? count : std::min<std::size_t>(parameters.sources, count);
  GeodesicHistogram histogram;
  histogram.share.assign(parameters.bins, 0.0f);
  if (count < 2) return histogram;

  // Blocks are whole rows; when all fit in one, the second pass reads the result of the first.
  const std::size_t block = std::clamp<std::size_t>(max_kept / count, 1, sources);
  std::vector<double> distance(block * count);
  const auto compute = [&](std::size_t begin) {
    const std::size_t rows = std::min(block, sources - begin);
    const PointsOnMesh part{samples.triangle.subspan(begin, rows),
                            samples.barycentric.subspan(2 * begin, 2 * rows)};
    geodesics.to_points(part, samples, std::span(distance).first(rows * count), cancel);
    return rows;
  };
  // Calls body(distance) for every pair of a source in the block and another sample, in one order.
  const auto for_each_pair = [&](std::size_t begin, std::size_t rows, const auto& body) {
    for (std::size_t r = 0; r < rows; ++r)
      for (std::size_t n = 0; n < count; ++n)
        if (n != begin + r) body(distance[r * count + n]);
  };

  double sum = 0;
  std::uint64_t apart = 0;
  for (std::size_t begin = 0; begin < sources; begin += block)
    for_each_pair(begin, compute(begin), [&](double d) {
      if (!std::isfinite(d)) {
        ++apart;
        return;
      }
      ++histogram.pairs;
      sum += d;
      histogram.largest = std::max(histogram.largest, d);
    });
  histogram.disconnected_share = static_cast<double>(apart) / static_cast<double>(apart + histogram.pairs);
  if (histogram.pairs == 0) return histogram;
  histogram.mean = sum / static_cast<double>(histogram.pairs);
  histogram.upper = parameters.scale == HistogramScale::largest ? histogram.largest : 3 * histogram.mean;

  std::vector<std::uint64_t> counts(parameters.bins, 0);
  const double last = static_cast<double>(parameters.bins - 1);
  for (std::size_t begin = 0; begin < sources; begin += block) {
    const std::size_t rows = block < sources ? compute(begin) : sources;
    for_each_pair(begin, rows, [&](double d) {
      if (!std::isfinite(d)) return;
      const double bin = histogram.upper > 0 ? d / histogram.upper * parameters.bins : 0;
      ++counts[static_cast<std::size_t>(std::min(bin, last))];
    });
  }
  for (std::size_t b = 0; b < counts.size(); ++b)
    histogram.share[b] =
        static_cast<float>(static_cast<double>(counts[b]) / static_cast<double>(histogram.pairs));
  return histogram;
}

}  // namespace meander
