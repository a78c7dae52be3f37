// Items of a store on the command line.
#pragma once

#include <cstdint>
#include <string>

#include "io/store/store.h"

namespace meander {

// The row of an id, or of a row number. Throws UsageError.
std::uint64_t find_item(const StoreReader& store, const std::string& item);

}  // namespace meander
