// Files that appear under their name complete or not at all: they are written under a temporary name beside
// it, synced, closed and renamed, and the folder is synced. At every moment the name is that of the old file
// or of the new one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "io/file/file_descriptor.h"

namespace meander {

// The temporary files that this process is writing are noted, so that a signal that ends it can remove them.
//
// Notes a file and returns the number to forget it by. With too many files, or a path that is too long, it is
// not noted, and stays when a signal ends the process. Thread-safe.
std::size_t note_pending_file(const std::filesystem::path& path);
void forget_pending_file(std::size_t number);

// Removes all files that this process has noted, but not those of its parent. Safe in a signal handler.
void remove_pending_files() noexcept;

// The successor of a file, for libraries that open files by name (HDF5). Other code uses AtomicFile.
class PendingFile {
 public:
  // Writes nothing yet. Symbolic links are followed: their target is replaced. Throws FileError when the path
  // is that of something other than a regular file: a folder, or a device, which a rename would remove for
  // all programs.
  PendingFile(const std::filesystem::path& path, FullDisk full_disk);
  ~PendingFile();  // removes the temporary file unless it was committed
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& temporary() const { return temporary_; }  // the path, .tmp and the process id

  FileDescriptor create();  // creates the empty file under the temporary name
  // Syncs and closes the temporary file, gives it its name and syncs the folder. Called once; without a
  // descriptor it opens the file.
  void commit(FileDescriptor file = {});

  [[noreturn]] void fail(int error, std::string_view action) const;  // throws FileError with the final name

 private:
  std::filesystem::path path_, temporary_;
  FullDisk full_disk_;
  std::size_t noted_ = 0;  // the number of note_pending_file
  bool committed_ = false;
};

// A file that is written piece by piece. Every function throws FileError with the final name when a call
// fails, however late the system reports it; without commit() nothing is left.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path, FullDisk full_disk = FullDisk::ends_command);
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text);
  void commit();  // called once, after the last append

 private:
  PendingFile pending_;
  FileDescriptor file_;
  std::uint64_t size_ = 0;
};

// Writes a whole file in the same way.
void replace_file(const std::filesystem::path& path, std::span<const std::byte> bytes,
                  FullDisk full_disk = FullDisk::ends_command);
void replace_file(const std::filesystem::path& path, std::string_view text,
                  FullDisk full_disk = FullDisk::ends_command);

}  // namespace meander
