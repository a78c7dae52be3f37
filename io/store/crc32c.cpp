#include "io/store/crc32c.h"

#include <array>
#include <cstring>

#include "kernels/core/vector_instructions.h"

namespace meander {

namespace {

constexpr std::uint32_t polynomial = 0x82F63B78u;  // reflected
// The instruction has a latency of three cycles and a throughput of one: three independent lanes fill it.
constexpr std::size_t lane_bytes = 1024;

// Multiplication of two polynomials modulo the CRC polynomial, bit-reflected.
constexpr std::uint32_t multiply(std::uint32_t a, std::uint32_t b) {
  std::uint32_t product = 0;
  for (int bit = 31; bit >= 0; --bit) {
    if (a >> bit & 1u) product ^= b;
    b = (b & 1u) ? b >> 1 ^ polynomial : b >> 1;
  }
  return product;
}

// x^(8 n) modulo the polynomial: multiplying a register by it is feeding n zero bytes.
constexpr std::uint32_t zero_bytes_operator(std::uint64_t n) {
  std::uint32_t power = 0x80000000u;   // 1
  std::uint32_t square = 0x00800000u;  // x^8
  for (; n != 0; n >>= 1) {
    if (n & 1u) power = multiply(power, square);
    square = multiply(square, square);
  }
  return power;
}

using ShiftTable = std::array<std::array<std::uint32_t, 256>, 4>;

constexpr ShiftTable make_shift_table(std::size_t zero_bytes) {
  const std::uint32_t factor = zero_bytes_operator(zero_bytes);
  ShiftTable table{};
  for (std::uint32_t byte = 0; byte < 4; ++byte)
    for (std::uint32_t value = 0; value < 256; ++value)
      table[byte][value] = multiply(factor, value << (8 * byte));
  return table;
}

constexpr ShiftTable shift_lane = make_shift_table(lane_bytes);

std::uint64_t shifted(std::uint64_t crc) {
  return shift_lane[0][crc & 0xFF] ^ shift_lane[1][crc >> 8 & 0xFF] ^ shift_lane[2][crc >> 16 & 0xFF] ^
         shift_lane[3][crc >> 24 & 0xFF];
}

std::uint64_t load(const std::byte* at) {
  std::uint64_t word;
  std::memcpy(&word, at, sizeof word);
  return word;
}

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) {
  std::uint64_t crc = ~before;
  const std::byte* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 3 * lane_bytes; at += 3 * lane_bytes, left -= 3 * lane_bytes) {
    std::uint64_t second = 0, third = 0;
    for (std::size_t i = 0; i < lane_bytes; i += 8) {
      crc = _mm_crc32_u64(crc, load(at + i));
      second = _mm_crc32_u64(second, load(at + lane_bytes + i));
      third = _mm_crc32_u64(third, load(at + 2 * lane_bytes + i));
    }
    crc = shifted(shifted(crc) ^ second) ^ third;
  }
  for (; left >= 8; at += 8, left -= 8) crc = _mm_crc32_u64(crc, load(at));
  for (; left > 0; ++at, --left)
    crc = _mm_crc32_u8(static_cast<std::uint32_t>(crc), std::to_integer<std::uint8_t>(*at));
  return ~static_cast<std::uint32_t>(crc);
}

std::uint32_t crc32c_joined(std::uint32_t first, std::uint32_t second, std::uint64_t second_bytes) {
  // The inversions before and after cancel out between the two.
  return multiply(zero_bytes_operator(second_bytes), first) ^ second;
}

}  // namespace meander
