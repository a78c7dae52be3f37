// Items of a store on the command line, and files beside it.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>

#include "io/store/store.h"

namespace meander {

// The row of an id, of the path that an id was made of, or of a row number, the first of these that there is.
// Throws UsageError.
std::uint64_t find_item(const StoreReader& store, const std::string& item);

// Throws UsageError where a file to be written (empty: none) is the store that it is made of.
void keep_store(const std::string& store, std::initializer_list<std::string> outputs);

}  // namespace meander
