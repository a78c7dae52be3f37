#include "kernels/solve/sparse_lu.h"

#include <Eigen/Dense>
#include <cmath>
#include <numeric>

#include "kernels/core/random.h"
#include "kernels/natural_order.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

double random_value(std::uint32_t seed, std::uint64_t index) {
  return random_pair({{13, seed}}, Stream::sequence, index).first;
}

// Rows of positive weights that sum up to less than the diagonal; the pattern is symmetric, the values not.
GraphMatrix weights_on(std::size_t count, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges,
                       std::uint32_t seed) {
  GraphMatrix matrix;
  matrix.diagonal.assign(count, 1);
  matrix.graph.begin.assign(count + 1, 0);
  for (const auto& [a, b] : edges) {
    ++matrix.graph.begin[a + 1];
    ++matrix.graph.begin[b + 1];
  }
  std::partial_sum(matrix.graph.begin.begin(), matrix.graph.begin.end(), matrix.graph.begin.begin());
  matrix.graph.neighbors.resize(matrix.graph.begin.back());
  matrix.values.resize(matrix.graph.begin.back());
  std::vector<std::uint32_t> cursor(matrix.graph.begin.begin(), matrix.graph.begin.end() - 1);
  std::uint64_t drawn = 0;
  for (const auto& [a, b] : edges)
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
      matrix.graph.neighbors[cursor[from]] = to;
      matrix.values[cursor[from]++] = -std::pow(1e-6, random_value(seed, drawn++));
    }
  for (std::size_t i = 0; i < count; ++i) {
    double total = 1e-3;
    for (std::uint32_t e = matrix.graph.begin[i]; e < matrix.graph.begin[i + 1]; ++e)
      total -= matrix.values[e];
    for (std::uint32_t e = matrix.graph.begin[i]; e < matrix.graph.begin[i + 1]; ++e)
      matrix.values[e] /= total;
  }
  return matrix;
}

Eigen::MatrixXd dense(const GraphMatrix& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.diagonal.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
  for (std::uint32_t i = 0; i < n; ++i) {
    result(i, i) = matrix.diagonal[i];
    for (std::uint32_t e = matrix.graph.begin[i]; e < matrix.graph.begin[i + 1]; ++e)
      result(i, matrix.graph.neighbors[e]) += matrix.values[e];
  }
  return result;
}

// Against dense elimination with complete pivoting.
void check_solution(GraphMatrix matrix, std::span<const std::uint32_t> order) {
  const Eigen::MatrixXd full = dense(matrix);
  const Eigen::Index n = full.rows();
  Eigen::MatrixX2d right(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    right(i, 0) = random_value(1, static_cast<std::uint64_t>(i));
    right(i, 1) = random_value(2, static_cast<std::uint64_t>(i));
  }
  std::vector<double> b(right.col(0).begin(), right.col(0).end()),
      c(right.col(1).begin(), right.col(1).end());
  SparseLu lu;
  REQUIRE(lu.factorize(std::move(matrix), order));
  lu.solve(b, c);
  const Eigen::MatrixX2d expected = full.fullPivLu().solve(right);
  const double scale = expected.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < n; ++i) {
    REQUIRE(std::abs(b[static_cast<std::size_t>(i)] - expected(i, 0)) <= 1e-11 * scale);
    REQUIRE(std::abs(c[static_cast<std::size_t>(i)] - expected(i, 1)) <= 1e-11 * scale);
  }
}

}  // namespace

TEST_CASE("sparse LU: solves weights on a mesh, in minimum-degree and in natural order, repeated edges") {
  const PolygonMesh mesh =
      icosphere(sanitized ? 2 : 3);  // dense elimination is slow in tests with sanitizers
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t c = 0; c < mesh.corners.size(); c += 3)
    for (std::size_t k = 0; k < 3; ++k)
      edges.emplace_back(mesh.corners[c + k], mesh.corners[c + (k + 1) % 3]);
  const GraphMatrix matrix = weights_on(mesh.vertex_count(), edges, 3);
  check_solution(matrix, elimination_order(matrix.graph));
  check_solution(matrix, natural_order(mesh.vertex_count()));
}

TEST_CASE("sparse LU: solves random graphs of every density, isolated unknowns included") {
  for (std::uint32_t round = 0; round < 40; ++round) {
    const std::uint32_t count = 1 + round * 2, edge_count = count * (round % 4) * (round % 4);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::uint32_t i = 0; i < edge_count; ++i) {
      const PhiloxBlock w = random_words({{17, round}}, Stream::sequence, i);
      if (w[0] % count != w[1] % count) edges.emplace_back(w[0] % count, w[1] % count);
    }
    CAPTURE(count, edges.size());
    const GraphMatrix matrix = weights_on(count, edges, round);
    check_solution(matrix, elimination_order(matrix.graph));
  }
}

TEST_CASE("sparse LU: a zero pivot and a non-finite value are reported") {
  for (const double pivot : {0.0, std::nan(""), HUGE_VAL}) {
    GraphMatrix matrix = weights_on(3, {{0, 1}, {1, 2}}, 5);
    matrix.diagonal[0] = pivot;
    SparseLu lu;
    CHECK_FALSE(lu.factorize(std::move(matrix), natural_order(3)));
  }
}
