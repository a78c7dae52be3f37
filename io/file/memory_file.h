// A file that is nowhere but in memory.
#pragma once

#include <string>
#include <string_view>

namespace meander {

// A child process reads from it or writes to it in place of a pipe, which could fill up. Read from its
// beginning; closed at the end, and in programs that this one starts but for where it was made a standard
// stream of theirs.
class MemoryFile {
 public:
  // Throws std::system_error where there is no room for it.
  explicit MemoryFile(std::string_view content);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }
  // All of it, whoever wrote it. Throws std::system_error.
  std::string content() const;

 private:
  int descriptor_;
};

}  // namespace meander
