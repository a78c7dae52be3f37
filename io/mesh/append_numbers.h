// Numbers at the end of a file in the making.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <string>

namespace meander {

// The shortest decimals that read back to the same number, and the character behind.
template <class Number>
void append_decimal(std::string& text, Number number, char behind) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text.append(digits.data(), end);
  text += behind;
}

template <class Number>
void append_little_endian(std::string& data, Number number) {
  std::array<char, sizeof number> bytes;
  std::memcpy(bytes.data(), &number, sizeof number);
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  data.append(bytes.data(), bytes.size());
}

}  // namespace meander
