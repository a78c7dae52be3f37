// A stretch of consecutive rows of the item columns, read together.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/store/store_file.h"

namespace meander::store {

// Rows [begin, begin + count) of id, label, split, status, reason and all other item columns.
class ItemBlock {
 public:
  // Reads the chunk of item columns that holds `row`. The caller holds an Hdf5Lock. Throws Hdf5Error.
  void read(const StoreFileReader& reader, std::uint64_t row);
  bool holds(std::uint64_t row) const { return row >= begin_ && row < begin_ + count_; }

  std::string id(std::uint64_t row) const { return text(Role::id, row); }
  std::int32_t label(std::uint64_t row) const;
  // none where the store has no such column. Throws RunError(unusable) when it is not on this program's list.
  Split split(std::uint64_t row) const;
  bool is_ok(std::uint64_t row) const;
  // Throws RunError(unusable) when status or method is not on this program's list.
  ItemReport report(std::uint64_t row) const;

 private:
  std::string text(Role role, std::uint64_t row) const;

  const StoreLayout* layout_ = nullptr;
  std::uint64_t begin_ = 0, count_ = 0;
  std::vector<std::vector<std::byte>> columns_;  // per dataset of the layout
};

}  // namespace meander::store
