// Internal to kernels/sample: lists of strata, a few bytes for each entry.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <utility>
#include <vector>

namespace meander {

// For every stratum a set of others. Neighbors along the path are most of them, so that they are kept as runs
// of successive ones: for each run, the way to it from the one before and its length, most of them in one
// byte together. Lists are written by blocks of strata, each by one thread, and read by any.
class StratumLists {
 public:
  StratumLists(std::size_t strata, std::size_t block)
      : block_(block), begin_(strata), bytes_((strata + block - 1) / block) {}

  // Strata of a block are written in ascending order. others: distinct; sorted here.
  void write(std::size_t stratum, std::vector<std::uint32_t>& others) {
    std::vector<std::uint8_t>& bytes = bytes_[stratum / block_];
    begin_[stratum] = static_cast<std::uint32_t>(bytes.size());
    if (!std::is_sorted(others.begin(), others.end())) std::sort(others.begin(), others.end());
    put(others.size(), bytes);
    std::uint64_t at = stratum;
    for (std::size_t i = 0, end; i < others.size(); i = end) {
      end = i + 1;
      while (end < others.size() && end - i < max_run && others[end] == others[i] + (end - i)) ++end;
      // The first run is on either side of the stratum: the sign in the lowest bit.
      const std::uint64_t way = i > 0            ? others[i] - at
                                : others[i] < at ? (at - others[i]) << 1 | 1
                                                 : (others[i] - at) << 1;
      put(way * max_run + (end - i - 1), bytes);
      at = others[end - 1] + std::uint64_t{1};
    }
  }
  // After the last stratum of a block.
  void close(std::size_t block) { bytes_[block].shrink_to_fit(); }

  // Replaces `others` by those of the stratum, ascending.
  void read(std::size_t stratum, std::vector<std::uint32_t>& others) const {
    others.resize(size(stratum));
    visit_runs(stratum, [&](std::size_t i, std::uint32_t next, std::size_t length) {
      for (const std::size_t end = i + length; i < end; ++i) others[i] = next++;
    });
  }
  std::size_t size(std::size_t stratum) const {
    const std::uint8_t* at = bytes_of(stratum);
    return take(at);
  }

  // A run is no longer than this.
  static constexpr std::size_t max_run = 8;
  // Calls visit(i, first, length) for the runs of the list, ascending: the i-th entry is `first`, and those
  // after it, `length` in all, follow on it.
  template <class Visit>
  void visit_runs(std::size_t stratum, const Visit& visit) const {
    const std::uint8_t* at = bytes_of(stratum);
    const std::size_t count = take(at);
    std::uint64_t next = stratum;
    for (std::size_t i = 0; i < count;) {
      const std::uint64_t run = take(at), way = run / max_run;
      const std::size_t length = run % max_run + 1;
      if (i > 0)
        next += way;
      else
        next = (way & 1) != 0 ? stratum - (way >> 1) : stratum + (way >> 1);
      visit(i, static_cast<std::uint32_t>(next), length);
      next += length;
      i += length;
    }
  }
  // Copies a row of numbers by stratum for all of the list. from: with `max_run` numbers after the last
  // stratum's; to: with as many after the list's.
  void gather(std::size_t stratum, std::initializer_list<std::pair<const float*, float*>> rows) const {
    visit_runs(stratum, [&](std::size_t i, std::uint32_t first, std::size_t) {
      for (const auto& [from, to] : rows) std::memcpy(to + i, from + first, max_run * sizeof(float));
    });
  }

 private:
  const std::uint8_t* bytes_of(std::size_t stratum) const {
    return bytes_[stratum / block_].data() + begin_[stratum];
  }
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
