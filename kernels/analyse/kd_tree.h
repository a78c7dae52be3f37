// Balanced k-d tree over points (Bentley 1975; Friedman, Bentley, Finkel 1977): nearest neighbors and balls.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <vector>

namespace meander {

// Answers are those of comparing with every point, bit for bit: the bound of a node is summed from its axes
// in the order of the distance itself, and rounding is monotone. Deterministic; queries are thread-safe.
template <std::size_t Dimension>
class KdTree {
 public:
  using Point = std::array<double, Dimension>;
  static constexpr std::uint32_t none = 0xFFFFFFFFu;

  // coordinates: Dimension n numbers, interleaved, finite (else std::invalid_argument); n < 2^32 - 1.
  // O(n log n), about 0.3 us a point.
  explicit KdTree(std::span<const double> coordinates) {
    const std::size_t count = coordinates.size() / Dimension;
    for (const double c : coordinates)
      if (!std::isfinite(c)) throw std::invalid_argument("points must be finite");
    points_.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < Dimension; ++k) points_[i].at[k] = coordinates[Dimension * i + k];
    for (std::size_t i = 0; i < count; ++i) points_[i].index = static_cast<std::uint32_t>(i);
    low_.fill(std::numeric_limits<double>::infinity());
    high_.fill(-std::numeric_limits<double>::infinity());
    for (const Entry& entry : points_)
      for (std::size_t k = 0; k < Dimension; ++k) {
        low_[k] = std::min(low_[k], entry.at[k]);
        high_[k] = std::max(high_[k], entry.at[k]);
      }
    nodes_.reserve(2 * count / leaf + 2);
    if (count > 0) build(0, count);
  }

  std::size_t count() const { return points_.size(); }
  // Points in the order of the tree, where neighbors are near each other: the best order of queries.
  const Point& point(std::size_t position) const { return points_[position].at; }
  std::uint32_t index(std::size_t position) const { return points_[position].index; }

  struct Nearest {
    double squared = std::numeric_limits<double>::infinity();
    std::uint32_t index = none;
  };
  // Improves `best` by points other than `excluded`.
  void nearest(const Point& query, std::uint32_t excluded, Nearest& best) const {
    Point offset;
    if (count() > 0 && root_bound(query, offset) < best.squared)
      search(0, 0, count(), query, offset, excluded, best);
  }

  // Calls found(index, point) for every point at most sqrt(squared) away.
  template <class Found>
  void in_ball(const Point& query, double squared, const Found& found) const {
    Point offset;
    if (count() > 0 && root_bound(query, offset) <= squared)
      collect(0, 0, count(), query, offset, squared, found);
  }

 private:
  static constexpr std::size_t leaf = 8;
  struct Entry {
    Point at;
    std::uint32_t index = 0;
  };
  struct Node {  // the left child is the next node
    double split = 0;
    std::uint32_t right = 0, axis = 0;
  };

  static double square_norm(const Point& offset) {
    double sum = 0;
    for (std::size_t k = 0; k < Dimension; ++k) sum += offset[k] * offset[k];
    return sum;
  }
  static double squared_distance(const Point& a, const Point& b) {
    Point offset;
    for (std::size_t k = 0; k < Dimension; ++k) offset[k] = a[k] - b[k];
    return square_norm(offset);
  }

  std::uint32_t build(std::size_t begin, std::size_t end) {
    const auto node = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({});
    if (end - begin <= leaf) return node;
    Point low = points_[begin].at, high = low;
    for (std::size_t p = begin; p < end; ++p)
      for (std::size_t k = 0; k < Dimension; ++k) {
        low[k] = std::min(low[k], points_[p].at[k]);
        high[k] = std::max(high[k], points_[p].at[k]);
      }
    std::size_t axis = 0;
    for (std::size_t k = 1; k < Dimension; ++k)
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t p) { return points_.begin() + static_cast<std::ptrdiff_t>(p); };
    std::nth_element(at(begin), at(middle), at(end), [axis](const Entry& a, const Entry& b) {
      return a.at[axis] < b.at[axis] || (a.at[axis] == b.at[axis] && a.index < b.index);
    });
    const double split = points_[middle].at[axis];
    build(begin, middle);
    const std::uint32_t right = build(middle, end);
    nodes_[node] = {split, right, static_cast<std::uint32_t>(axis)};
    return node;
  }

  // Squared distance to the box of all points; offset: its components.
  double root_bound(const Point& query, Point& offset) const {
    for (std::size_t k = 0; k < Dimension; ++k)
      offset[k] = query[k] < low_[k] ? low_[k] - query[k] : query[k] > high_[k] ? query[k] - high_[k] : 0;
    return square_norm(offset);
  }

  void search(std::uint32_t node, std::size_t begin, std::size_t end, const Point& query, const Point& offset,
              std::uint32_t excluded, Nearest& best) const {
    if (end - begin <= leaf) {
      for (std::size_t p = begin; p < end; ++p) {
        const double squared = squared_distance(query, points_[p].at);
        if (squared < best.squared && points_[p].index != excluded) best = {squared, points_[p].index};
      }
      return;
    }
    const Node& here = nodes_[node];
    const std::size_t middle = begin + (end - begin) / 2;
    const double across = query[here.axis] - here.split;
    Point beyond = offset;
    beyond[here.axis] = std::max(std::abs(across), offset[here.axis]);
    if (across < 0) {
      search(node + 1, begin, middle, query, offset, excluded, best);
      if (square_norm(beyond) < best.squared) search(here.right, middle, end, query, beyond, excluded, best);
    } else {
      search(here.right, middle, end, query, offset, excluded, best);
      if (square_norm(beyond) < best.squared) search(node + 1, begin, middle, query, beyond, excluded, best);
    }
  }

  template <class Found>
  void collect(std::uint32_t node, std::size_t begin, std::size_t end, const Point& query,
               const Point& offset, double squared, const Found& found) const {
    if (end - begin <= leaf) {
      for (std::size_t p = begin; p < end; ++p)
        if (squared_distance(query, points_[p].at) <= squared) found(points_[p].index, points_[p].at);
      return;
    }
    const Node& here = nodes_[node];
    const std::size_t middle = begin + (end - begin) / 2;
    const double across = query[here.axis] - here.split;
    Point beyond = offset;
    beyond[here.axis] = std::max(std::abs(across), offset[here.axis]);
    const bool reaches = square_norm(beyond) <= squared;
    if (across < 0 || reaches)
      collect(node + 1, begin, middle, query, across < 0 ? offset : beyond, squared, found);
    if (across >= 0 || reaches)
      collect(here.right, middle, end, query, across < 0 ? beyond : offset, squared, found);
  }

  std::vector<Entry> points_;
  std::vector<Node> nodes_;
  Point low_, high_;
};

// A coordinate of a torus, moved to [0, period); a period of 0: that axis is a line, and nothing moves.
inline double wrapped(double coordinate, double period) {
  if (!(period > 0)) return coordinate;
  const double moved = coordinate - period * std::floor(coordinate / period);
  return moved < period ? moved : 0;
}

// Calls with_image(query + shift) for the query itself first and then for its images on the torus.
template <class WithImage>
void for_each_image(const std::array<double, 2>& query, double period_x, double period_y,
                    const WithImage& with_image) {
  with_image(query);
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j) {
      if ((i == 0 && j == 0) || (i != 0 && !(period_x > 0)) || (j != 0 && !(period_y > 0))) continue;
      with_image(std::array<double, 2>{query[0] + i * period_x, query[1] + j * period_y});
    }
}

}  // namespace meander
