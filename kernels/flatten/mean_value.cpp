#include "kernels/flatten/mean_value.h"

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/flatten/portable_angles.h"

namespace meander {

namespace {

constexpr std::size_t dense_limit = 48;

// tan(a / 2) of the angle a at the origin of half-edge h: 4 A / ((b + c)^2 - d^2), d the opposite edge.
double half_angle_tangent(const IntrinsicDisk& disk, std::uint32_t h) {
  const double b = disk.length[h], c = disk.length[previous_half_edge(h)], d = disk.length[next_half_edge(h)];
  // An angle near pi would tie the vertex to the line between two neighbours and collapse adjacent triangles.
  constexpr double widest = 6.3137515146750430;  // tan(0.45 pi)
  const double area4 = 4 * area_from_lengths(b, c, d), rest = ((b + c) - d) * ((b + c) + d);
  return area4 < widest * rest ? area4 / rest : widest;
}

// Right-hand sides and coefficients of the equations of the free vertices, rows scaled to a unit diagonal.
struct System {
  std::vector<Eigen::Triplet<double, int>> coefficients;
  Eigen::MatrixX2d right;
};

// `number` maps vertices to rows, no_index for fixed ones.
template <class Number>
System assemble(const IntrinsicDisk& disk, std::span<const std::uint32_t> leaving,
                std::span<const std::uint32_t> free_vertices, const Number& number, std::span<const double> u,
                std::span<const double> v) {
  System system;
  system.right.setZero(static_cast<Eigen::Index>(free_vertices.size()), 2);
  system.coefficients.reserve(7 * free_vertices.size());
  std::vector<double> weights;
  for (std::size_t i = 0; i < free_vertices.size(); ++i) {
    const std::uint32_t first = leaving[free_vertices[i]];
    weights.clear();
    double total = 0;
    std::uint32_t h = first;
    do {
      weights.push_back(mean_value_weight(disk, h));
      total += weights.back();
      h = next_outgoing(disk, h);
    } while (h != first && h != no_index);
    const auto row = static_cast<int>(i);
    system.coefficients.emplace_back(row, row, 1.0);
    h = first;
    for (const double weight : weights) {
      const std::uint32_t other = disk.triangles[next_half_edge(h)];
      const std::uint32_t column = number(other);
      const double share = weight / total;
      if (column == no_index) {
        system.right(row, 0) += share * u[other];
        system.right(row, 1) += share * v[other];
      } else {
        system.coefficients.emplace_back(row, static_cast<int>(column), -share);
      }
      h = next_outgoing(disk, h);
    }
  }
  return system;
}

bool solve(const System& system, Eigen::MatrixX2d& solution) {
  const Eigen::Index n = system.right.rows();
  if (static_cast<std::size_t>(n) <= dense_limit) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    for (const auto& c : system.coefficients) matrix(c.row(), c.col()) += c.value();
    solution = matrix.partialPivLu().solve(system.right);
  } else {
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(system.coefficients.begin(), system.coefficients.end());
    Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> lu(matrix);
    if (lu.info() != Eigen::Success) return false;
    solution = lu.solve(system.right);
  }
  return solution.allFinite();
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
                      std::span<const std::uint32_t> free_vertices, std::span<double> u,
                      std::span<double> v) {
  if (free_vertices.empty()) return true;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rows;  // (vertex, row), sorted by vertex
  rows.reserve(free_vertices.size());
  for (std::uint32_t i = 0; i < free_vertices.size(); ++i) rows.emplace_back(free_vertices[i], i);
  std::sort(rows.begin(), rows.end());
  const auto number = [&](std::uint32_t vertex) {
    const auto at = std::lower_bound(rows.begin(), rows.end(), std::pair(vertex, 0u));
    return at != rows.end() && at->first == vertex ? at->second : no_index;
  };
  Eigen::MatrixX2d solution;
  if (!solve(assemble(disk, leaving, free_vertices, number, u, v), solution)) return false;
  for (std::size_t i = 0; i < free_vertices.size(); ++i) {
    u[free_vertices[i]] = solution(static_cast<Eigen::Index>(i), 0);
    v[free_vertices[i]] = solution(static_cast<Eigen::Index>(i), 1);
  }
  return true;
}

bool flatten_to_circle(const IntrinsicDisk& disk, std::vector<double>& u, std::vector<double>& v) {
  u.assign(disk.vertex_count, 0);
  v.assign(disk.vertex_count, 0);
  const std::vector<std::uint32_t> loop =
      boundary_half_edges(disk.triangles, disk.opposite, disk.vertex_count);
  double total = 0;
  for (const std::uint32_t h : loop) total += disk.length[h];
  // No edge gets less than a tenth of the mean: corners of the polygon stay apart in double.
  const double least = 0.1 * total / static_cast<double>(loop.size());
  double spread = 0, along = 0;
  for (const std::uint32_t h : loop) spread += std::max(least, disk.length[h]);
  std::vector<std::uint32_t> number(disk.vertex_count, 0), free_vertices;
  for (const std::uint32_t h : loop) {
    const std::uint32_t vertex = disk.triangles[h];
    const Direction at = direction_of(2 * std::numbers::pi * along / spread);
    u[vertex] = at.cosine;
    v[vertex] = at.sine;
    along += std::max(least, disk.length[h]);
    number[vertex] = no_index;
  }
  for (std::uint32_t w = 0; w < disk.vertex_count; ++w) {
    if (number[w] == no_index) continue;
    number[w] = static_cast<std::uint32_t>(free_vertices.size());
    free_vertices.push_back(w);
  }
  if (free_vertices.empty()) return true;
  const std::vector<std::uint32_t> leaving = leaving_half_edges(disk);
  Eigen::MatrixX2d solution;
  const auto number_of = [&](std::uint32_t vertex) { return number[vertex]; };
  if (!solve(assemble(disk, leaving, free_vertices, number_of, u, v), solution)) return false;
  for (std::size_t i = 0; i < free_vertices.size(); ++i) {
    u[free_vertices[i]] = solution(static_cast<Eigen::Index>(i), 0);
    v[free_vertices[i]] = solution(static_cast<Eigen::Index>(i), 1);
  }
  return true;
}

}  // namespace meander
