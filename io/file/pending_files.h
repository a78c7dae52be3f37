// The temporary files that this process is writing, so that a signal that ends it can take them along.
#pragma once

#include <cstddef>
#include <filesystem>

namespace meander {

// Notes a file; the number to forget it by. Where very many are noted already, or the path is longer than
// paths may be, the file is not noted, and stays when a signal ends the process. For any thread.
std::size_t note_pending_file(const std::filesystem::path& path);
void forget_pending_file(std::size_t number);

// Removes all files that this process has noted, but not those of its parent. May be called by a signal
// handler.
void remove_pending_files() noexcept;

}  // namespace meander
