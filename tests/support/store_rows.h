// Rows of a store by the ids of their models.
#pragma once

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/store/store.h"

namespace meander::test {

inline std::vector<std::string> ids_of(const std::filesystem::path& store) {
  return StoreReader(store).header().ids;
}

inline Row row_of(const std::filesystem::path& store, const std::string& id) {
  const StoreReader reader(store);
  const std::vector<std::string> ids = reader.header().ids;
  const auto at = std::find(ids.begin(), ids.end(), id);
  if (at == ids.end()) throw std::runtime_error(store.string() + " has no row " + id);
  return reader.read_row(static_cast<std::uint64_t>(at - ids.begin()));
}

}  // namespace meander::test
