// Files that appear under their name whole or not at all: written under a temporary name beside it, synced,
// closed, renamed, and the folder synced. At every moment the name is that of the old file or of the new one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "io/file/file_descriptor.h"

namespace meander {

// The successor of a file, for libraries that open files by name (HDF5). AtomicFile is the one to use else.
class PendingFile {
 public:
  // Nothing is written yet. Symbolic links are followed: their target is what is replaced. Throws FileError
  // when something else than a regular file stands there: a folder, or a device, which a rename would remove
  // for all programs.
  PendingFile(const std::filesystem::path& path, FullDisk full_disk);
  ~PendingFile();  // without commit() nothing is left
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& temporary() const { return temporary_; }  // .tmp and the process number

  FileDescriptor create();  // the empty file under the temporary name
  // Syncs and closes the temporary file, gives it its name and syncs the folder; once. Without a descriptor
  // the file is opened for this.
  void commit(FileDescriptor file = {});

  [[noreturn]] void fail(int error, std::string_view action) const;  // FileError with the final name

 private:
  std::filesystem::path path_, temporary_;
  FullDisk full_disk_;
  std::size_t noted_ = 0;  // see note_pending_file
  bool committed_ = false;
};

// A file made piece by piece, too large for memory. Throws FileError with the final name for every call that
// fails, however late the system tells of it; without commit() nothing is left.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path, FullDisk full_disk = FullDisk::ends_command);
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text);
  void commit();  // once, after the last append

 private:
  PendingFile pending_;
  FileDescriptor file_;
  std::uint64_t size_ = 0;
};

// The same for a file that is in memory.
void replace_file(const std::filesystem::path& path, std::span<const std::byte> bytes,
                  FullDisk full_disk = FullDisk::ends_command);
void replace_file(const std::filesystem::path& path, std::string_view text,
                  FullDisk full_disk = FullDisk::ends_command);

}  // namespace meander
