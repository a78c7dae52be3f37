// Numbers of zip and gzip headers.
#pragma once

#include <cstdint>
#include <string_view>

namespace meander {

// The number in `count` (at most 8) bytes at `at`, which must be there.
inline std::uint64_t little_endian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t k = count; k-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

}  // namespace meander
