#include "jobs/cli/remaining_time.h"

#include <algorithm>

namespace meander {

namespace {

constexpr std::size_t items_compared = 41;   // the latest ones, whose median rate is taken
constexpr std::size_t items_estimated = 12;  // so many have the rate 1 of the estimate before any is done
constexpr double most_over_median = 2.5;     // an item counts at most this much more than those
constexpr double kept = 0.9966;              // of the weight of an item by each later one: half by 200
constexpr double median_weight = 10;         // as how many items the median counts beside their mean

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

RemainingTime::RemainingTime(double work, int threads)
    : work_(work), threads_(threads), rates_(items_estimated, 1.0) {}

void RemainingTime::finished(double work, double seconds, double now, double in_flight) {
  ++items_;
  done_work_ += work;
  busy_ += seconds;
  if (work > 0) {
    if (rates_.size() == items_compared) rates_.erase(rates_.begin());
    rates_.push_back(seconds / work);
    const double rate = std::min(rates_.back(), most_over_median * median_of(rates_));
    latest_seconds_ = kept * latest_seconds_ + rate * work;
    latest_work_ = kept * latest_work_ + work;
    latest_items_ = kept * latest_items_ + 1;
  }
  const double median_work = latest_items_ > 0 ? median_weight * latest_work_ / latest_items_ : 1;
  const double rate = (median_of(rates_) * median_work + latest_seconds_) / (median_work + latest_work_);
  // How many items are worked on at once. A large item that is not yet done may be most of it.
  const double at_once = now > 0 ? (busy_ + in_flight) / now : threads_;
  estimate_ = rate * std::max(0.0, work_ - done_work_) / std::max(at_once, 1e-3);
  estimated_at_ = now;
}

std::optional<double> RemainingTime::left(double now) const {
  if (items_ == 0) return std::nullopt;
  return std::max(0.0, estimate_ - (now - estimated_at_));
}

double RemainingTime::share() const { return work_ > 0 ? std::min(1.0, done_work_ / work_) : 0; }

}  // namespace meander
