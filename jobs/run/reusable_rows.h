// Rows of an older store that a run copies instead of making them again.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "io/mesh/mesh_reader.h"
#include "io/store/store_reader.h"

namespace meander {

// The rows of a finished store by content and format, for --reuse: the same bytes with the extension of
// another format are another model. Only rows of the same parameters and seed are reused, and none with a
// status that depends on the machine.
class ReusableRows {
 public:
  // Throws UsageError when the store at `path` was made with other parameters than those of `header`.
  ReusableRows(const std::string& path, StoreCheck check, const StoreHeader& header);

  // The row of this content in a file of this format, valid as long as this object; empty when there is none
  // or it cannot be read. Thread-safe.
  std::optional<CopiedRow> find(const std::array<std::uint8_t, 32>& content, MeshFormat format) const;

 private:
  StoreReader store_;
  std::unordered_map<std::string, std::uint64_t> rows_;
};

}  // namespace meander
