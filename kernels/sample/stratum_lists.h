// Internal to kernels/sample: lists of strata, a few bytes for each entry.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace meander {

// For every stratum a set of others. Neighbors along the path are most of them, so that they are kept as
// ascending differences, one byte below 128. Lists are written by blocks of strata, each by one thread, and
// read by any.
class StratumLists {
 public:
  StratumLists(std::size_t strata, std::size_t block)
      : block_(block), begin_(strata), bytes_((strata + block - 1) / block) {}

  // Strata of a block are written in ascending order. others: distinct, without the stratum itself; sorted
  // here.
  void write(std::size_t stratum, std::vector<std::uint32_t>& others) {
    std::vector<std::uint8_t>& bytes = bytes_[stratum / block_];
    begin_[stratum] = static_cast<std::uint32_t>(bytes.size());
    std::sort(others.begin(), others.end());
    put(others.size(), bytes);
    std::uint32_t before = 0;
    bool first = true;
    for (const std::uint32_t other : others) {
      if (first) {
        // From the stratum to the first one: the sign in the lowest bit.
        const bool back = other < stratum;
        const std::uint64_t far = back ? stratum - other : other - stratum;
        put(far << 1 | (back ? 1u : 0u), bytes);
        first = false;
      } else {
        put(other - before, bytes);
      }
      before = other;
    }
  }
  // After the last stratum of a block.
  void close(std::size_t block) { bytes_[block].shrink_to_fit(); }

  // Replaces `others` by those of the stratum, ascending.
  void read(std::size_t stratum, std::vector<std::uint32_t>& others) const {
    const std::uint8_t* at = bytes_[stratum / block_].data() + begin_[stratum];
    others.resize(take(at));
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < others.size(); ++i) {
      const std::uint64_t difference = take(at);
      if (i > 0)
        before += static_cast<std::uint32_t>(difference);
      else
        before = static_cast<std::uint32_t>((difference & 1) != 0 ? stratum - (difference >> 1)
                                                                  : stratum + (difference >> 1));
      others[i] = before;
    }
  }

 private:
  static void put(std::uint64_t value, std::vector<std::uint8_t>& bytes) {
    for (; value >= 128; value >>= 7) bytes.push_back(static_cast<std::uint8_t>(value | 128));
    bytes.push_back(static_cast<std::uint8_t>(value));
  }
  static std::uint64_t take(const std::uint8_t*& at) {
    std::uint64_t value = *at & 127;
    for (unsigned shift = 7; (*at++ & 128) != 0; shift += 7) value |= std::uint64_t{*at & 127u} << shift;
    return value;
  }

  std::size_t block_;
  std::vector<std::uint32_t> begin_;              // of each list in the bytes of its block
  std::vector<std::vector<std::uint8_t>> bytes_;  // by block
};

}  // namespace meander
