// Locks that admit one process at a time to a folder.
#pragma once

#include <filesystem>
#include <string>

#include "io/file/file_descriptor.h"
#include "io/run_error.h"

namespace meander {

// Another process holds the lock. Its kind is `stopped`.
class FolderHeld : public RunError {
 public:
  explicit FolderHeld(const std::string& what) : RunError(Kind::stopped, what) {}
};

// Locks FOLDER/NAME, which then holds the process id; the kernel frees the lock when the process ends in any
// way. The holder may remove the file, or the folder, before it frees the lock. `create`: makes a missing
// folder, whose parent must exist; without it, the result is empty if there is no folder. Throws
// FolderHeld while another process holds the lock, FileError when the system refuses.
FileDescriptor lock_folder(const std::filesystem::path& folder, const std::string& name, bool create);

// Whether the file FOLDER/NAME exists, and whether a process holds its lock.
enum class LockState { absent, free, held };
LockState lock_state(const std::filesystem::path& folder, const std::string& name);

}  // namespace meander
