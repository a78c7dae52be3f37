// The folder STORE.run beside a store, and what killed processes leave there.
#pragma once

#include <filesystem>
#include <string_view>

namespace meander::store {

// "set.h5" and ".run" give "set.h5.run".
std::filesystem::path with_suffix(const std::filesystem::path& store, std::string_view suffix);

// Where the whole store is written before it gets its name.
std::filesystem::path part_of_store(const std::filesystem::path& store);

// Files that a killed process may have left beside the store. Called with the lock of the run folder held.
void remove_leftovers(const std::filesystem::path& store);

// A folder half removed must not be taken for a run: it loses its name first.
void remove_run_folder(const std::filesystem::path& store);

}  // namespace meander::store
