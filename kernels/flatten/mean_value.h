// Mean-value coordinates (Floater 2003, "Mean value coordinates"): positive weights, so every free vertex
// lies inside the hull of its neighbors.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/work_budget.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

// w_ij = (tan(a / 2) + tan(b / 2)) / l_ij for the edge of half-edge h from its origin i, with a and b the
// angles beside it at i, clamped to 0.9 pi. Positive and finite for mollified lengths. O(1).
double mean_value_weight(const IntrinsicDisk& disk, std::uint32_t half_edge);

// The half-edge out of the same vertex that follows counter-clockwise; no_index past the boundary.
inline std::uint32_t next_outgoing(const IntrinsicDisk& disk, std::uint32_t half_edge) {
  return disk.opposite[previous_half_edge(half_edge)];
}

// Moves the listed vertices (interior, no repeats) to the solution of the mean-value equations with all other
// vertices fixed. `leaving` gives one half-edge out of each vertex. Returns false, with nothing moved, when
// the solver fails or `budget` does not suffice. Cost: dense elimination up to 48 vertices, sparse LU above.
bool solve_mean_value(const IntrinsicDisk& disk, std::span<const std::uint32_t> leaving,
                      std::span<const std::uint32_t> free_vertices, std::span<double> u, std::span<double> v,
                      const CancelToken& cancel = {}, WorkBudget* budget = nullptr);

// One half-edge out of each vertex. O(T).
std::vector<std::uint32_t> leaving_half_edges(const IntrinsicDisk& disk);

// Maps the whole disk into a circle of radius 1, with the boundary spread by its edge lengths. No flips in
// exact arithmetic (Tutte 1963, Floater 2003). Returns false when the solver fails or `budget` does not
// suffice.
bool flatten_to_circle(const IntrinsicDisk& disk, std::vector<double>& u, std::vector<double>& v,
                       const CancelToken& cancel = {}, WorkBudget* budget = nullptr);

}  // namespace meander
