#include "kernels/retrieve/descriptor_distance.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/random.h"

namespace meander {

namespace {

constexpr std::uint32_t lanes = 16;
constexpr std::size_t tile_rows = 256;  // 64 KiB at width 64: stays in the second-level cache
constexpr std::size_t block_bytes = std::size_t{32} << 20;
constexpr std::size_t most_block_queries = 256;
constexpr std::size_t scale_pairs = 32768;

// Sums term(a[i], b[i]) in lanes that are added in a fixed order. stride is a multiple of the lanes.
template <class Term>
float lane_sum(const float* a, const float* b, std::uint32_t stride, const Term& term) {
  std::array<float, lanes> sum{};
  for (std::uint32_t i = 0; i < stride; i += lanes)
    for (std::uint32_t l = 0; l < lanes; ++l) sum[l] += term(a[i + l], b[i + l]);
  for (std::uint32_t half = lanes / 2; half > 0; half /= 2)
    for (std::uint32_t l = 0; l < half; ++l) sum[l] += sum[l + half];
  return sum[0];
}

float absolute_difference(float a, float b) { return std::fabs(a - b); }
float squared_difference(float a, float b) { return (a - b) * (a - b); }
// Never divides by zero: where both are zero, so is the numerator.
float chi2_term(float a, float b) {
  const float sum = std::fabs(a) + std::fabs(b);
  return (a - b) * (a - b) / (sum < FLT_MIN ? FLT_MIN : sum);
}

float block_distance(DistanceKind kind, const float* a, const float* b, std::uint32_t stride) {
  switch (kind) {
    case DistanceKind::l1:
    case DistanceKind::emd:
      return lane_sum(a, b, stride, absolute_difference);
    case DistanceKind::l2:
      return std::sqrt(lane_sum(a, b, stride, squared_difference));
    case DistanceKind::chi2:
      return 0.5f * lane_sum(a, b, stride, chi2_term);
    // |a - b|^2 = 2 - 2 cos for rows of length 1, without the cancellation of 1 - cos.
    case DistanceKind::cosine:
      return 0.5f * lane_sum(a, b, stride, squared_difference);
  }
  return 0;
}

void prepare_row(DistanceKind kind, std::span<const float> from, float* to) {
  if (kind == DistanceKind::emd) {
    double sum = 0;
    for (std::size_t i = 0; i < from.size(); ++i)
      to[i] = static_cast<float>(sum += static_cast<double>(from[i]));
  } else if (kind == DistanceKind::cosine) {
    double squares = 0;
    for (const float v : from) squares += static_cast<double>(v) * static_cast<double>(v);
    const double factor = squares > 0 ? 1 / std::sqrt(squares) : 0;
    for (std::size_t i = 0; i < from.size(); ++i)
      to[i] = static_cast<float>(static_cast<double>(from[i]) * factor);
  } else {
    std::copy(from.begin(), from.end(), to);
  }
}

double mean_distance(const DescriptorBase& base, const DescriptorBase::Block& block) {
  const std::size_t n = base.rows;
  if (n < 2) return 0;
  const auto at = [&](std::size_t i, std::size_t j) {
    return static_cast<double>(block_distance(base.kind, block.values.data() + i * block.stride,
                                              block.values.data() + j * block.stride, block.stride));
  };
  double sum = 0;
  if (n <= scale_pairs && n * (n - 1) / 2 <= scale_pairs) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < i; ++j) sum += at(i, j);
    return sum / (static_cast<double>(n) * static_cast<double>(n - 1) / 2);
  }
  const RandomKey key = make_random_key(0, {});
  for (std::size_t p = 0; p < scale_pairs; ++p) {
    const UnitPair u = random_pair(key, Stream::pair_scale, p);
    const auto i = static_cast<std::size_t>(u.first * static_cast<double>(n));
    const auto other = static_cast<std::size_t>(u.second * static_cast<double>(n - 1));
    sum += at(i, other < i ? other : other + 1);
  }
  return sum / static_cast<double>(scale_pairs);
}

}  // namespace

