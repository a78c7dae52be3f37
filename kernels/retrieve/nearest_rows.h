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

// The min(k, rows - 1) rows nearest to row `query`, itself left out, ascending by (distance, row number).
// Throws std::invalid_argument when there is no such row. O(rows x width), memory rows + k; the same for
// every thread count.
std::vector<NearRow> nearest_rows(const DescriptorBase& base, std::size_t query, std::size_t k);

// The min(k, rows) rows nearest to a row outside the base, in the same order at the same cost.
std::vector<NearRow> nearest_rows(const DescriptorBase& base, const DescriptorQuery& query, std::size_t k);

// The nearest rows to many queries of a base that comes in parts: each part is searched when it comes, and
// what remains are the k nearest so far of every query. Memory: queries x min(k, rows) of NearRow, and
// 4 bytes for each row of a part and up to 256 queries.
class NearestSearch {
 public:
  explicit NearestSearch(std::size_t k) : k_(k) {}

  // A query of any part's layout. `own`: the number of a row that is left out, its own; none: no_row.
  static constexpr std::size_t no_row = ~std::size_t{0};
  void add_query(DescriptorQuery query, std::size_t own = no_row);

  // Searches the rows of `part`, whose numbers these are. Each number comes once. In parallel; the same for
  // every thread count, partition and order. Throws std::invalid_argument when the numbers do not fit.
  void search(const DescriptorBase& part, std::span<const std::uint32_t> numbers);

  // The nearest rows of a query, ascending by (distance, number): those of nearest_rows, to the bit, when all
  // rows of a base have come with their numbers there. Called once for each query.
  std::vector<NearRow> found(std::size_t query);

 private:
  struct Wanted {
    DescriptorQuery query;
    std::size_t own = no_row;
    std::vector<NearRow> heap;  // the worst on top
  };
  std::size_t k_;
  std::vector<Wanted> wanted_;
  std::vector<float> distances_;
};

// nearest_rows of the rows [begin, end), one after the other: (end - begin) x min(k, rows - 1). Memory: the
// result and one block of visit_distances. Throws std::invalid_argument when there are no such rows.
std::vector<NearRow> nearest_rows_of(const DescriptorBase& base, std::size_t begin, std::size_t end,
                                     std::size_t k);
std::vector<NearRow> nearest_rows_of_all(const DescriptorBase& base, std::size_t k);

}  // namespace meander
