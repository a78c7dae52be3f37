// Which points of a large set have to be drawn again, as another sample has the same.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/sample/redraw_limit.h"

namespace meander {

// A point as it is drawn, and the counter of the draw that would follow.
struct DrawnPoint {
  std::array<float, 3> at;
  std::uint32_t next_counter;
};

// The draw that a sample keeps in place of its first one.
struct Redraw {
  std::uint32_t rank, counter;
  friend bool operator==(const Redraw&, const Redraw&) = default;
};

struct Redraws {
  std::vector<Redraw> redraw;    // ascending by rank
  std::uint32_t coincident = 0;  // of them, those that were never at a place of their own
};

namespace distinct_points {

inline std::uint64_t hash_of(const std::array<float, 3>& p) {
  std::uint64_t hash = std::bit_cast<std::uint32_t>(p[0]);
  hash = (hash * 0x9E3779B97F4A7C15u) ^ std::bit_cast<std::uint32_t>(p[1]);
  hash = (hash * 0x9E3779B97F4A7C15u) ^ std::bit_cast<std::uint32_t>(p[2]);
  // SplitMix64 finaliser (Steele, Lea, Flood 2014): its upper bits are what is kept.
  hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9u;
  hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBu;
  return hash ^ (hash >> 31);
}

// Numbers by the hashes of their points, with open addressing: 16 to 32 bytes each.
class NumberSet {
 public:
  // Whether a number of this hash satisfies `equal`.
  template <class Equal>
  bool contains(std::uint64_t hash, const Equal& equal) const {
    for (std::size_t s = slot_of(hash); slots_[s] != free_slot; s = (s + 1) & (slots_.size() - 1))
      if (slots_[s] >> 32 == hash >> 32 && equal(static_cast<std::uint32_t>(slots_[s]))) return true;
    return false;
  }
  void insert(std::uint64_t hash, std::uint32_t number) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    put(hash >> 32 << 32 | number);
    ++count_;
  }

 private:
  static constexpr std::uint64_t free_slot = ~std::uint64_t{0};  // no number is 2^32 - 1
  std::size_t slot_of(std::uint64_t hash) const {
    return static_cast<std::size_t>((hash >> 32) * 0x9E3779B97F4A7C15u >> 20) & (slots_.size() - 1);
  }
  void put(std::uint64_t slot) {
    std::size_t s = slot_of(slot);
    while (slots_[s] != free_slot) s = (s + 1) & (slots_.size() - 1);
    slots_[s] = slot;
  }
  void grow() {
    std::vector<std::uint64_t> old(2 * slots_.size(), free_slot);
    old.swap(slots_);
    for (const std::uint64_t slot : old)
      if (slot != free_slot) put(slot);
  }

  std::vector<std::uint64_t> slots_ = std::vector<std::uint64_t>(64, free_slot);
  std::size_t count_ = 0;
};

// The upper 33 bits of the hash of a point, and its rank: 8 bytes a sample.
inline constexpr int rank_bits = 31, bucket_bits = 8;
inline std::uint64_t entry_of(const std::array<float, 3>& p, std::uint64_t rank) {
  return hash_of(p) >> rank_bits << rank_bits | rank;
}
inline std::uint64_t hash_in(std::uint64_t entry) { return entry >> rank_bits; }
inline std::uint32_t rank_in(std::uint64_t entry) {
  return static_cast<std::uint32_t>(entry & ((std::uint64_t{1} << rank_bits) - 1));
}

// Sorts by hash, in place but for one bucket a thread; where each bucket begins.
inline std::vector<std::size_t> sort_entries(std::vector<std::uint64_t>& entries, const CancelToken& cancel) {
  constexpr std::size_t buckets = std::size_t{1} << bucket_bits;
  const auto bucket_of = [](std::uint64_t entry) {
    return static_cast<std::size_t>(entry >> (64 - bucket_bits));
  };
  std::vector<std::size_t> begin(buckets + 1, 0);
  for (const std::uint64_t entry : entries) ++begin[bucket_of(entry) + 1];
  for (std::size_t b = 0; b < buckets; ++b) begin[b + 1] += begin[b];
  // Every entry is put where its bucket has room, and the one that was there taken along (McIlroy, Bostic,
  // McIlroy 1993).
  std::vector<std::size_t> room(begin.begin(), begin.end() - 1);
  for (std::size_t b = 0; b < buckets; ++b) {
    cancel.check();
    while (room[b] < begin[b + 1]) {
      std::uint64_t entry = entries[room[b]];
      for (std::size_t own = bucket_of(entry); own != b; own = bucket_of(entry))
        std::swap(entry, entries[room[own]++]);
      entries[room[b]++] = entry;
    }
  }
  parallel_tasks(buckets, [&](std::size_t b) {
    cancel.check();
    const auto first = entries.begin() + static_cast<std::ptrdiff_t>(begin[b]),
               last = entries.begin() + static_cast<std::ptrdiff_t>(begin[b + 1]);
    const std::size_t usual = 4 * (entries.size() / buckets + 64);
    if (begin[b + 1] - begin[b] > usual) {  // many equal points: without another copy of so many
      std::sort(first, last);
      return;
    }
    std::vector<std::uint64_t> own(first, last), scratch;
    radix_sort_words(own, scratch, rank_bits);
    std::copy(own.begin(), own.end(), first);
  });
  return begin;
}

}  // namespace distinct_points

