// Items of a store on the command line.
#pragma once

#include <cstdint>
#include <string>

#include "io/store/store_reader.h"

namespace meander {

class Command;

// Adds --trust to a command that reads stores: it sets `check` to StoreCheck::none.
void add_trust_option(Command& command, StoreCheck& check);

// Before a store is read as a whole: says on standard error that there is unfinished work beside it. Throws
// UsageError where there is no store yet, or a folder has its name.
void mind_unfinished_work(const std::string& store);

// The row of an id, of the path that an id was made of, or of a row number, the first of these that there is.
// Throws UsageError.
std::uint64_t find_item(const StoreReader& store, const std::string& item);

// How `store` was made otherwise than a run with this header would make it: another method version, or the
// parameters that differ with both their values. Empty when the rows of both would be the same.
std::string made_otherwise(const StoreReader& store, const StoreHeader& header);

}  // namespace meander
