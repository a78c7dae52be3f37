// IEEE 754 half precision, as files hold it.
#pragma once

#include <bit>
#include <cstdint>

namespace meander {

inline constexpr float largest_half = 65504;

// The nearest half, ties to even: infinity from 65520 on. Pure; the same on every processor.
constexpr std::uint16_t half_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000u, size = bits & 0x7FFFFFFFu;
  if (size > 0x7F800000u) return static_cast<std::uint16_t>(sign | 0x7E00u);   // NaN
  if (size >= 0x477FF000u) return static_cast<std::uint16_t>(sign | 0x7C00u);  // infinity
  if (size < 0x38800000u)  // below 2^-14: a sum at which floats are multiples of 2^-24, as such halves are
    return static_cast<std::uint16_t>(
        sign | (std::bit_cast<std::uint32_t>(std::bit_cast<float>(size) + 0.5f) - 0x3F000000u));
  return static_cast<std::uint16_t>(sign | (size - 0x38000000u + 0xFFFu + (size >> 13 & 1u)) >> 13);
}

constexpr float value_of_half(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000u) << 16, size = half & 0x7FFFu;
  if (size >= 0x7C00u) return std::bit_cast<float>(sign | 0x7F800000u | (size & 0x3FFu) << 13);
  if (size >= 0x400u) return std::bit_cast<float>(sign | ((size << 13) + 0x38000000u));
  const float value = static_cast<float>(size) * 0x1p-24f;
  return sign != 0 ? -value : value;
}

// The nearest value that a half holds.
constexpr float rounded_to_half(float value) { return value_of_half(half_of(value)); }

}  // namespace meander
