#include "kernels/solve/sparse_cholesky.h"

#include <Eigen/Dense>
#include <numeric>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/natural_order.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// A symmetric matrix by entries: in the form that SparseCholesky takes, and dense.
struct System {
  UnknownGraph graph;
  std::vector<double> values, diagonal;
  Eigen::MatrixXd dense;
};

struct Entry {
  std::uint32_t row, column;
  double value;
};

System system_of(std::size_t count, const std::vector<Entry>& entries, double shift) {
  System system;
  const auto size = static_cast<Eigen::Index>(count);
  system.dense = Eigen::MatrixXd::Zero(size, size);
  system.diagonal.assign(count, shift);
  system.graph.begin.assign(count + 1, 0);
  for (const Entry& e : entries) {
    ++system.graph.begin[e.row + 1];
    ++system.graph.begin[e.column + 1];
    system.diagonal[e.row] += std::abs(e.value);
    system.diagonal[e.column] += std::abs(e.value);
    system.dense(e.row, e.column) += e.value;
    system.dense(e.column, e.row) += e.value;
  }
  system.dense.diagonal() = Eigen::Map<const Eigen::VectorXd>(system.diagonal.data(), size);
  std::partial_sum(system.graph.begin.begin(), system.graph.begin.end(), system.graph.begin.begin());
  system.graph.neighbors.resize(system.graph.begin.back());
  system.values.resize(system.graph.begin.back());
  std::vector<std::uint32_t> cursor(system.graph.begin.begin(), system.graph.begin.end() - 1);
  for (const Entry& e : entries) {
    system.graph.neighbors[cursor[e.row]] = e.column;
    system.values[cursor[e.row]++] = e.value;
    system.graph.neighbors[cursor[e.column]] = e.row;
    system.values[cursor[e.column]++] = e.value;
  }
  return system;
}

std::vector<double> random_vector(std::size_t count, std::uint32_t seed) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i)
    values[i] = random_pair({{7, seed}}, Stream::sequence, i).first * 2 - 1;
  return values;
}

// Both right-hand sides at once, each alone, and the dense solution.
void check_solutions(const System& system, std::span<const std::uint32_t> order) {
  SparseCholesky cholesky;
  cholesky.factorize(system.graph, system.values, system.diagonal, order);
  REQUIRE(cholesky.succeeded());
  const std::size_t count = system.diagonal.size();
  const std::vector<double> b = random_vector(count, 1), c = random_vector(count, 2);
  std::vector<double> x = b, y = c, alone = b;
  cholesky.solve(x, y);
  cholesky.solve(alone);
  const Eigen::VectorXd expected_x =
      system.dense.ldlt().solve(Eigen::Map<const Eigen::VectorXd>(b.data(), system.dense.rows()));
  const Eigen::VectorXd expected_y =
      system.dense.ldlt().solve(Eigen::Map<const Eigen::VectorXd>(c.data(), system.dense.rows()));
  const double scale = std::max(expected_x.cwiseAbs().maxCoeff(), expected_y.cwiseAbs().maxCoeff());
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    REQUIRE(std::abs(x[i] - expected_x[row]) <= 1e-11 * scale);
    REQUIRE(std::abs(y[i] - expected_y[row]) <= 1e-11 * scale);
    REQUIRE(std::abs(alone[i] - expected_x[row]) <= 1e-11 * scale);
  }
  for (const std::size_t together : {std::size_t{1}, std::size_t{2}, std::size_t{4}, std::size_t{8},
                                     std::size_t{16}}) {  // bit for bit as alone
    std::vector<double> many(together * count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < together; ++k) many[i * together + k] = static_cast<double>(k + 1) * b[i];
    cholesky.solve_many(many, together);
    for (std::size_t k = 0; k < together; ++k) {
      std::vector<double> one(count);
      for (std::size_t i = 0; i < count; ++i) one[i] = static_cast<double>(k + 1) * b[i];
      cholesky.solve(one);
      bool equal = true;
      for (std::size_t i = 0; i < count; ++i) equal = equal && many[i * together + k] == one[i];
      REQUIRE(equal);
    }
  }
  CHECK_THROWS_AS(cholesky.solve_many(x, 3), std::invalid_argument);
}

}  // namespace

TEST_CASE("sparse Cholesky: solves the Laplacian of a mesh, in minimum-degree and in natural order") {
  const PolygonMesh mesh = test::icosphere(3);
  std::vector<Entry> edges;
  for (std::size_t c = 0; c < mesh.corners.size(); c += 3)
    for (std::size_t k = 0; k < 3; ++k)  // every edge twice: repeats are added up
      edges.push_back({mesh.corners[c + k], mesh.corners[c + (k + 1) % 3], -0.5});
  const System system = system_of(mesh.vertex_count(), edges, 0.01);
  check_solutions(system, elimination_order(system.graph));
  check_solutions(system, natural_order(mesh.vertex_count()));
}

TEST_CASE("sparse Cholesky: solves random graphs of every density, isolated unknowns included") {
  for (std::uint32_t round = 0; round < 40; ++round) {
    const std::uint32_t count = 1 + round * 2;
    const std::uint32_t entry_count = count * (round % 4) * (round % 4);
    std::vector<Entry> entries;
    for (std::uint32_t i = 0; i < entry_count; ++i) {
      const PhiloxBlock w = random_words({{11, round}}, Stream::sequence, i);
      const Entry e{w[0] % count, w[1] % count, static_cast<double>(w[2]) * 0x1p-31 - 1};
      if (e.row != e.column) entries.push_back(e);
    }
    CAPTURE(count, entries.size());
    const System system = system_of(count, entries, 0.5);
    check_solutions(system, elimination_order(system.graph));
  }
}

TEST_CASE("sparse Cholesky: a matrix that is not positive definite is reported") {
  System system = system_of(3, {{0, 1, 1.0}, {1, 2, 1.0}}, 1.0);
  system.diagonal[1] = 0.25;
  SparseCholesky cholesky;
  cholesky.factorize(system.graph, system.values, system.diagonal, natural_order(3));
  CHECK_FALSE(cholesky.succeeded());
}

TEST_CASE("sparse Cholesky: the elimination order is a permutation with less fill than the natural order") {
  const PolygonMesh mesh = test::icosphere(4);  // numbered by subdivision: neighbors lie far apart
  std::vector<Entry> edges;
  for (std::size_t c = 0; c < mesh.corners.size(); c += 3)
    for (std::size_t k = 0; k < 3; ++k)
      edges.push_back({mesh.corners[c + k], mesh.corners[c + (k + 1) % 3], -0.5});
  const System system = system_of(mesh.vertex_count(), edges, 0.01);
  std::vector<std::uint32_t> order = elimination_order(system.graph);
  SparseCholesky natural, reduced;
  natural.factorize(system.graph, system.values, system.diagonal, natural_order(mesh.vertex_count()));
  reduced.factorize(system.graph, system.values, system.diagonal, order);
  CHECK(2 * reduced.factor_entries() < natural.factor_entries());
  std::sort(order.begin(), order.end());
  CHECK(order == natural_order(mesh.vertex_count()));
}
