// Internal to io/image: the little-endian numbers of a file in memory, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "kernels/core/status.h"

namespace meander {

// Throws ItemError(unreadable) at the end of the bytes.
class ImageCursor {
 public:
  // `format` is what the file is called in the sentence.
  ImageCursor(std::span<const std::byte> bytes, const char* format) : bytes_(bytes), format_(format) {}

  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  std::uint32_t u8() {
    if (at_ == bytes_.size()) fail_at_end();
    return std::to_integer<std::uint32_t>(bytes_[at_++]);
  }
  std::uint32_t u16() { return number(2); }
  std::uint32_t u24() { return number(3); }
  std::uint32_t u32() { return number(4); }
  std::span<const std::byte> take(std::size_t count) {
    if (count > left()) fail_at_end();
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }
  void skip(std::size_t count) { take(count); }

 private:
  std::uint32_t number(std::size_t size) {
    const std::span<const std::byte> digits = take(size);
    std::uint32_t value = 0;
    for (std::size_t k = size; k-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(digits[k]);
    return value;
  }
  [[noreturn]] void fail_at_end() const {
    throw ItemError(Status::unreadable, std::string("the ") + format_ + " file ends too early");
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  const char* format_;
};

}  // namespace meander
