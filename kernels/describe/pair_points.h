// The walk over all pairs of points in tiles, for histograms of pairs. Internal to kernels/describe.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/instruction_set.h"
#include "kernels/core/parallel.h"
#include "kernels/describe/pair_tiles.h"

namespace meander {

inline constexpr std::size_t tile_rows = 64;
inline constexpr std::size_t task_pairs = std::size_t{1} << 19;  // of a task at least
inline constexpr std::size_t max_tasks = 1024;

template <class Number>
void check_finite(std::span<const Number> values, const char* what) {
  for (const Number value : values)
    if (!std::isfinite(value)) throw std::invalid_argument(std::string(what) + " that is not finite");
}

// The loops of an instruction set, or of the best one for automatic.
template <class Loops>
const Loops& loops_of(InstructionSet set, const Loops& scalar, const Loops& avx2, const Loops& avx512) {
  switch (set == InstructionSet::automatic ? best_instruction_set() : set) {
    case InstructionSet::avx512:
      return avx512;
    case InstructionSet::avx2:
      return avx2;
    default:
      return scalar;
  }
}

inline void require_available(InstructionSet set) {
  if (!is_available(set)) throw std::invalid_argument("this processor has no " + std::string(name_of(set)));
}

// The points twice, coordinates apart, times a power of two that brings the box's longest side into [1/2, 1).
// This is exact (except for numbers 2^-126 of the box), and no square overflows or vanishes.
struct PairPoints {
  std::vector<float> x, y, z;
  std::size_t count = 0;
  double unit = 1;  // units of the points per working unit

  PairPoints() = default;
  explicit PairPoints(std::span<const float> points) {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      float low = points[k], high = points[k];
      for (std::size_t i = k; i < points.size(); i += 3) {
        low = std::min(low, points[i]);
        high = std::max(high, points[i]);
      }
      longest = std::max(longest, static_cast<double>(high) - static_cast<double>(low));
    }
    int exponent = 0;
    if (longest > 0) std::frexp(longest, &exponent);
    unit = std::ldexp(1.0, exponent);
    const double factor = std::ldexp(1.0, -exponent);
    for (std::size_t i = 0; i < points.size(); i += 3) {
      x.push_back(static_cast<float>(points[i] * factor));
      y.push_back(static_cast<float>(points[i + 1] * factor));
      z.push_back(static_cast<float>(points[i + 2] * factor));
    }
    repeat();
  }

  // Call once, when all points are in.
  void repeat() {
    count = x.size();
    for (auto* coordinates : {&x, &y, &z}) {
      coordinates->resize(2 * count + pair_lanes);
      std::copy_n(coordinates->begin(), count, coordinates->begin() + static_cast<std::ptrdiff_t>(count));
    }
  }

  PairTile tile(std::size_t row_begin, std::size_t row_end, std::size_t offset_begin,
                std::size_t offset_end) const {
    return {x.data(), y.data(), z.data(), row_begin, row_end, offset_begin, offset_end};
  }
};

// Rows per task: enough pairs to be worth a task, not so many tasks that their results need much memory, and
// fewer than 2^31 pairs, which a counter holds. Depends on n only.
inline std::size_t rows_per_task(std::size_t n) {
  const std::size_t offsets = std::max<std::size_t>(1, n / 2);
  const std::size_t rows = std::max(task_pairs / offsets, n / max_tasks);
  return std::max<std::size_t>(1, std::min(rows, (std::size_t{1} << 31) / offsets));
}

// Calls body(loops, tile) for tiles that hold every pair of rows [begin, end) once, for single pairs with the
// scalar loops. Throws timeout / RunCanceled from `cancel`, checked before every 64 rows.
template <class Loops, class Body>
void for_each_tile(const PairPoints& points, const Loops& loops, const Loops& scalar, std::size_t begin,
                   std::size_t end, const CancelToken& cancel, const Body& body) {
  const std::size_t n = points.count, offsets = (n - 1) / 2 + 1;
  for (std::size_t row = begin; row < end; row += tile_rows) {
    cancel.check();
    const std::size_t row_end = std::min(end, row + tile_rows);
    for (std::size_t s = 1; s < offsets; s += pair_offsets)
      body(loops, points.tile(row, row_end, s, std::min(offsets, s + pair_offsets)));
    if (n % 2 == 0 && row < n / 2) body(scalar, points.tile(row, std::min(row_end, n / 2), n / 2, n / 2 + 1));
  }
}

// result[task] = task_result(first row, last row + 1) for all tasks, in parallel.
template <class Result, class TaskResult>
std::vector<Result> results_of_tasks(std::size_t n, const TaskResult& task_result) {
  const std::size_t rows = rows_per_task(n);
  std::vector<Result> results((n + rows - 1) / rows);
  parallel_tasks(results.size(), [&](std::size_t task) {
    results[task] = task_result(task * rows, std::min(n, (task + 1) * rows));
  });
  return results;
}

// The mean distance in working units; a sum of integers, the same for every order and number of threads.
double mean_distance(const PairPoints& points, InstructionSet instructions, const CancelToken& cancel);

}  // namespace meander
