// The nearest rows of a base of descriptors, exactly: every distance is computed, in blocks and in parallel.
#pragma once

#include <cstddef>
#include <cstdint>
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

// nearest_rows of the rows [begin, end), one after the other: (end - begin) x min(k, rows - 1). Memory: the
// result and one block of visit_distances. Throws std::invalid_argument when there are no such rows.
std::vector<NearRow> nearest_rows_of(const DescriptorBase& base, std::size_t begin, std::size_t end,
                                     std::size_t k);
std::vector<NearRow> nearest_rows_of_all(const DescriptorBase& base, std::size_t k);

}  // namespace meander
