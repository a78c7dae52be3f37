// Niederreiter 1972 for the finite set of boxes; De Clerck 1986 for the sorted sweep in the plane.
#include "kernels/analyse/discrepancy_star.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "kernels/analyse/point_index.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"

namespace meander {

namespace {

void check_points(std::span<const double> x, std::span<const double> y) {
  if (x.empty() || x.size() != y.size())
    throw std::invalid_argument("a discrepancy needs points, and as many x as y");
}

std::vector<std::uint32_t> order_by(std::span<const double> first, std::span<const double> second) {
  std::vector<std::uint32_t> order(first.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    if (first[i] != first[j]) return first[i] < first[j];
    return second[i] != second[j] ? second[i] < second[j] : i < j;
  });
  return order;
}

// Maximum over k of a sign x (share[k] - width x height[k]); four lanes, so that comparisons overlap.
double steepest(const double* share, const double* height, std::size_t count, double width, double sign) {
  std::array<double, 4> most{};
  std::size_t k = 0;
  for (; k + 4 <= count; k += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const double d = sign * (share[k + lane] - width * height[k + lane]);
      most[lane] = d > most[lane] ? d : most[lane];
    }
  for (; k < count; ++k) most[0] = std::max(most[0], sign * (share[k] - width * height[k]));
  return std::max({most[0], most[1], most[2], most[3]});
}

}  // namespace

double star_discrepancy_exact(std::span<const double> x, std::span<const double> y) {
  check_points(x, y);
  const std::size_t n = x.size();
  const std::vector<std::uint32_t> order = order_by(x, y);
  std::vector<double> share(n + 1);
  for (std::size_t j = 0; j <= n; ++j) share[j] = static_cast<double>(j) / static_cast<double>(n);

  // Columns [x_i, x_i+1) between points in order of x; heights: the sorted y of the points up to column i,
  // between sentinels. A closed box (x_i, y_j) whose column's point is above it would be no smaller further
  // left, so only j from that point upwards matter; an open box (x_i+1, y_j+1) likewise has the next column's
  // point below its upper edge. Where coordinates are equal the counts are lower bounds of the box's own.
  constexpr std::size_t block = 512;
  std::vector<double> most((n + block - 1) / block, 0.0);
  parallel_tasks(most.size(), [&](std::size_t b) {
    const std::size_t first = b * block, last = std::min(n, first + block);
    std::vector<double> heights = {0};
    heights.reserve(last + 2);
    for (std::size_t i = 0; i < first; ++i) heights.push_back(y[order[i]]);
    heights.push_back(1);
    std::sort(heights.begin() + 1, heights.end() - 1);
    double best = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double right = x[order[i]], top = y[order[i]];
      // heights holds i points: the open boxes up to the new point's x, then the closed ones with it.
      const auto place = static_cast<std::size_t>(
          std::upper_bound(heights.begin() + 1, heights.end() - 1, top) - heights.begin());
      best = std::max(best,
                      steepest(share.data() + place - 1, heights.data() + place, i + 2 - place, right, -1));
      heights.insert(heights.begin() + static_cast<std::ptrdiff_t>(place), top);
      best = std::max(best, steepest(share.data() + place, heights.data() + place, i + 2 - place, right, 1));
    }
    if (last == n)  // open boxes as wide as the square
      best = std::max(best, steepest(share.data(), heights.data() + 1, n + 1, 1, -1));
    most[b] = best;
  });
  return *std::max_element(most.begin(), most.end());
}

namespace {

// The points as seen along one axis: sorted by it, with the other coordinate beside.
struct Axis {
  std::vector<double> along, across;
};

Axis sort_along(std::span<const double> first, std::span<const double> second) {
  const std::vector<std::uint32_t> order = order_by(first, second);
  Axis axis;
  for (const std::uint32_t i : order) {
    axis.along.push_back(first[i]);
    axis.across.push_back(second[i]);
  }
  return axis;
}

struct LineMaximum {
  double discrepancy = 0;
  double at = 1;  // where the other edge lies
};

// The maximum over all boxes with one edge at `edge`, closed there or not: one pass over the points.
LineMaximum best_on_line(const Axis& axis, double edge) {
  const std::size_t n = axis.along.size();
  const double step = 1 / static_cast<double>(n);
  LineMaximum best;
  std::size_t below = 0, at_or_below = 0;  // points left of the edge, or on it
  for (std::size_t i = 0; i < n; ++i) {
    const double height = axis.along[i];
    const double open = edge * height - static_cast<double>(below) * step;
    if (open > best.discrepancy) best = {open, height};
    below += static_cast<std::size_t>(axis.across[i] < edge);
    at_or_below += static_cast<std::size_t>(axis.across[i] <= edge);
    const double closed = static_cast<double>(at_or_below) * step - edge * height;
    if (closed > best.discrepancy) best = {closed, height};
  }
  const double open = edge - static_cast<double>(below) * step;
  if (open > best.discrepancy) best = {open, 1};
  return best;
}

}  // namespace

double star_discrepancy_search(std::span<const double> x, std::span<const double> y,
                               const StarSearchParameters& parameters) {
  check_points(x, y);
  if (parameters.boxes == 0 || parameters.boxes > 1u << 20)
    throw std::invalid_argument("star_discrepancy_search takes 1 .. 2^20 boxes");
  const std::size_t n = x.size();
  const Axis by_x = sort_along(x, y), by_y = sort_along(y, x);
  const PointIndex<2> points = build_point_index(x, y);

  struct Start {
    double discrepancy;
    double a, b;
  };
  std::vector<Start> starts(parameters.boxes);
  const RandomKey key = make_random_key(parameters.seed, {});
  parallel_tasks(starts.size(), [&](std::size_t i) {
    const UnitPair u = random_pair(key, Stream::test_shapes, i);
    const double a = by_x.along[static_cast<std::size_t>(u.first * static_cast<double>(n))];
    const double b = by_y.along[static_cast<std::size_t>(u.second * static_cast<double>(n))];
    const std::array<HalfSpace<2>, 2> box = {{{{1, 0}, a}, {{0, 1}, b}}};
    const double error = static_cast<double>(count_inside(points, box)) / static_cast<double>(n) - a * b;
    starts[i] = {std::abs(error), a, b};
  });
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.discrepancy > b.discrepancy; });
  starts.resize(std::min<std::size_t>(starts.size(), std::max(1u, parameters.climbs)));
  parallel_tasks(starts.size(), [&](std::size_t i) {
    Start& start = starts[i];
    start.discrepancy = 0;  // an open and a closed box share a corner: let the line searches decide
    for (int side = 0;; ++side) {
      const bool along_y = side % 2 == 0;
      const LineMaximum found = along_y ? best_on_line(by_y, start.a) : best_on_line(by_x, start.b);
      if (found.discrepancy <= start.discrepancy && side > 1) break;
      start.discrepancy = std::max(start.discrepancy, found.discrepancy);
      (along_y ? start.b : start.a) = found.at;
    }
  });
  double best = 0;
  for (const Start& start : starts) best = std::max(best, start.discrepancy);
  return best;
}

}  // namespace meander