// Finds what takes N points apart: in the order of ranks, a point that equals that of a lower rank is drawn
// again, up to redraws times (RedrawLimit), until it equals none of these. The points themselves are not
// kept: memory is 8 bytes a sample, and at most 60 for one that is drawn again. count: N, at most 2^31.
//   first(rank): the point of the first draw, and counter(rank): that of the second. again(rank, counter): a
//   DrawnPoint from this counter on. All pure; points are without negative zeros.
// O(N); a redraw costs O(log N), and a sample has no more of them than a RedrawLimit allows. Parallel but for
// the redraws. Deterministic for every thread count.
template <class First, class Counter, class Again>
Redraws find_redraws(std::size_t count, const First& first, const Counter& counter, const Again& again,
                     int redraws, const CancelToken& cancel) {
  using namespace distinct_points;
  std::vector<std::uint64_t> entries(count);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    for (std::size_t r = begin; r < end; ++r) entries[r] = entry_of(first(static_cast<std::uint32_t>(r)), r);
  });
  const std::vector<std::size_t> bucket = sort_entries(entries, cancel);

  // All but the lowest rank of those at one place.
  std::vector<std::vector<std::uint32_t>> found(bucket.size() - 1);
  parallel_tasks(found.size(), [&](std::size_t b) {
    cancel.check();
    std::vector<std::pair<std::array<float, 3>, std::uint32_t>> points;
    for (std::size_t i = bucket[b], next = i; i < bucket[b + 1]; i = next) {
      while (next < bucket[b + 1] && hash_in(entries[next]) == hash_in(entries[i])) ++next;
      if (next == i + 1) continue;
      points.clear();
      for (std::size_t k = i; k < next; ++k)
        points.emplace_back(first(rank_in(entries[k])), rank_in(entries[k]));
      std::sort(points.begin(), points.end());
      for (std::size_t k = 1; k < points.size(); ++k)
        if (points[k].first == points[k - 1].first) found[b].push_back(points[k].second);
    }
  });
  std::vector<std::uint32_t> equal;
  for (std::vector<std::uint32_t>& ranks : found) {
    equal.insert(equal.end(), ranks.begin(), ranks.end());
    ranks = std::vector<std::uint32_t>();
  }
  std::priority_queue<std::uint32_t, std::vector<std::uint32_t>, std::greater<>> waiting(std::greater<>(),
                                                                                         std::move(equal));

  Redraws result;
  NumberSet taken;  // numbers in result.redraw of those at a place of their own
  std::vector<std::uint32_t> displaced;
  // Whether no lower rank is at the point; higher ones whose first draw is there are `displaced`. Where the
  // first draw of a lower rank was, there is always one: where it moved on, that of another.
  const auto is_free = [&](const std::array<float, 3>& point, std::uint32_t rank) {
    displaced.clear();
    const auto is_there = [&](std::uint32_t number) {
      const Redraw& redraw = result.redraw[number];
      return again(redraw.rank, redraw.counter).at == point;
    };
    if (taken.contains(hash_of(point), is_there)) return false;
    const std::uint64_t entry = entry_of(point, 0);
    const std::size_t b = static_cast<std::size_t>(entry >> (64 - bucket_bits));
    const auto begin = entries.begin() + static_cast<std::ptrdiff_t>(bucket[b]),
               end = entries.begin() + static_cast<std::ptrdiff_t>(bucket[b + 1]);
    for (auto at =
             std::partition_point(begin, end, [&](std::uint64_t e) { return hash_in(e) < hash_in(entry); });
         at != end && hash_in(*at) == hash_in(entry); ++at) {
      if (first(rank_in(*at)) != point) continue;
      if (rank_in(*at) <= rank) return false;
      displaced.push_back(rank_in(*at));
    }
    return true;
  };
  std::size_t steps = 0;
  RedrawLimit limit(redraws);
  while (!waiting.empty()) {
    const std::uint32_t rank = waiting.top();
    while (!waiting.empty() && waiting.top() == rank) waiting.pop();
    if (++steps % 256 == 0) cancel.check();
    Redraw kept{rank, 0};
    bool distinct = false;
    std::uint32_t next = counter(rank);
    for (int redraw = 0; redraw < limit.now() && !distinct; ++redraw) {
      kept.counter = next;
      const DrawnPoint drawn = again(rank, next);
      next = drawn.next_counter;
      distinct = is_free(drawn.at, rank);
      if (distinct) taken.insert(hash_of(drawn.at), static_cast<std::uint32_t>(result.redraw.size()));
    }
    if (distinct) {
      limit.found();
      for (const std::uint32_t other : displaced) waiting.push(other);
    } else {
      limit.exhausted();
      ++result.coincident;
    }
    result.redraw.push_back(kept);
  }
  return result;
}

}  // namespace meander
