#include "kernels/flatten/mean_value.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "kernels/core/portable_angles.h"
#include "kernels/solve/dense_fronts.h"
#include "kernels/solve/sparse_lu.h"

namespace meander {

namespace {

constexpr std::size_t dense_limit = 48;

// tan(a / 2) of the angle a at the origin of half-edge h: 4 A / ((b + c)^2 - d^2), d the opposite edge.
double half_angle_tangent(const IntrinsicDisk& disk, std::uint32_t h) {
  const double b = disk.length[h], c = disk.length[previous_half_edge(h)], d = disk.length[next_half_edge(h)];
  // An angle near pi would tie the vertex to the line between two neighbors and collapse adjacent triangles.
  constexpr double widest = 6.3137515146750430;  // tan(0.45 pi)
  const double area4 = 4 * area_from_lengths(b, c, d), rest = ((b + c) - d) * ((b + c) + d);
  return area4 < widest * rest ? area4 / rest : widest;
}

// The equations of the free vertices, with rows scaled to a unit diagonal, and their right-hand sides.
struct System {
  GraphMatrix matrix;
  std::vector<double> right_u, right_v;
};

// `number` maps vertices to rows, fixed ones to no_index. The vertices are interior, so each is a neighbor of
// its neighbors: the pattern is symmetric.
template <class Number>
System assemble(const IntrinsicDisk& disk, std::span<const std::uint32_t> leaving,
                std::span<const std::uint32_t> free_vertices, const Number& number, std::span<const double> u,
                std::span<const double> v) {
  System system;
  const std::size_t count = free_vertices.size();
  system.right_u.assign(count, 0);
  system.right_v.assign(count, 0);
  system.matrix.diagonal.assign(count, 1);
  system.matrix.graph.begin.assign(1, 0);
  std::vector<std::uint32_t>& neighbors = system.matrix.graph.neighbors;
  neighbors.reserve(6 * count);
  system.matrix.values.reserve(6 * count);
  std::vector<double> weights;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t first = leaving[free_vertices[i]];
    weights.clear();
    double total = 0;
    std::uint32_t h = first;
    do {
      weights.push_back(mean_value_weight(disk, h));
      total += weights.back();
      h = next_outgoing(disk, h);
    } while (h != first && h != no_index);
    h = first;
    for (const double weight : weights) {
      const std::uint32_t other = disk.triangles[next_half_edge(h)];
      const std::uint32_t column = number(other);
      const double share = weight / total;
      if (column == no_index) {
        system.right_u[i] += share * u[other];
        system.right_v[i] += share * v[other];
      } else {
        neighbors.push_back(column);
        system.matrix.values.push_back(-share);
      }
      h = next_outgoing(disk, h);
    }
    system.matrix.graph.begin.push_back(static_cast<std::uint32_t>(neighbors.size()));
  }
  return system;
}

// Replaces the right-hand sides by the solution. A small system is solved densely, which is faster: both
// right-hand sides stand behind the matrix as unknowns of their own, with rows that are not read.
bool solve_dense(System& system) {
  const std::size_t n = system.right_u.size(), rows = n + 2;
  std::vector<double> front(rows * rows);
  const UnknownGraph& graph = system.matrix.graph;
  for (std::size_t i = 0; i < n; ++i) {
    front[i * rows + i] = system.matrix.diagonal[i];
    for (std::uint32_t e = graph.begin[i]; e < graph.begin[i + 1]; ++e)
      front[graph.neighbors[e] * rows + i] += system.matrix.values[e];
  }
  std::ranges::copy(system.right_u, front.data() + n * rows);
  std::ranges::copy(system.right_v, front.data() + (n + 1) * rows);
  if (!eliminate_front(front.data(), rows, n)) return false;
  for (const auto& [right, column] : {std::pair{&system.right_u, n}, std::pair{&system.right_v, n + 1}}) {
    double* x = front.data() + column * rows;
    for (std::size_t j = n; j-- > 0;) {
      const double* upper = front.data() + j * rows;
      x[j] /= upper[j];
      for (std::size_t i = 0; i < j; ++i) x[i] -= upper[i] * x[j];
    }
    std::copy_n(x, n, right->begin());
  }
  return true;
}

bool solve_sparse(System& system, const CancelToken& cancel, WorkBudget* budget) {
  const std::vector<std::uint32_t> order = elimination_order(system.matrix.graph);
  SparseLu lu;
  if (!lu.factorize(std::move(system.matrix), order, cancel, budget)) return false;
  lu.solve(system.right_u, system.right_v);
  return true;
}

// The work of all steps but the sparse factorization.
std::uint64_t work_of(std::uint64_t unknowns) {
  return work_per_unknown * unknowns + (unknowns <= dense_limit ? unknowns * unknowns * unknowns / 3 : 0);
}

// Moves the free vertices to the solution; returns false, with nothing moved, when there is none.
bool solve(System system, std::span<const std::uint32_t> free_vertices, std::span<double> u,
           std::span<double> v, const CancelToken& cancel, WorkBudget* budget) {
  const bool small = free_vertices.size() <= dense_limit;
  if (!(small ? solve_dense(system) : solve_sparse(system, cancel, budget))) return false;
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(system.right_u.begin(), system.right_u.end(), finite) ||
      !std::all_of(system.right_v.begin(), system.right_v.end(), finite))
    return false;
  for (std::size_t i = 0; i < free_vertices.size(); ++i) {
    u[free_vertices[i]] = system.right_u[i];
    v[free_vertices[i]] = system.right_v[i];
  }
  return true;
}

}  // namespace

