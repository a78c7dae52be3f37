// Decides which item may start next: by bytes in flight, largest first, with back-filling.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

namespace meander {

// Pure bookkeeping, no threads: one serial node of the graph owns it. The largest waiting item goes first;
// while it does not fit, smaller ones may pass it, but without delaying it: items that pass leave room for
// it, so it starts as soon as the items that were in flight before it have ended.
class Admission {
 public:
  struct Ticket {
    std::size_t item = 0;
    std::uint64_t bytes = 0;
    std::uint64_t ahead_of = 0;  // number of the waiting item that this one was sent ahead of; 0: none
  };

  // budget: bytes that may be in flight at once; max_items: items in flight, >= 1 (what a crash may have to
  // look at again); an item larger than the whole budget runs alone when `allow_oversize` is set.
  Admission(std::uint64_t budget, std::size_t max_items, bool allow_oversize)
      : budget_(budget), max_items_(max_items), allow_oversize_(allow_oversize) {}

  bool too_large(std::uint64_t bytes) const { return bytes > budget_ && !allow_oversize_; }
  void add(std::size_t item, std::uint64_t bytes) { waiting_.insert({bytes, item}); }  // not too_large
  std::optional<Ticket> next();        // the next item that may start; its bytes are in flight from now on
  void release(const Ticket& ticket);  // it has ended, or goes back to be added again
  std::size_t waiting() const { return waiting_.size(); }
  std::size_t items_in_flight() const { return items_; }
  std::uint64_t bytes_in_flight() const { return bytes_; }
  std::uint64_t peak_bytes() const { return peak_bytes_; }
  void drop_waiting() { waiting_.clear(); }

 private:
  struct LargestFirst {
    bool operator()(const std::pair<std::uint64_t, std::size_t>& a,
                    const std::pair<std::uint64_t, std::size_t>& b) const {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    }
  };
  using Waiting = std::set<std::pair<std::uint64_t, std::size_t>, LargestFirst>;
  Ticket take(Waiting::iterator at, std::uint64_t ahead_of);

  Waiting waiting_;
  std::uint64_t budget_;
  std::size_t max_items_;
  bool allow_oversize_;
  std::uint64_t bytes_ = 0, peak_bytes_ = 0;
  std::size_t items_ = 0;
  std::uint64_t epoch_ = 1;        // number of the item at the front of the queue
  std::uint64_t bytes_ahead_ = 0;  // in flight, sent ahead of the present front item
};

}  // namespace meander
