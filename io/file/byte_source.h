// Bytes that are read piece by piece: of a file, of memory, of an archive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace meander {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t bytes() const = 0;
  // Reads up to `count` bytes from `offset`; fewer only at the end. Throws ItemError(unreadable).
  virtual std::string read(std::uint64_t offset, std::size_t count) const = 0;
};

// Bytes in memory, which must outlive the source.
class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::string_view content) : content_(content) {}
  std::uint64_t bytes() const override { return content_.size(); }
  std::string read(std::uint64_t offset, std::size_t count) const override {
    return offset < content_.size() ? std::string(content_.substr(offset, count)) : std::string();
  }

 private:
  std::string_view content_;
};

}  // namespace meander
