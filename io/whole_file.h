// Writing a file as a whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace meander {

// The file that a new one of this name replaces, symbolic links followed. Throws std::system_error when there
// is not a regular file: a folder, or a device, which a rename would remove for all programs.
std::filesystem::path replaced_file(const std::filesystem::path& path);

// Written to a temporary name beside it, synced and renamed, so that `path` is the old file or the whole new
// one. Throws std::system_error and leaves nothing behind.
void write_whole_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_whole_file(const std::filesystem::path& path, std::string_view text);

// The same for a file that is made piece by piece, too large for memory. Without finish() nothing is left.
class WholeFileWriter {
 public:
  explicit WholeFileWriter(const std::filesystem::path& path);
  ~WholeFileWriter();
  WholeFileWriter(const WholeFileWriter&) = delete;
  WholeFileWriter& operator=(const WholeFileWriter&) = delete;
  void append(std::span<const std::byte> bytes);
  void finish();  // syncs and renames; once, after the last append

 private:
  std::filesystem::path path_, temporary_;
  int file_ = -1;
};

}  // namespace meander
