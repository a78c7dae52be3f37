// A bound on the effort spent on one piece of work, counted, never timed: the same on every machine.
#pragma once

#include <cstdint>

namespace meander {

// A unit is about one multiplication and addition of a factorization. Loops without a bound of their own
// spend before they work and end when they are refused. After a refusal nothing is granted any more, so all
// loops that share a budget end. A budget is for one thread at a time: the order of several would decide who
// is refused.
class WorkBudget {
 public:
  explicit WorkBudget(std::uint64_t units) : left_(units) {}

  // Takes `units` and returns true; returns false, now and ever after, when fewer are left.
  bool spend(std::uint64_t units) {
    exhausted_ = exhausted_ || units > left_;
    left_ -= exhausted_ ? left_ : units;
    return !exhausted_;
  }
  bool exhausted() const { return exhausted_; }
  std::uint64_t left() const { return left_; }

 private:
  std::uint64_t left_;
  bool exhausted_ = false;
};

// The same with null for work without a bound.
inline bool spend(WorkBudget* budget, std::uint64_t units) {
  return budget == nullptr || budget->spend(units);
}

}  // namespace meander
