// The temporary files that this process is writing, so that a signal that ends it can remove them.
#pragma once

#include <cstddef>
#include <filesystem>

namespace meander {

// Notes a file and returns the number to forget it by. With too many files, or a path that is too long, it is
// not noted, and stays when a signal ends the process. Thread-safe.
std::size_t note_pending_file(const std::filesystem::path& path);
void forget_pending_file(std::size_t number);

// Removes all files that this process has noted, but not those of its parent. Safe in a signal handler.
void remove_pending_files() noexcept;

}  // namespace meander
