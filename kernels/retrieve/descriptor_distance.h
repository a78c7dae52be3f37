// Distances between the descriptors of a whole base, one row of numbers per model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/instruction_set.h"
#include "kernels/public/descriptors.h"

namespace meander {

// One descriptor of a whole base: `rows` x `width` numbers, row by row.
struct DescriptorBlock {
  std::span<const float> values;
  std::uint32_t width = 0;
  double weight = 1;                      // positive
  std::optional<DistanceKind> kind = {};  // where it is not that of the base
};

// A base of descriptors, laid out for fast distances. With several blocks the distance is the sum of each
// block's distance times its weight over its scale.
struct DescriptorBase {
  struct Block {
    std::uint32_t width = 0, stride = 0;  // stride: width rounded up to 16, the rest is zero
    std::vector<float> values;            // rows x stride; running sums for emd, of length 1 for cosine
    double scale = 1, weight = 1;
    DistanceKind kind = DistanceKind::l1;
  };
  std::size_t rows = 0;
  InstructionSet instructions = InstructionSet::scalar;
  std::vector<Block> blocks;
};

// Makes a base of blocks that all have the same number of rows. One block keeps its distance (scale 1). With
// several, the scale of each is its mean distance over pairs of different rows, so that all have the same
// influence: over all pairs when there are at most 32768, otherwise over 32768 pairs drawn with a fixed key
// (the standard error of the mean is then below 1 % for distances that spread as much as their mean). A block
// whose mean is zero, because all its rows are equal, has scale 1 and adds nothing. Throws
// std::invalid_argument when a number is not finite, lengths do not fit, there is no block, a weight is not
// positive, or the processor lacks the instructions. O(rows x width) time, and memory for another copy of the
// values.
DescriptorBase make_descriptor_base(std::span<const DescriptorBlock> blocks, DistanceKind kind,
                                    InstructionSet instructions = InstructionSet::automatic);

// The distance of rows i and j of the base. Each block is summed in float, 16 lanes in a fixed order:
// relative error about 1e-6, the same bits on every machine and for (j, i).
float descriptor_distance(const DescriptorBase& base, std::size_t i, std::size_t j);

// Makes the same base in steps, for values that come in parts and should be in memory once: blocks of the
// widths and weights of `blocks`, whose values are not read; then space for rows; then their values in any
// order; then the scales. The base is that of make_descriptor_base, to the bit.
DescriptorBase empty_descriptor_base(std::span<const DescriptorBlock> blocks, DistanceKind kind,
                                     InstructionSet instructions = InstructionSet::automatic);
void resize_descriptor_base(DescriptorBase& base, std::size_t rows);
// values: `width` finite numbers of block `number`. Different rows may be set concurrently.
void set_descriptor_row(DescriptorBase& base, std::size_t number, std::size_t row,
                        std::span<const float> values);
// The pairs of rows whose mean distance is the scale of a block, for a base of `rows` rows.
std::vector<std::pair<std::uint32_t, std::uint32_t>> scale_pairs(std::size_t rows);
// Sets the scales from pairs of rows of this base (which may hold only a few rows of a larger one). Does
// nothing for a single block.
void set_descriptor_scales(DescriptorBase& base,
                           std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs);

// The distances of rows [begin, begin + out.size()) to row `query`.
void descriptor_distances(const DescriptorBase& base, std::size_t query, std::size_t begin,
                          std::span<float> out);

// A row outside of the base, laid out like its rows.
struct DescriptorQuery {
  std::vector<std::vector<float>> blocks;  // stride numbers each
};
// values: those of all blocks, one block after the other. Throws std::invalid_argument when their number does
// not fit the base or one is not finite.
DescriptorQuery make_descriptor_query(const DescriptorBase& base, std::span<const float> values);

// The distances of rows [begin, begin + out.size()) to the query: the same bits as for an equal row of the
// base.
void descriptor_distances(const DescriptorBase& base, const DescriptorQuery& query, std::size_t begin,
                          std::span<float> out);

// How many rows, a multiple of four, fill half of a first-level cache: a loop over queries that takes so many
// rows at a time reads them from there.
std::size_t rows_of_tile(const DescriptorBase& base);

// The unscaled distances of block `number` alone, for the same rows.
void block_distances(const DescriptorBase& base, std::size_t number, std::size_t query, std::size_t begin,
                     std::span<float> out);

// Visits the whole distance matrix in blocks of queries, never in memory at once: calls visit(first,
// distances) in ascending order on the calling thread, where distances is count x rows, row by row (its row q
// belongs to query first + q and holds its distance to every row, itself included). The distances of a block
// are computed in parallel; each equals descriptor_distance bit for bit, for every block size and thread
// count. block_queries = 0: as many as fit into 32 MiB, at most 256. The second form visits only the rows
// [begin, end) as queries.
using DistanceVisitor = std::function<void(std::size_t first, std::span<const float> distances)>;
void visit_distances(const DescriptorBase& base, const DistanceVisitor& visit, std::size_t block_queries = 0);
void visit_distances(const DescriptorBase& base, std::size_t begin, std::size_t end,
                     const DistanceVisitor& visit, std::size_t block_queries = 0);

}  // namespace meander
