// A bound on the effort spent on one piece of work, counted, never timed: the same on every machine.
#pragma once

#include <cstdint>

namespace meander {

// Units: about one multiplication and addition of a factorisation. Loops without a bound of their own spend
// before they work and end when they are refused. After that nothing more is granted, so that all loops which
// share a budget end. Not for several threads at once: their order would decide who is refused.
class WorkBudget {
 public:
  explicit WorkBudget(std::uint64_t units) : left_(units) {}

  // Takes `units` and returns true, or returns false, now and ever after, when fewer are left.
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

// The same for work that may be without a bound (null).
inline bool spend(WorkBudget* budget, std::uint64_t units) {
  return budget == nullptr || budget->spend(units);
}

}  // namespace meander
