#include "io/file/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <span>

#include "io/file/directory.h"
#include "io/file/read_file.h"
#include "io/run_error.h"

namespace meander {

namespace fs = std::filesystem;

FileDescriptor lock_folder(const fs::path& folder, const std::string& name, bool create) {
  const fs::path path = folder / name;
  for (;;) {
    if (create) make_folder(folder);
    if (!fs::exists(folder)) {
      if (fs::is_symlink(folder)) throw_file_error(ENOENT, "follow the link", folder);
      if (create) continue;
      return {};
    }
    FileDescriptor file = try_open(path, O_RDWR | O_CREAT);
    const int error = file ? 0 : errno;
    if (error == ENOENT && !fs::is_symlink(path))
      continue;  // a finishing process has just removed the folder
    if (error != 0) throw_file_error(error, "open", path);
    if (uninterrupted([&] { return ::flock(file.get(), LOCK_EX | LOCK_NB); }) != 0) {
      if (errno != EWOULDBLOCK) throw_file_error(errno, "lock", path);
      const std::string holder = content_if_exists(path).value_or("");
      throw FolderHeld(fmt::format("another process{} holds {}",
                                   holder.empty() ? "" : " (pid " + holder + ")", folder.string()));
    }
    // The lock is valid only if others still find this file under its name.
    struct stat mine {
    }, named{};
    if (::fstat(file.get(), &mine) != 0 || ::stat(path.c_str(), &named) != 0 || mine.st_ino != named.st_ino ||
        mine.st_dev != named.st_dev)
      continue;
    const std::string pid = std::to_string(::getpid());
    truncate_file(file, 0, path);
    write_at(file, std::as_bytes(std::span(pid)), 0, path);
    return file;
  }
}

LockState lock_state(const fs::path& folder, const std::string& name) {
  const FileDescriptor file = try_open(folder / name, O_RDONLY);
  if (!file) return LockState::absent;
  return uninterrupted([&] { return ::flock(file.get(), LOCK_SH | LOCK_NB); }) == 0 ? LockState::free
                                                                                    : LockState::held;
}

}  // namespace meander
