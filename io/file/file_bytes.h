// All bytes of a file, for readers that take them from front to back.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace meander {

// The bytes of a file for as long as the object lives: read into memory where they are few, else mapped,
// which takes no memory of the process's own. Throws ItemError(unreadable) with the system's reason; anything
// but a regular file is unreadable too. Where another program shortens a file that is mapped, the bytes that
// are gone are zeros, and is_cut() says so, unless they are all in the page that the file now ends in: a
// handler of SIGBUS, which is set when the first file is mapped, puts them there, and leaves all other bus
// errors to the handler before it.
class FileBytes {
 public:
  // Files of up to so many bytes are read. A mapping costs a fault every few pages, and unmapping interrupts
  // all threads of the process: copying so many bytes is cheaper.
  static constexpr std::size_t max_read = std::size_t{4} << 20;

  // `most`: longer files are mapped; 0 for what no reservation of memory has counted yet.
  explicit FileBytes(const std::filesystem::path& path, std::size_t most = max_read);
  ~FileBytes();
  FileBytes(FileBytes&& other) noexcept;
  FileBytes& operator=(FileBytes&&) = delete;
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;
  std::span<const std::byte> bytes() const { return {data_, size_}; }
  // Whether pages that were asked for were no longer there.
  bool is_cut() const;

 private:
  std::unique_ptr<std::byte[]> read_;  // none where the file is mapped
  std::size_t mapping_ = 0;            // its place among those of the process
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace meander
