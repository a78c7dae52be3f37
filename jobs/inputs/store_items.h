// Commands that read a store: its options, its items on the command line, and unfinished work beside it.
#pragma once

#include <cstdint>
#include <string>

#include "io/store/store_reader.h"

namespace meander {

class Command;

// Adds --trust to a command that reads stores: it sets `check` to StoreCheck::none.
void add_trust_option(Command& command, StoreCheck& check);

// Called before a store is read as a whole: warns on standard error of unfinished work beside it. Throws
// UsageError when there is no store yet, or a folder has its name.
void warn_of_unfinished_run(const std::string& store);

// The row of an id, of the path that an id was made of, or with a row number, tried in this order. Throws
// UsageError.
std::uint64_t find_item(const StoreReader& store, const std::string& item);

// The differences between `store` and what a run with this header would make: another method version, or the
// parameters that differ, with both values, or with equal ones other columns of measures. Empty when the rows
// would be the same.
std::string parameter_mismatch(const StoreReader& store, const StoreHeader& header);

}  // namespace meander
