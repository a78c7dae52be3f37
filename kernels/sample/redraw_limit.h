// How often a point that coincides with an earlier one is drawn again.
#pragma once

#include <algorithm>

namespace meander {

// At most redraws times; half as often, but once at least, after every sample in turn for which that was
// in vain. Where an element has fewer float32 points than samples, a strip of almost no width far from the
// origin say, nearly all of its samples coincide: without this each of them would be drawn redraws times.
// Samples are to be treated in the order of their ranks, which lie by elements.
class RedrawLimit {
 public:
  explicit RedrawLimit(int redraws) : most_(redraws), now_(redraws) {}
  int now() const { return now_; }
  void found() { now_ = most_; }
  void exhausted() { now_ = std::max(1, now_ / 2); }

 private:
  int most_, now_;
};

}  // namespace meander
