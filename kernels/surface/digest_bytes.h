// A 128-bit digest of numbers, which keys the randomness; not for security.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "kernels/core/random.h"

namespace meander {

class DigestBytes {
 public:
  void add(std::uint64_t word) {
    state_[0] ^= static_cast<std::uint32_t>(word);
    state_[1] ^= static_cast<std::uint32_t>(word >> 32);
    state_ = philox4x32(state_, {0x9E3779B9u, 0xBB67AE85u});
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }

  std::array<std::uint8_t, 16> bytes() const {
    std::array<std::uint8_t, 16> result{};
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = static_cast<std::uint8_t>(state_[i / 4] >> (8 * (i % 4)));
    return result;
  }

 private:
  PhiloxBlock state_{};
};

}  // namespace meander
