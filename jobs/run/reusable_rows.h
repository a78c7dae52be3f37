// Rows of an older store that need not be made again.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "io/mesh/mesh_reader.h"
#include "io/store/store_reader.h"

namespace meander {

// Rows of a finished store by content and format, for --reuse: the same bytes under the name of another
// format are another model, or none. Rows are only what the same parameters and the same seed made, and never
// a status that depends on the machine.
class ReusableRows {
 public:
  // Throws UsageError when the store at `path` was made with other parameters than those of `header`.
  ReusableRows(const std::string& path, StoreCheck check, const StoreHeader& header);

  // The row of this content, read as a file of this format, while this object is there. Nothing where there
  // is none, or it cannot be read. Thread-safe.
  std::optional<CopiedRow> find(const std::array<std::uint8_t, 32>& content, MeshFormat format) const;

 private:
  StoreReader store_;
  std::unordered_map<std::string, std::uint64_t> rows_;
};

}  // namespace meander
