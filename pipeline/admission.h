// Decides which item may start next: by bytes in flight, largest first, with backfilling.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

namespace meander {

// Bookkeeping without threads, owned by one serial node of the graph. The largest waiting item goes first.
// While it does not fit, smaller items may pass it without delaying it: they leave room for it, so that it
// starts as soon as the items that were in flight before have ended.
class Admission {
 public:
  struct Ticket {
    std::size_t item = 0;
    std::uint64_t bytes = 0;
    std::uint64_t ahead_of = 0;  // number of the waiting item that this one passed; 0: none
  };

  // budget: maximum bytes in flight; max_items >= 1: maximum items in flight, which are retried after a
  // crash. An item larger than the whole budget runs alone if `allow_oversize` is set.
  Admission(std::uint64_t budget, std::size_t max_items, bool allow_oversize)
      : budget_(budget), max_items_(max_items), allow_oversize_(allow_oversize) {}

  bool too_large(std::uint64_t bytes) const { return bytes > budget_ && !allow_oversize_; }
  void add(std::size_t item, std::uint64_t bytes) { waiting_.insert({bytes, item}); }  // not too_large
  std::optional<Ticket> next();        // admits the next item that may start; its bytes are now in flight
  void release(const Ticket& ticket);  // called when the item has ended, or is to be added again
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
  std::uint64_t bytes_ahead_ = 0;  // bytes in flight of items that passed the present front item
};

}  // namespace meander
