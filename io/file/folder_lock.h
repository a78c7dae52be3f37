// One process at a time in a folder.
#pragma once

#include <filesystem>
#include <string>

#include "io/file/file_descriptor.h"

namespace meander {

// Locks FOLDER/NAME, which then holds the process number; the kernel frees the lock when the process ends,
// however it ends. The holder may remove the file, or the folder, before it lets go. `create`: makes the
// folder where it is missing; its parent must exist. Empty where there is no folder and none is to be made.
// Throws RunError(stopped) while another process holds the lock, FileError when the system refuses.
FileDescriptor lock_folder(const std::filesystem::path& folder, const std::string& name, bool create);

// Whether the file FOLDER/NAME is there, and whether a process holds its lock.
enum class LockState { absent, free, held };
LockState lock_state(const std::filesystem::path& folder, const std::string& name);

}  // namespace meander
