#include "kernels/flatten/cotan_laplacian.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

namespace meander {

namespace {

using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

// Lower triangle of A_II in compressed columns, rows ascending, parallel edges summed.
Matrix assemble(const IntrinsicDisk& disk, std::span<const double> weight,
                std::span<const std::uint32_t> interior, std::size_t count) {
  const auto n = static_cast<Eigen::Index>(count);
  std::vector<double> diagonal(count, 0);
  std::vector<int> begin(count + 1, 0);
  const auto for_each_edge = [&](auto&& body) {
    for (std::uint32_t h = 0; h < disk.opposite.size(); ++h) {
      if (disk.opposite[h] != no_index && disk.opposite[h] < h) continue;
      const std::uint32_t a = disk.triangles[h], b = disk.triangles[next_half_edge(h)];
      if (a != b) body(interior[a], interior[b], weight[h]);
    }
  };
  for (std::size_t c = 0; c < count; ++c) begin[c + 1] = 1;  // the diagonal
  for_each_edge([&](std::uint32_t a, std::uint32_t b, double w) {
    if (a != no_index) diagonal[a] += w;
    if (b != no_index) diagonal[b] += w;
    if (a != no_index && b != no_index) ++begin[std::min(a, b) + 1];
  });
  for (std::size_t c = 0; c < count; ++c) begin[c + 1] += begin[c];
  struct Entry {
    int row;
    double value;
  };
  std::vector<Entry> entries(static_cast<std::size_t>(begin[count]));
  std::vector<int> cursor(begin.begin(), begin.end() - 1);
  for (std::size_t c = 0; c < count; ++c) entries[cursor[c]++] = {static_cast<int>(c), diagonal[c]};
  for_each_edge([&](std::uint32_t a, std::uint32_t b, double w) {
    if (a == no_index || b == no_index) return;
    entries[cursor[std::min(a, b)]++] = {static_cast<int>(std::max(a, b)), -w};
  });
  Matrix matrix(n, n);
  matrix.resizeNonZeros(begin[count]);
  int filled = 0;
  for (std::size_t c = 0; c < count; ++c) {
    matrix.outerIndexPtr()[c] = filled;
    std::sort(entries.begin() + begin[c], entries.begin() + begin[c + 1],
              [](const Entry& x, const Entry& y) { return x.row < y.row; });
    for (int e = begin[c]; e < begin[c + 1]; ++e) {
      if (e > begin[c] && entries[e].row == entries[e - 1].row) {
        matrix.valuePtr()[filled - 1] += entries[e].value;
        continue;
      }
      matrix.innerIndexPtr()[filled] = entries[e].row;
      matrix.valuePtr()[filled++] = entries[e].value;
    }
  }
  matrix.outerIndexPtr()[count] = filled;
  matrix.resizeNonZeros(filled);
  return matrix;
}

}  // namespace

struct DirichletLaplacian::Factor {
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<int>> cholesky;
};

DirichletLaplacian::DirichletLaplacian(const IntrinsicDisk& disk, std::span<const double> half_cotangent,
                                       std::span<const std::uint8_t> on_boundary, const CancelToken& cancel)
    : disk_(disk), weight_(disk.opposite.size(), 0), interior_(disk.vertex_count, no_index) {
  for (std::uint32_t v = 0; v < disk.vertex_count; ++v)
    if (!on_boundary[v]) interior_[v] = static_cast<std::uint32_t>(interior_count_++);
  for (std::uint32_t h = 0; h < weight_.size(); ++h) {
    const std::uint32_t other = disk.opposite[h];
    weight_[other == no_index ? h : std::min(h, other)] += half_cotangent[h];
  }
  if (interior_count_ == 0) {
    factorised_ = true;
    return;
  }
  const Matrix matrix = assemble(disk, weight_, interior_, interior_count_);
  cancel.check();
  factor_ = std::make_unique<Factor>();
  factor_->cholesky.analyzePattern(matrix);
  cancel.check();
  factor_->cholesky.factorize(matrix);
  factorised_ = factor_->cholesky.info() == Eigen::Success;
  cancel.check();
}

DirichletLaplacian::~DirichletLaplacian() = default;

void DirichletLaplacian::solve(std::span<const double> b, std::span<double> x) const {
  if (interior_count_ == 0) return;
  Eigen::VectorXd right(static_cast<Eigen::Index>(interior_count_));
  for (std::uint32_t v = 0; v < interior_.size(); ++v)
    if (interior_[v] != no_index) right[interior_[v]] = b[v];
  for (std::uint32_t h = 0; h < disk_.opposite.size(); ++h) {
    if (disk_.opposite[h] != no_index && disk_.opposite[h] < h) continue;
    const std::uint32_t p = disk_.triangles[h], q = disk_.triangles[next_half_edge(h)];
    const std::uint32_t i = interior_[p], j = interior_[q];
    if (i != no_index && j == no_index) right[i] += weight_[h] * x[q];
    if (j != no_index && i == no_index) right[j] += weight_[h] * x[p];
  }
  const Eigen::VectorXd solution = factor_->cholesky.solve(right);
  for (std::uint32_t v = 0; v < interior_.size(); ++v)
    if (interior_[v] != no_index) x[v] = solution[interior_[v]];
}

std::vector<double> DirichletLaplacian::apply_at_boundary(std::span<const double> x) const {
  std::vector<double> result(interior_.size(), 0);
  for (std::uint32_t h = 0; h < disk_.opposite.size(); ++h) {
    if (disk_.opposite[h] != no_index && disk_.opposite[h] < h) continue;
    const std::uint32_t p = disk_.triangles[h], q = disk_.triangles[next_half_edge(h)];
    const double flow = weight_[h] * (x[p] - x[q]);
    if (interior_[p] == no_index) result[p] += flow;
    if (interior_[q] == no_index) result[q] -= flow;
  }
  return result;
}

}  // namespace meander
