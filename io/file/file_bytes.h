// The bytes of a whole file, for readers that go from front to back.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace meander {

// The bytes of a file, valid as long as the object lives: a small file is read into memory, a larger one is
// mapped, which takes no memory of the process's own. Throws ItemError(unreadable) with the system's reason;
// anything but a regular file is unreadable. If another program shortens a mapped file, the missing bytes
// become zeros and is_cut() is true, unless all of them are in the page in which the file now ends. A handler
// of SIGBUS, installed with the first mapping, does this, and passes all other bus errors to the handler
// before it.
class FileBytes {
 public:
  // Files of up to this many bytes are read. A mapping costs a fault every few pages, and unmapping
  // interrupts all threads of the process: copying is cheaper for smaller files.
  static constexpr std::size_t max_read = std::size_t{4} << 20;

  // Files longer than `max_read_bytes` are mapped; 0 for files that no reservation of memory includes yet.
  explicit FileBytes(const std::filesystem::path& path, std::size_t max_read_bytes = max_read);
  ~FileBytes();
  FileBytes(FileBytes&& other) noexcept;
  FileBytes& operator=(FileBytes&&) = delete;
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;
  std::span<const std::byte> bytes() const { return {data_, size_}; }
  // Whether pages that were read were no longer in the file.
  bool is_cut() const;

 private:
  std::unique_ptr<std::byte[]> read_;  // null if the file is mapped
  std::size_t mapping_ = 0;            // index among the mappings of the process
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace meander
