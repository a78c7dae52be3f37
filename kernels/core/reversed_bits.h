// The bits of a word in reverse.
#pragma once

#include <cstdint>

namespace meander {

// Bit k of the result is bit 31 - k of `value`.
constexpr std::uint32_t reversed_bits(std::uint32_t value) {
  value = (value >> 1 & 0x55555555) | (value & 0x55555555) << 1;
  value = (value >> 2 & 0x33333333) | (value & 0x33333333) << 2;
  value = (value >> 4 & 0x0F0F0F0F) | (value & 0x0F0F0F0F) << 4;
  return __builtin_bswap32(value);
}

}  // namespace meander
