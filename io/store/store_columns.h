// The columns that a store has, of those of kernels/data/columns.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/data/columns.h"

namespace meander {

// What the rows of a store are: models of files, whose points name their polygon, or parametric surfaces,
// whose points name their parameters.
enum class RowKind : std::uint8_t { meshes, surfaces };

// Attributes and columns with optional values in all: the bits of ItemReport::lacks.
inline constexpr std::size_t most_chosen_columns = 32;

// Columns are given by their number in sample_columns, or by their array.
struct StoreColumns {
  RowKind rows = RowKind::meshes;
  bool tensors = false;                          // anisotropic samples
  ColumnSet asked = {};                          // of those that have an option
  ColumnSet left_out = {};                       // not stored
  std::vector<AttributeColumn> attributes = {};  // ascending by name
  SetCounts counts = {};                         // of the sets beside the samples; 0: rows have none
  // Of queries: whether they have sides, the nearest point, and float16 in place of float32; and what the
  // numbers of their groups stand for.
  bool sides = false, nearest = false, halves = false;
  std::vector<std::string> query_groups = {};

  // Whether samples of this kind have such a column, and whether it is stored.
  bool applies(std::size_t column) const;
  bool has(std::size_t column) const { return applies(column) && !left_out[column]; }
  template <class Value>
  bool has(std::vector<Value> Samples::*array) const {
    return has(column_of(array));
  }
  bool has(const ItemColumn& column) const;
  // How many points of the set a row has, where it has so many samples.
  std::uint32_t points_of(PointSet set, std::uint32_t samples) const {
    return set == PointSet::samples ? samples : counts[static_cast<std::size_t>(set)];
  }
  bool has_sets() const { return counts != SetCounts{}; }
  // Whether anything but the columns of a plain run is asked for.
  bool are_chosen() const;
  std::size_t chosen_count() const;
  // Whether models have names for the classes of a column: one of numbered_attributes.
  bool has_names() const;
  // The bit of ItemReport::lacks: attributes first, then columns with optional values.
  std::optional<std::uint32_t> lacks_bit(std::size_t column) const;
  // The column of this bit: its dataset without the leading `/`, and its name in words.
  std::string chosen_name(std::size_t bit) const;
  std::string chosen_text(std::size_t bit) const;
  // Why samples of this kind have no such column, completing "it has none: ...".
  std::string why_without(std::size_t column) const;
  friend bool operator==(const StoreColumns&, const StoreColumns&) = default;
};

// The folder of attributes, in front of their names.
inline constexpr std::string_view attribute_prefix = "attributes/";

// What is wrong with the name of an attribute, completing "the attribute `NAME` ..."; empty: nothing. Names
// are 1 to 200 bytes of UTF-8 without control characters, `/`, `,` and `:`, and more than dots.
std::string attribute_name_problem(std::string_view name);

namespace store {
struct ColumnTable;  // io/store/schema.h
}

// Columns with the table of their datasets, which is made once and shared by all copies. Immutable.
class StoredColumns {
 public:
  StoredColumns() : StoredColumns(StoreColumns{}) {}
  // Linear attributes become plain ones, as which they are stored. Throws ItemError(internal) for more than
  // most_chosen_columns, a width that is not 1 to 4, and names that are no names, or do not ascend.
  StoredColumns(StoreColumns columns);
  const StoreColumns& operator*() const;
  const StoreColumns* operator->() const;
  const store::ColumnTable& table() const { return *table_; }
  friend bool operator==(const StoredColumns& a, const StoredColumns& b) { return *a == *b; }

 private:
  std::shared_ptr<const store::ColumnTable> table_;
};

}  // namespace meander