DescriptorBase make_descriptor_base(std::span<const DescriptorBlock> blocks, DistanceKind kind) {
  if (blocks.empty()) throw std::invalid_argument("a base of descriptors needs a block");
  DescriptorBase base;
  base.kind = kind;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const DescriptorBlock& from = blocks[b];
    if (from.width == 0 || from.values.size() % from.width != 0)
      throw std::invalid_argument("a block of descriptors does not fit its width");
    const std::size_t rows = from.values.size() / from.width;
    if (b > 0 && rows != base.rows) throw std::invalid_argument("blocks of descriptors differ in length");
    base.rows = rows;
    if (!std::all_of(from.values.begin(), from.values.end(), [](float v) { return std::isfinite(v); }))
      throw std::invalid_argument("a descriptor is not finite");
    DescriptorBase::Block& block = base.blocks.emplace_back();
    block.width = from.width;
    block.stride = (from.width + lanes - 1) / lanes * lanes;
    block.values.resize(rows * block.stride);
    for (std::size_t i = 0; i < rows; ++i)
      prepare_row(kind, from.values.subspan(i * from.width, from.width),
                  block.values.data() + i * block.stride);
  }
  if (blocks.size() > 1)
    for (DescriptorBase::Block& block : base.blocks) {
      const double mean = mean_distance(base, block);
      block.scale = mean > 0 ? mean : 1;
    }
  return base;
}

void block_distances(const DescriptorBase& base, std::size_t number, std::size_t query, std::size_t begin,
                     std::span<float> out) {
  const DescriptorBase::Block& block = base.blocks[number];
  const float* const a = block.values.data() + query * block.stride;
  const auto run = [&](auto distance) {
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = distance(block.values.data() + (begin + i) * block.stride);
  };
  // The kind is chosen outside the loop over rows.
  switch (base.kind) {
    case DistanceKind::l1:
    case DistanceKind::emd:
      return run([&](const float* b) { return block_distance(DistanceKind::l1, a, b, block.stride); });
    case DistanceKind::l2:
      return run([&](const float* b) { return block_distance(DistanceKind::l2, a, b, block.stride); });
    case DistanceKind::chi2:
      return run([&](const float* b) { return block_distance(DistanceKind::chi2, a, b, block.stride); });
    case DistanceKind::cosine:
      return run([&](const float* b) { return block_distance(DistanceKind::cosine, a, b, block.stride); });
  }
}

void descriptor_distances(const DescriptorBase& base, std::size_t query, std::size_t begin,
                          std::span<float> out) {
  if (base.blocks.size() == 1) return block_distances(base, 0, query, begin, out);
  std::array<float, tile_rows> part;
  for (std::size_t done = 0; done < out.size(); done += tile_rows) {
    const std::size_t count = std::min(tile_rows, out.size() - done);
    for (std::size_t b = 0; b < base.blocks.size(); ++b) {
      block_distances(base, b, query, begin + done, std::span(part).first(count));
      const auto factor = static_cast<float>(1 / base.blocks[b].scale);
      for (std::size_t i = 0; i < count; ++i)
        out[done + i] = b == 0 ? part[i] * factor : out[done + i] + part[i] * factor;
    }
  }
}

float descriptor_distance(const DescriptorBase& base, std::size_t i, std::size_t j) {
  float distance = 0;
  descriptor_distances(base, i, j, {&distance, 1});
  return distance;
}

void visit_distances(const DescriptorBase& base, const DistanceVisitor& visit, std::size_t block_queries) {
  const std::size_t n = base.rows;
  if (n == 0) return;
  if (block_queries == 0)
    block_queries = std::clamp<std::size_t>(block_bytes / (n * sizeof(float)), 1, most_block_queries);
  block_queries = std::min(block_queries, n);
  std::vector<float> distances(block_queries * n);
  for (std::size_t first = 0; first < n; first += block_queries) {
    const std::size_t count = std::min(block_queries, n - first);
    // A tile of rows meets all queries of the block while it is in the cache.
    parallel_tasks((n + tile_rows - 1) / tile_rows, [&](std::size_t tile) {
      const std::size_t begin = tile * tile_rows, rows = std::min(tile_rows, n - begin);
      for (std::size_t q = 0; q < count; ++q)
        descriptor_distances(base, first + q, begin, {distances.data() + q * n + begin, rows});
    });
    visit(first, std::span(distances).first(count * n));
  }
}

}  // namespace meander
