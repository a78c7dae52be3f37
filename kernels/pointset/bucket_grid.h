// Points of the unit square by the cell of a square grid.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

struct BucketGrid {
  std::uint32_t side = 1;             // side x side cells
  std::vector<std::uint32_t> begin;   // points of cell c: points[begin[c]] .. points[begin[c + 1] - 1]
  std::vector<std::uint32_t> points;  // ascending within a cell

  std::uint32_t cell_of(double w) const {
    return std::min(side - 1, static_cast<std::uint32_t>(std::max(0.0, w) * side));
  }
};

// Counting sort, O(n + cells).
inline BucketGrid bucket_points(std::span<const double> x, std::span<const double> y, std::uint32_t side) {
  BucketGrid grid;
  grid.side = std::max(1u, side);
  grid.begin.assign(std::size_t{grid.side} * grid.side + 1, 0);
  const auto cell = [&](std::size_t i) {
    return grid.cell_of(x[i]) + std::size_t{grid.side} * grid.cell_of(y[i]);
  };
  for (std::size_t i = 0; i < x.size(); ++i) ++grid.begin[cell(i) + 1];
  for (std::size_t c = 1; c < grid.begin.size(); ++c) grid.begin[c] += grid.begin[c - 1];
  grid.points.resize(x.size());
  std::vector<std::uint32_t> next(grid.begin.begin(), grid.begin.end() - 1);
  for (std::size_t i = 0; i < x.size(); ++i) grid.points[next[cell(i)]++] = static_cast<std::uint32_t>(i);
  return grid;
}

}  // namespace meander
