#include "kernels/solve/cotan_laplacian.h"

#include <utility>

namespace meander {

void DirichletLaplacian::number_unknowns(std::span<const std::uint8_t> on_boundary) {
  unknown_.assign(disk_.vertex_count, no_index);
  for (std::uint32_t v = 0; v < disk_.vertex_count; ++v) {
    if (on_boundary[v]) continue;
    unknown_[v] = static_cast<std::uint32_t>(vertex_.size());
    vertex_.push_back(v);
  }
}

void DirichletLaplacian::find_order(const UnknownGraph& graph) {
  order_.reserve(vertex_.size());
  if (!disk_.elimination.empty()) {
    for (const std::uint32_t v : disk_.elimination)
      if (unknown_[v] != no_index) order_.push_back(unknown_[v]);
    if (order_.size() == vertex_.size()) return;
    order_.clear();  // that of another disk
  }
  order_ = elimination_order(graph);
}

// Assembles A_II; edges at the boundary go to rim_.
GraphMatrix DirichletLaplacian::interior_matrix(std::span<const double> half_cotangent) {
  GraphMatrix matrix;
  std::vector<std::uint32_t>&begin = matrix.graph.begin, &neighbors = matrix.graph.neighbors;
  begin.assign(vertex_.size() + 1, 0);
  matrix.diagonal.assign(vertex_.size(), 0);
  for_each_edge(disk_, half_cotangent, [&](std::uint32_t a, std::uint32_t b, double weight) {
    const std::uint32_t i = unknown_[a], j = unknown_[b];
    if (i != no_index) matrix.diagonal[i] += weight;
    if (j != no_index) matrix.diagonal[j] += weight;
    if (i != no_index && j != no_index) {
      ++begin[i + 1];
      ++begin[j + 1];
    } else {
      rim_.push_back(j == no_index ? RimEdge{a, b, weight} : RimEdge{b, a, weight});
    }
  });
  for (std::size_t i = 0; i < vertex_.size(); ++i) begin[i + 1] += begin[i];
  neighbors.resize(begin.back());
  matrix.values.resize(begin.back());
  std::vector<std::uint32_t> cursor(begin.begin(), begin.end() - 1);
  for_each_edge(disk_, half_cotangent, [&](std::uint32_t a, std::uint32_t b, double weight) {
    const std::uint32_t i = unknown_[a], j = unknown_[b];
    if (i == no_index || j == no_index) return;
    neighbors[cursor[i]] = j;
    matrix.values[cursor[i]++] = -weight;
    neighbors[cursor[j]] = i;
    matrix.values[cursor[j]++] = -weight;
  });
  return matrix;
}

DirichletLaplacian::DirichletLaplacian(const IntrinsicDisk& disk, std::vector<double> half_cotangent,
                                       std::span<const std::uint8_t> on_boundary, const CancelToken& cancel,
                                       WorkBudget* budget)
    : disk_(disk) {
  number_unknowns(on_boundary);
  GraphMatrix matrix = interior_matrix(half_cotangent);
  half_cotangent = std::vector<double>();
  cancel.check();
  if (vertex_.empty()) {
    factorized_ = true;
    return;
  }
  if (!spend(budget, work_per_unknown * vertex_.size())) return;
  find_order(matrix.graph);
  cancel.check();
  cholesky_.factorize(std::move(matrix), order_, cancel, budget);
  factorized_ = cholesky_.succeeded();
}

std::vector<std::uint32_t> DirichletLaplacian::elimination() const {
  std::vector<std::uint32_t> vertices;
  vertices.reserve(order_.size());
  for (const std::uint32_t i : order_) vertices.push_back(vertex_[i]);
  return vertices;
}

void DirichletLaplacian::add_rim(std::span<const double> x, std::span<double> right) const {
  for (const RimEdge& edge : rim_)
    if (unknown_[edge.from] != no_index) right[unknown_[edge.from]] += edge.weight * x[edge.to];
}

void DirichletLaplacian::solve(std::span<const double> b, std::span<double> x) const {
  if (vertex_.empty()) return;
  std::vector<double> right(vertex_.size());
  for (std::size_t i = 0; i < vertex_.size(); ++i) right[i] = b[vertex_[i]];
  add_rim(x, right);
  cholesky_.solve(right);
  for (std::size_t i = 0; i < vertex_.size(); ++i) x[vertex_[i]] = right[i];
}

void DirichletLaplacian::extend_harmonically(std::span<double> x, std::span<double> y) const {
  if (vertex_.empty()) return;
  std::vector<double> right_x(vertex_.size(), 0), right_y(vertex_.size(), 0);
  add_rim(x, right_x);
  add_rim(y, right_y);
  cholesky_.solve(right_x, right_y);
  for (std::size_t i = 0; i < vertex_.size(); ++i) {
    x[vertex_[i]] = right_x[i];
    y[vertex_[i]] = right_y[i];
  }
}

std::vector<double> DirichletLaplacian::apply_at_boundary(std::span<const double> x) const {
  std::vector<double> result(disk_.vertex_count, 0);
  for (const RimEdge& edge : rim_) {
    const double flow = edge.weight * (x[edge.to] - x[edge.from]);
    result[edge.to] += flow;
    if (unknown_[edge.from] == no_index) result[edge.from] -= flow;
  }
  return result;
}

}  // namespace meander
