// Finds in which part of a whole a place lies.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// Parts one behind the other, by where they end: `end` ascends, may be any length above 0, and must outlive
// the search. Where to begin is looked up by as many equal parts of the whole, so that a search takes O(1) in
// the mean over evenly spread places, in any order, and O(N) at most. O(N) and 4 N bytes to make.
class ShareSearch {
 public:
  explicit ShareSearch(std::span<const double> end) : end_(end) {
    begin_.reserve(end.size());
    const auto count = static_cast<double>(end.size());
    for (std::size_t i = 0; begin_.size() < end.size();) {
      if (end[i] * count < end.back() * static_cast<double>(begin_.size()))
        ++i;
      else
        begin_.push_back(static_cast<std::uint32_t>(i));
    }
  }

  // The first part that ends after share * end.back(), or the last. share: in [0, 1].
  std::size_t operator()(double share) const {
    const std::size_t last = end_.size() - 1;
    const double at = share * end_.back();
    std::size_t i =
        begin_[std::min(last, static_cast<std::size_t>(share * static_cast<double>(end_.size())))];
    while (i > 0 && end_[i - 1] > at) --i;
    while (i < last && end_[i] <= at) ++i;
    return i;
  }

 private:
  std::span<const double> end_;
  std::vector<std::uint32_t> begin_;
};

}  // namespace meander
