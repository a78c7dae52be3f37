// Items of a store on the command line, and files beside it.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>

#include "io/store/store.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace meander {

// Adds --trust to a command that reads stores: it sets `check` to StoreCheck::none.
CLI::Option* add_trust_option(CLI::App& command, StoreCheck& check);

// The row of an id, or of a row number. Throws UsageError.
std::uint64_t find_item(const StoreReader& store, const std::string& item);

// Throws UsageError where a file to be written (empty: none) is the store that it is made of.
void keep_store(const std::string& store, std::initializer_list<std::string> outputs);

}  // namespace meander
