// Files as the store needs them: every call checked, partial writes continued, and every failure a RunError
// whose kind distinguishes "no room, try again later" (stopped) from "cannot work here" (unusable).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meander::store {

class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FileDescriptor();
  int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  int descriptor_ = -1;
};

// Throws RunError: stopped for ENOSPC, EDQUOT, EFBIG and EIO (nothing is lost, the run can be continued),
// unusable for anything else. "cannot <action> <path>: <what the system says>".
[[noreturn]] void throw_file_error(int error, std::string_view action, const std::filesystem::path& path);

FileDescriptor open_file(const std::filesystem::path& path, int flags);  // adds O_CLOEXEC; mode 0666
std::uint64_t file_size(const FileDescriptor& file, const std::filesystem::path& path);
// Writes all bytes at `offset`, which may be the end of the file.
void write_at(const FileDescriptor& file, std::span<const std::byte> bytes, std::uint64_t offset,
              const std::filesystem::path& path);
// Reads up to bytes.size() bytes; fewer only at the end of the file. Returns how many.
std::size_t read_at(const FileDescriptor& file, std::span<std::byte> bytes, std::uint64_t offset,
                    const std::filesystem::path& path);
std::optional<std::string> read_text(const std::filesystem::path& path);  // empty when there is no such file

void sync_file(const FileDescriptor& file, const std::filesystem::path& path);
void sync_folder(const std::filesystem::path& folder);
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to);  // and syncs the folder
// Temporary name, fsync, rename, fsync of the folder: the file is the old one or the new one, never between.
void replace_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

// Makes sure that `path`, which exists, can grow to `bytes`: reserves the blocks where the file system can,
// without changing the length. A file that cannot be completed is refused here, where nothing has to be
// undone.
void reserve_space(const std::filesystem::path& path, std::uint64_t bytes);
// Cuts the file to its length so that reserved blocks beyond it are free again.
void release_reserved(const FileDescriptor& file, const std::filesystem::path& path);

}  // namespace meander::store
