#include "pipeline/admission.h"

#include <algorithm>

namespace meander {

Admission::Ticket Admission::take(Waiting::iterator at, std::uint64_t ahead_of) {
  const Ticket ticket{at->second, at->first, ahead_of};
  waiting_.erase(at);
  bytes_ += ticket.bytes;
  peak_bytes_ = std::max(peak_bytes_, bytes_);
  ++items_;
  if (ahead_of == 0) {  // the front item starts: all items in flight count as started before the next one
    ++epoch_;
    bytes_ahead_ = 0;
  } else {
    bytes_ahead_ += ticket.bytes;
  }
  return ticket;
}

std::optional<Admission::Ticket> Admission::next() {
  if (waiting_.empty() || items_ >= max_items_) return std::nullopt;
  const std::uint64_t front = waiting_.begin()->first;
  if (bytes_ + front <= budget_ || (items_ == 0 && front > budget_)) return take(waiting_.begin(), 0);
  if (bytes_ >= budget_) return std::nullopt;
  const std::uint64_t free = budget_ - bytes_;
  const std::uint64_t beside_front = budget_ - std::min(front, budget_);
  if (beside_front <= bytes_ahead_) return std::nullopt;
  const auto fitting = waiting_.lower_bound({std::min(free, beside_front - bytes_ahead_), 0});
  if (fitting == waiting_.end()) return std::nullopt;
  return take(fitting, epoch_);
}

void Admission::release(const Ticket& ticket) {
  bytes_ -= ticket.bytes;
  --items_;
  if (ticket.ahead_of == epoch_) bytes_ahead_ -= ticket.bytes;
}

}  // namespace meander
