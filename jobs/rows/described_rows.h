// The descriptors of a store, by name and weight, read in blocks of rows.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/store/store_reader.h"

namespace meander {

struct LocalCodes;

// A descriptor beside the store: a row of values for each row of the store, NaN where there is none.
struct SideVectors {
  DescriptorSchema schema;    // of the group vectors_group
  std::vector<float> values;  // rows x width
  std::shared_ptr<const LocalCodes> local =
      {};  // of codes of local pairs: what codes of other meshes are made by
};
inline constexpr const char* vectors_group = "vectors";
using SideVectorsList = std::vector<std::shared_ptr<const SideVectors>>;

// A descriptor of a combination. Weights are relative to each other.
struct DescriptorTerm {
  DescriptorSchema schema;
  double weight = 1;
  std::shared_ptr<const SideVectors> side = {};  // null: of the store

  // Rows [first, first + count) of the store: count x width.
  std::vector<float> read(const StoreReader& store, std::uint64_t first, std::uint64_t count) const;
};

// Names with their weights, `NAME` or `NAME=WEIGHT`, joined by `+`: pairs=2+d2. Throws UsageError for a
// weight that is not a positive number, or that a descriptor has on its own.
struct NamedTerm {
  std::string name;
  double weight = 1;
};
std::vector<NamedTerm> parse_terms(const std::string& text);
std::string joined(std::span<const NamedTerm> terms);
std::string joined(std::span<const DescriptorTerm> terms);
// A line for each descriptor beside the store: the checksum of its values. Results that are kept name these.
std::string side_checksums(std::span<const DescriptorTerm> terms);

// Those of the store and of `side`; of an empty text the first one. Throws as parse_terms, and UsageError
// with the nearest name.
std::vector<DescriptorTerm> chosen_descriptors(const StoreReader& store, const std::string& wanted,
                                               const SideVectorsList& side = {});

// Consecutive rows of a store.
class DescribedBlock {
 public:
  std::uint64_t first() const { return first_; }
  std::uint64_t count() const { return count_; }
  // The values of a row of the store within the block.
  std::span<const float> values(std::size_t term, std::uint64_t row) const {
    return std::span(values_[term]).subspan((row - first_) * widths_[term], widths_[term]);
  }
  // Whether the row has all the descriptors; never where its status is not ok.
  bool is_described(std::uint64_t row) const { return described_[row - first_] != 0; }

 private:
  friend void visit_described(const StoreReader&, std::span<const DescriptorTerm>, std::uint64_t,
                              const std::function<void(const DescribedBlock&)>&);
  void read(const StoreReader& store, std::span<const DescriptorTerm> terms, std::uint64_t first,
            std::uint64_t count);

  std::uint64_t first_ = 0, count_ = 0;
  std::vector<std::size_t> widths_;
  std::vector<std::vector<float>> values_;  // by term
  std::vector<std::uint8_t> described_;
};

// Calls visit with blocks of up to `rows` rows (0: block_rows), ascending, on the calling thread; the next
// one is read meanwhile. Memory: two blocks.
void visit_described(const StoreReader& store, std::span<const DescriptorTerm> terms, std::uint64_t rows,
                     const std::function<void(const DescribedBlock&)>& visit);
inline constexpr std::uint64_t described_block_rows = 4096;

// The descriptors of the store, each with the number of ok rows that lack it. Reads them all.
std::vector<std::pair<std::string, std::uint64_t>> count_undescribed(const StoreReader& store);
std::uint64_t described_row_bytes(std::span<const DescriptorTerm> terms);  // of one row

}  // namespace meander
