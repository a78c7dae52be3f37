// The nearest rows of a base of descriptors, exactly: every distance is computed, in blocks and in parallel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/retrieve/descriptor_distance.h"

namespace meander {

struct NearRow {
  std::uint32_t row = 0;
  float distance = 0;
  friend bool operator==(const NearRow&, const NearRow&) = default;
};

// The min(k, rows - 1) rows nearest to row `query`, without itself, ascending by (distance, row). Throws
// std::invalid_argument when there is no such row. O(rows x width) time, O(rows + k) memory; the same for
// every thread count.
std::vector<NearRow> nearest_rows(const DescriptorBase& base, std::size_t query, std::size_t k);

// The min(k, rows) rows nearest to a row outside of the base, in the same order and at the same cost.
std::vector<NearRow> nearest_rows(const DescriptorBase& base, const DescriptorQuery& query, std::size_t k);

// The min(k, rows) nearest of rows at these distances, in the same order; row `own` is left out.
std::vector<NearRow> nearest_of(std::span<const float> distances, std::size_t own, std::size_t k);

// The nearest rows to many queries of a base that comes in parts: each part is searched when it comes, and
// the k nearest so far of every query are kept. Memory: queries x min(k, rows) of NearRow, and a float for
// each row of a part and up to 256 queries.
class NearestSearch {
 public:
  explicit NearestSearch(std::size_t k) : k_(k) {}

  // Adds a query in any part's layout. `own`: its own row, which is left out; no_row: none.
  static constexpr std::size_t no_row = ~std::size_t{0};
  void add_query(DescriptorQuery query, std::size_t own = no_row);

  // Searches the rows of `part`, which have these numbers in the base. Each number comes once. Parallel; the
  // same for every thread count, partition and order. Throws std::invalid_argument when the numbers do not
  // fit.
  void search(const DescriptorBase& part, std::span<const std::uint32_t> numbers);

  // The nearest rows of a query, ascending by (distance, number): those of nearest_rows, to the bit, when all
  // rows of a base have come with their numbers in it. Call it once for each query.
  std::vector<NearRow> found(std::size_t query);

 private:
  struct Wanted {
    DescriptorQuery query;
    std::size_t own = no_row;
    std::vector<NearRow> heap;  // the farthest on top
  };
  std::size_t k_;
  std::vector<Wanted> wanted_;
  std::vector<float> distances_;
};

// The nearest_rows of all rows, one after the other: rows x min(k, rows - 1). Each distance is computed once,
// for both of its rows: half the time of as many searches. Memory: the result, 8 bytes a row and 4 MiB.
// Parallel; the same bits for every thread count.
std::vector<NearRow> nearest_rows_of_all(const DescriptorBase& base, std::size_t k);

}  // namespace meander
