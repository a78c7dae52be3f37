#include "io/file/directory.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "io/file/file_descriptor.h"

namespace meander {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
  if (::mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) throw_file_error(errno, "create", folder);
}

void sync_folder(const fs::path& folder, FullDisk full_disk) {
  const fs::path name = folder.empty() ? fs::path(".") : folder;
  const FileDescriptor file = try_open(name, O_RDONLY | O_DIRECTORY);
  // A folder that may be written but not read, and some network file systems, cannot be synced; the rename is
  // then as durable as they make it.
  if (!file && errno == EACCES) return;
  if (!file) throw_file_error(errno, "open", name, full_disk);
  if (uninterrupted([&] { return ::fsync(file.get()); }) != 0 && errno != EINVAL)
    throw_file_error(errno, "sync", name, full_disk);
}

void rename_file(const fs::path& from, const fs::path& to, FullDisk full_disk) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw_file_error(errno, "rename to", to, full_disk);
  sync_folder(to.parent_path(), full_disk);
}

void remove_file(const fs::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) throw_file_error(errno, "remove", path);
}

}  // namespace meander
