// The time that a run has left, from the estimated work of its items and the seconds that they took.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace meander {

// Items of unequal work are finished in any order, usually the largest first. The seconds of the rest are its
// estimated work by the rate of the latest items: the estimate of large items and that of small ones may be
// wrong by different factors. A few items that take far longer than their like do not change the rate much.
class RemainingTime {
 public:
  // work: estimated seconds of all items (work_estimate.h). Each thread works on one.
  RemainingTime(double work, int threads);

  // An item of this work is done, `now` seconds after the start, and took `seconds`; those that are still in
  // flight have taken `in_flight` together.
  void finished(double work, double seconds, double now, double in_flight);
  // Empty until an item is done.
  std::optional<double> left(double now) const;
  // The part of the work that is done, 0 to 1.
  double share() const;

 private:
  double work_;
  int threads_;
  double done_work_ = 0, busy_ = 0;
  std::uint64_t items_ = 0;
  std::vector<double> rates_;  // of the latest items: seconds per estimated second
  // Sums in which an item counts the less the older it is.
  double latest_seconds_ = 0, latest_work_ = 0, latest_items_ = 0;
  double estimate_ = 0, estimated_at_ = 0;
};

}  // namespace meander