double mean_value_weight(const IntrinsicDisk& disk, std::uint32_t half_edge) {
  double tangents = half_angle_tangent(disk, half_edge);
  const std::uint32_t other = disk.opposite[half_edge];
  if (other != no_index) tangents += half_angle_tangent(disk, next_half_edge(other));
  return tangents / disk.length[half_edge];
}

std::vector<std::uint32_t> leaving_half_edges(const IntrinsicDisk& disk) {
  std::vector<std::uint32_t> leaving(disk.vertex_count, no_index);
  for (std::uint32_t h = 0; h < disk.triangles.size(); ++h) {
    std::uint32_t& first = leaving[disk.triangles[h]];
    // A boundary fan starts at its boundary half-edge.
    if (first == no_index || disk.opposite[h] == no_index) first = h;
  }
  return leaving;
}

bool solve_mean_value(const IntrinsicDisk& disk, std::span<const std::uint32_t> leaving,
                      std::span<const std::uint32_t> free_vertices, std::span<double> u, std::span<double> v,
                      const CancelToken& cancel, WorkBudget* budget) {
  if (free_vertices.empty()) return true;
  if (!spend(budget, work_of(free_vertices.size()))) return false;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rows;  // (vertex, row), sorted by vertex
  rows.reserve(free_vertices.size());
  for (std::uint32_t i = 0; i < free_vertices.size(); ++i) rows.emplace_back(free_vertices[i], i);
  std::sort(rows.begin(), rows.end());
  const auto number = [&](std::uint32_t vertex) {
    const auto at = std::lower_bound(rows.begin(), rows.end(), std::pair(vertex, 0u));
    return at != rows.end() && at->first == vertex ? at->second : no_index;
  };
  return solve(assemble(disk, leaving, free_vertices, number, u, v), free_vertices, u, v, cancel, budget);
}

bool flatten_to_circle(const IntrinsicDisk& disk, std::vector<double>& u, std::vector<double>& v,
                       const CancelToken& cancel, WorkBudget* budget) {
  u.assign(disk.vertex_count, 0);
  v.assign(disk.vertex_count, 0);
  const std::vector<std::uint32_t> loop =
      boundary_half_edges(disk.triangles, disk.opposite, disk.vertex_count);
  double total = 0;
  for (const std::uint32_t h : loop) total += disk.length[h];
  // No edge gets less than a tenth of the mean: corners of the polygon stay apart in double.
  const double min_length = 0.1 * total / static_cast<double>(loop.size());
  double spread = 0, along = 0;
  for (const std::uint32_t h : loop) spread += std::max(min_length, disk.length[h]);
  std::vector<std::uint32_t> number(disk.vertex_count, 0), free_vertices;
  for (const std::uint32_t h : loop) {
    const std::uint32_t vertex = disk.triangles[h];
    const Direction at = direction_of(2 * std::numbers::pi * along / spread);
    u[vertex] = at.cosine;
    v[vertex] = at.sine;
    along += std::max(min_length, disk.length[h]);
    number[vertex] = no_index;
  }
  for (std::uint32_t w = 0; w < disk.vertex_count; ++w) {
    if (number[w] == no_index) continue;
    number[w] = static_cast<std::uint32_t>(free_vertices.size());
    free_vertices.push_back(w);
  }
  if (free_vertices.empty()) return true;
  if (!spend(budget, work_of(free_vertices.size()))) return false;
  const std::vector<std::uint32_t> leaving = leaving_half_edges(disk);
  const auto number_of = [&](std::uint32_t vertex) { return number[vertex]; };
  return solve(assemble(disk, leaving, free_vertices, number_of, u, v), free_vertices, u, v, cancel, budget);
}

}  // namespace meander
