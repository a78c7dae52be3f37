// IEEE 754 half precision, as files hold it.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

namespace meander {

inline constexpr float largest_half = 65504;

// Chooses by masks: where an alternative computes with floats compilers turn `?:` into branches, and loops
// over many halves are not vectorized.
constexpr std::uint32_t chosen_bits(bool first, std::uint32_t one, std::uint32_t other) {
  const std::uint32_t mask = 0u - static_cast<std::uint32_t>(first);
  return (one & mask) | (other & ~mask);
}

// The nearest half, ties to even: infinity from 65520 on. Pure; the same on every processor.
constexpr std::uint16_t half_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000u, size = bits & 0x7FFFFFFFu;
  // Below 2^-14: a sum at which floats are multiples of 2^-24, as such halves are.
  const std::uint32_t small = std::bit_cast<std::uint32_t>(std::bit_cast<float>(size) + 0.5f) - 0x3F000000u;
  const std::uint32_t large = (size - 0x38000000u + 0xFFFu + (size >> 13 & 1u)) >> 13;
  std::uint32_t half = chosen_bits(size < 0x38800000u, small, large);
  half = chosen_bits(size >= 0x477FF000u, 0x7C00u, half);  // infinity
  half = chosen_bits(size > 0x7F800000u, 0x7E00u, half);   // NaN
  return static_cast<std::uint16_t>(sign | half);
}

constexpr float value_of_half(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000u) << 16, size = half & 0x7FFFu;
  const auto small = std::bit_cast<std::uint32_t>(static_cast<float>(static_cast<int>(size)) * 0x1p-24f);
  const std::uint32_t bits = chosen_bits(size < 0x400u, small, (size << 13) + 0x38000000u);
  return std::bit_cast<float>(sign | chosen_bits(size >= 0x7C00u, 0x7F800000u | (size & 0x3FFu) << 13, bits));
}

// The nearest value that a half holds.
constexpr float rounded_to_half(float value) { return value_of_half(half_of(value)); }

// Rounds each to the nearest value that a half holds. O(N), vectors of the baseline.
inline void round_to_halves(std::span<float> values) {
  for (float& value : values) value = rounded_to_half(value);
}

}  // namespace meander
