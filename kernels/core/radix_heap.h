// A monotone priority queue for Dijkstra: keys never fall below the last one taken out.
//
// Ahuja, Mehlhorn, Orlin, Tarjan 1990, "Faster algorithms for the shortest path problem". The bits of a
// non-negative double order like the double, so distances need no rounding.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace meander {

class RadixHeap {
 public:
  struct Entry {
    double key;  // >= 0, finite
    std::uint32_t value;
  };

  bool empty() const { return size_ == 0; }

  // key must be at least the key of the last pop (unless the heap is empty and was restarted).
  void push(double key, std::uint32_t value) {
    buckets_[bucket_of(key)].push_back({key, value});
    ++size_;
  }

  // Takes an entry of the smallest key; the heap must not be empty. Amortized O(number of key bits), in
  // practice a few moves.
  Entry pop() {
    if (buckets_[0].empty()) refill();
    const Entry entry = buckets_[0].back();
    buckets_[0].pop_back();
    --size_;
    return entry;
  }

  // Lets keys start from 0 again; only while empty.
  void restart() { last_ = 0; }

 private:
  static std::uint64_t bits(double key) { return std::bit_cast<std::uint64_t>(key); }
  std::size_t bucket_of(double key) const {
    return static_cast<std::size_t>(std::bit_width(bits(key) ^ last_));
  }

  void refill() {
    std::size_t b = 1;
    while (buckets_[b].empty()) ++b;
    std::uint64_t smallest = bits(buckets_[b].front().key);
    for (const Entry& entry : buckets_[b])
      if (bits(entry.key) < smallest) smallest = bits(entry.key);
    last_ = smallest;
    for (const Entry& entry : buckets_[b]) buckets_[bucket_of(entry.key)].push_back(entry);
    buckets_[b].clear();
  }

  std::array<std::vector<Entry>, 65> buckets_;
  std::uint64_t last_ = 0;
  std::size_t size_ = 0;
};

}  // namespace meander
