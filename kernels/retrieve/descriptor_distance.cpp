#include "kernels/retrieve/descriptor_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/retrieve/row_distances.h"

namespace meander {

namespace {

constexpr std::uint32_t lanes = distance_lanes;
constexpr std::size_t tile_rows = 64, tile_bytes = std::size_t{16} << 10;
constexpr std::size_t block_bytes = std::size_t{32} << 20;
constexpr std::size_t max_block_queries = 256;
constexpr std::size_t max_scale_pairs = 32768;

// The kind is chosen outside of the loop over rows.
void row_distances(const DescriptorBase& base, const DescriptorBase::Block& block, const float* query,
                   std::size_t begin, std::span<float> out) {
  const RowDistanceLoops& loops = row_distance_loops(base.instructions);
  const auto run = [&](RowDistances distances) {
    distances(query, block.values.data() + begin * block.stride, block.stride, out.size(), out.data());
  };
  switch (block.kind) {
    case DistanceKind::l1:
    case DistanceKind::emd:
      return run(loops.absolute);
    case DistanceKind::l2:
      run(loops.squared);
      for (float& d : out) d = std::sqrt(d);
      return;
    case DistanceKind::chi2:
      run(loops.relative);
      for (float& d : out) d *= 0.5f;
      return;
    // |a - b|^2 = 2 - 2 cos for rows of length 1, without the cancellation of 1 - cos.
    case DistanceKind::cosine:
      run(loops.squared);
      for (float& d : out) d *= 0.5f;
      return;
  }
}

const float* values_of_row(const DescriptorBase::Block& block, std::size_t row) {
  return block.values.data() + row * block.stride;
}

// Sets the distances from query(b), the row of block b.
template <class Query>
void distances_to(const DescriptorBase& base, const Query& query, std::size_t begin, std::span<float> out) {
  if (base.blocks.size() == 1) return row_distances(base, base.blocks[0], query(0), begin, out);
  std::array<float, tile_rows> part;
  for (std::size_t done = 0; done < out.size(); done += tile_rows) {
    const std::size_t count = std::min(tile_rows, out.size() - done);
    for (std::size_t b = 0; b < base.blocks.size(); ++b) {
      row_distances(base, base.blocks[b], query(b), begin + done, std::span(part).first(count));
      const auto factor = static_cast<float>(base.blocks[b].weight / base.blocks[b].scale);
      for (std::size_t i = 0; i < count; ++i)
        out[done + i] = b == 0 ? part[i] * factor : out[done + i] + part[i] * factor;
    }
  }
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

double mean_distance(const DescriptorBase& base, const DescriptorBase::Block& block,
                     std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs) {
  if (pairs.empty()) return 0;
  double sum = 0;
  for (const auto& [i, j] : pairs) {
    float distance = 0;
    row_distances(base, block, values_of_row(block, i), j, {&distance, 1});
    sum += static_cast<double>(distance);
  }
  return sum / static_cast<double>(pairs.size());
}

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> scale_pairs(std::size_t rows) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  if (rows < 2) return pairs;
  if (rows <= max_scale_pairs && rows * (rows - 1) / 2 <= max_scale_pairs) {
    for (std::uint32_t i = 0; i < rows; ++i)
      for (std::uint32_t j = 0; j < i; ++j) pairs.emplace_back(i, j);
    return pairs;
  }
  const RandomKey key = make_random_key(0, {});
  for (std::size_t p = 0; p < max_scale_pairs; ++p) {
    const UnitPair u = random_pair(key, Stream::pair_scale, p);
    const auto i = static_cast<std::uint32_t>(u.first * static_cast<double>(rows));
    const auto other = static_cast<std::uint32_t>(u.second * static_cast<double>(rows - 1));
    pairs.emplace_back(i, other < i ? other : other + 1);
  }
  return pairs;
}

DescriptorBase empty_descriptor_base(std::span<const DescriptorBlock> blocks, DistanceKind kind,
                                     InstructionSet instructions) {
  if (blocks.empty()) throw std::invalid_argument("a base of descriptors needs a block");
  if (!is_available(instructions))
    throw std::invalid_argument("the processor has no such instructions for distances");
  DescriptorBase base;
  base.instructions = instructions == InstructionSet::automatic ? best_instruction_set() : instructions;
  for (const DescriptorBlock& from : blocks) {
    if (from.width == 0) throw std::invalid_argument("a block of descriptors of no values");
    if (!(from.weight > 0) || !std::isfinite(from.weight))
      throw std::invalid_argument("the weight of a block of descriptors must be positive");
    DescriptorBase::Block& block = base.blocks.emplace_back();
    block.width = from.width;
    block.stride = (from.width + lanes - 1) / lanes * lanes;
    block.weight = from.weight;
    block.kind = from.kind.value_or(kind);
  }
  return base;
}

void resize_descriptor_base(DescriptorBase& base, std::size_t rows) {
  base.rows = rows;
  for (DescriptorBase::Block& block : base.blocks) block.values.resize(rows * block.stride);
}

void set_descriptor_row(DescriptorBase& base, std::size_t number, std::size_t row,
                        std::span<const float> values) {
  DescriptorBase::Block& block = base.blocks[number];
  if (values.size() != block.width || row >= base.rows)
    throw std::invalid_argument("a row of descriptors does not fit its base");
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
    throw std::invalid_argument("a descriptor is not finite");
  prepare_row(block.kind, values, block.values.data() + row * block.stride);
}

void set_descriptor_scales(DescriptorBase& base,
                           std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs) {
  if (base.blocks.size() < 2) return;
  for (DescriptorBase::Block& block : base.blocks) {
    const double mean = mean_distance(base, block, pairs);
    block.scale = mean > 0 ? mean : 1;
  }
}

DescriptorBase make_descriptor_base(std::span<const DescriptorBlock> blocks, DistanceKind kind,
                                    InstructionSet instructions) {
  DescriptorBase base = empty_descriptor_base(blocks, kind, instructions);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const DescriptorBlock& from = blocks[b];
    if (from.values.size() % from.width != 0)
      throw std::invalid_argument("a block of descriptors does not fit its width");
    const std::size_t rows = from.values.size() / from.width;
    if (b == 0) resize_descriptor_base(base, rows);
    if (rows != base.rows) throw std::invalid_argument("blocks of descriptors differ in length");
    for (std::size_t i = 0; i < rows; ++i)
      set_descriptor_row(base, b, i, from.values.subspan(i * from.width, from.width));
  }
  if (blocks.size() > 1) set_descriptor_scales(base, scale_pairs(base.rows));
  return base;
}

std::size_t rows_of_tile(const DescriptorBase& base) {
  std::size_t row_bytes = 0;
  for (const DescriptorBase::Block& block : base.blocks) row_bytes += block.stride * sizeof(float);
  return std::clamp<std::size_t>(tile_bytes / row_bytes / 4 * 4, 4, tile_rows);
}

void block_distances(const DescriptorBase& base, std::size_t number, std::size_t query, std::size_t begin,
                     std::span<float> out) {
  row_distances(base, base.blocks[number], values_of_row(base.blocks[number], query), begin, out);
}

void descriptor_distances(const DescriptorBase& base, std::size_t query, std::size_t begin,
                          std::span<float> out) {
  distances_to(
      base, [&](std::size_t b) { return values_of_row(base.blocks[b], query); }, begin, out);
}

DescriptorQuery make_descriptor_query(const DescriptorBase& base, std::span<const float> values) {
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
    throw std::invalid_argument("a descriptor is not finite");
  DescriptorQuery query;
  for (const DescriptorBase::Block& block : base.blocks) {
    if (values.size() < block.width) throw std::invalid_argument("a query does not fit the base");
    prepare_row(block.kind, values.first(block.width), query.blocks.emplace_back(block.stride).data());
    values = values.subspan(block.width);
  }
  if (!values.empty()) throw std::invalid_argument("a query does not fit the base");
  return query;
}

void descriptor_distances(const DescriptorBase& base, const DescriptorQuery& query, std::size_t begin,
                          std::span<float> out) {
  distances_to(
      base, [&](std::size_t b) { return query.blocks[b].data(); }, begin, out);
}

float descriptor_distance(const DescriptorBase& base, std::size_t i, std::size_t j) {
  float distance = 0;
  descriptor_distances(base, i, j, {&distance, 1});
  return distance;
}

void visit_distances(const DescriptorBase& base, const DistanceVisitor& visit, std::size_t block_queries) {
  visit_distances(base, 0, base.rows, visit, block_queries);
}

void visit_distances(const DescriptorBase& base, std::size_t begin, std::size_t end,
                     const DistanceVisitor& visit, std::size_t block_queries) {
  const std::size_t n = base.rows;
  if (begin > end || end > n) throw std::invalid_argument("there are no such rows in the base");
  if (begin == end) return;
  if (block_queries == 0)
    block_queries = std::clamp<std::size_t>(block_bytes / (n * sizeof(float)), 1, max_block_queries);
  block_queries = std::min(block_queries, end - begin);
  std::vector<float> distances(block_queries * n);
  const std::size_t tile = rows_of_tile(base);
  for (std::size_t first = begin; first < end; first += block_queries) {
    const std::size_t count = std::min(block_queries, end - first);
    // A tile of rows meets all queries of the block while it is in the cache.
    parallel_tasks((n + tile - 1) / tile, [&](std::size_t t) {
      const std::size_t row = t * tile, rows = std::min(tile, n - row);
      for (std::size_t q = 0; q < count; ++q)
        descriptor_distances(base, first + q, row, {distances.data() + q * n + row, rows});
    });
    visit(first, std::span(distances).first(count * n));
  }
}

}  // namespace meander
