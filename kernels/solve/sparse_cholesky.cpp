#include "kernels/solve/sparse_cholesky.h"

#include <Eigen/Core>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "kernels/solve/dense_fronts.h"

namespace meander {

// Finds the structure, and permutes the matrix to the order of elimination.
SparseCholesky::Permuted SparseCholesky::analyse(const UnknownGraph& graph, std::span<const double> values,
                                                 std::span<const double> diagonal,
                                                 std::span<const std::uint32_t> order) {
  const auto n = static_cast<std::uint32_t>(order.size());
  Elimination elimination = order_by_subtrees(graph, order);
  Permuted matrix;
  LowerTriangle& lower = matrix.lower;
  lower.begin.reserve(n + 1);
  lower.row.reserve(graph.neighbors.size() / 2);
  lower.value.reserve(graph.neighbors.size() / 2);
  matrix.diagonal.reserve(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t unknown = elimination.unknown[k];
    lower.begin.push_back(static_cast<std::uint32_t>(lower.row.size()));
    matrix.diagonal.push_back(diagonal[unknown]);
    for (std::uint32_t e = graph.begin[unknown]; e < graph.begin[unknown + 1]; ++e) {
      const std::uint32_t row = elimination.place[graph.neighbors[e]];
      if (row <= k) continue;
      lower.row.push_back(row);
      lower.value.push_back(values[e]);
    }
  }
  lower.begin.push_back(static_cast<std::uint32_t>(lower.row.size()));
  nodes_ = find_supernodes(lower, std::move(elimination));
  panel_begin_.assign(1, 0);
  for (std::size_t s = 0; s < nodes_.count(); ++s)
    panel_begin_.push_back(panel_begin_.back() + nodes_.row_count(s) * nodes_.columns(s));
  return matrix;
}

void SparseCholesky::factorize(const UnknownGraph& graph, std::span<const double> values,
                               std::span<const double> diagonal, std::span<const std::uint32_t> order,
                               const CancelToken& cancel) {
  factorize(analyse(graph, values, diagonal, order), cancel);
}

void SparseCholesky::factorize(GraphMatrix&& matrix, std::span<const std::uint32_t> order,
                               const CancelToken& cancel, WorkBudget* budget) {
  const Permuted permuted = analyse(matrix.graph, matrix.values, matrix.diagonal, order);
  matrix = {};
  succeeded_ = false;
  if (!spend(budget, nodes_.elimination_work() / 2)) return;
  factorize(permuted, cancel);
}

void SparseCholesky::factorize(const Permuted& matrix, const CancelToken& cancel) {
  succeeded_ = false;
  cancel.check();
  const LowerTriangle& lower = matrix.lower;
  // Only the lower triangle of an update matrix is kept.
  const auto update_entries = [&](std::size_t s) {
    return nodes_.rows_below(s) * (nodes_.rows_below(s) + 1) / 2;
  };
  panel_.resize(panel_begin_.back());
  WaitingUpdates updates(nodes_, update_entries);
  std::vector<double> front;
  for (std::uint32_t s = 0; s < nodes_.count(); ++s) {
    if (s % 4096 == 0) cancel.check();
    const std::size_t m = updates.begin_front(s).size(), w = nodes_.columns(s);
    front.assign(m * m, 0);
    for (std::uint32_t k = nodes_.first[s]; k < nodes_.first[s + 1]; ++k) {
      double* column = front.data() + (k - nodes_.first[s]) * m;
      column[k - nodes_.first[s]] = matrix.diagonal[k];
      for (std::uint32_t e = lower.begin[k]; e < lower.begin[k + 1]; ++e)
        column[updates.place(lower.row[e])] += lower.value[e];
    }
    updates.take(s, [values = front.data(), m](std::span<const std::uint32_t> places, const double* update) {
      const std::size_t count = places.size();
      for (std::size_t j = 0; j < count; ++j) {
        double* column = values + places[j] * m;
        for (std::size_t i = j; i < count; ++i) column[places[i]] += update[i - j];
        update += count - j;
      }
    });
    if (!factorize_front(front.data(), m, w)) return;
    std::copy(front.begin(), front.begin() + static_cast<std::ptrdiff_t>(m * w),
              panel_.begin() + static_cast<std::ptrdiff_t>(panel_begin_[s]));
    if (!updates.put(s)) continue;
    for (std::size_t j = w; j < m; ++j) {
      const double* column = front.data() + j * m;
      updates.append(column + j, column + m);
    }
  }
  succeeded_ = true;
}

template <int Count>
void SparseCholesky::solve_permuted(double* x) const {
  const std::size_t supernodes = nodes_.count();
  for (std::size_t s = 0; s < supernodes; ++s) {
    const std::span<const std::uint32_t> rows = nodes_.rows_of(s);
    const std::size_t m = rows.size(), w = nodes_.columns(s);
    for (std::size_t j = 0; j < w; ++j) {
      const double* column = panel_.data() + panel_begin_[s] + j * m;
      double* own = x + std::size_t{Count} * rows[j];
      double value[Count];
      for (int c = 0; c < Count; ++c) value[c] = own[c] = own[c] / column[j];
      for (std::size_t i = j + 1; i < m; ++i)
        for (int c = 0; c < Count; ++c) x[std::size_t{Count} * rows[i] + c] -= column[i] * value[c];
    }
  }
  for (std::size_t s = supernodes; s-- > 0;) {
    const std::span<const std::uint32_t> rows = nodes_.rows_of(s);
    const std::size_t m = rows.size(), w = nodes_.columns(s);
    for (std::size_t j = w; j-- > 0;) {
      const double* column = panel_.data() + panel_begin_[s] + j * m;
      double* own = x + std::size_t{Count} * rows[j];
      double sum[Count] = {};
      for (std::size_t i = j + 1; i < m; ++i)
        for (int c = 0; c < Count; ++c) sum[c] += column[i] * x[std::size_t{Count} * rows[i] + c];
      for (int c = 0; c < Count; ++c) own[c] = (own[c] - sum[c]) / column[j];
    }
  }
}

// Does the operations of solve_permuted for each right-hand side in their order, but by rows, so that the
// Count sums of a row stay in registers.
template <int Count>
void SparseCholesky::solve_rows(double* x) const {
  using Sums = Eigen::Array<double, Count, 1>;
  const auto row_of = [&](std::size_t row) { return Eigen::Map<Sums>(x + Count * row); };
  const std::size_t supernodes = nodes_.count();
  for (std::size_t s = 0; s < supernodes; ++s) {
    const std::span<const std::uint32_t> rows = nodes_.rows_of(s);
    const std::size_t m = rows.size(), w = nodes_.columns(s);
    const double* panel = panel_.data() + panel_begin_[s];
    const double* own = x + Count * std::size_t{nodes_.first[s]};
    for (std::size_t i = 0; i < m; ++i) {
      Sums sum = row_of(rows[i]);
      const std::size_t columns = std::min(i, w);
      for (std::size_t j = 0; j < columns; ++j)
        sum -= panel[j * m + i] * Eigen::Map<const Sums>(own + Count * j);
      if (i < w) sum /= panel[i * m + i];
      row_of(rows[i]) = sum;
    }
  }
  for (std::size_t s = supernodes; s-- > 0;) {
    const std::span<const std::uint32_t> rows = nodes_.rows_of(s);
    const std::size_t m = rows.size(), w = nodes_.columns(s);
    for (std::size_t j = w; j-- > 0;) {
      const double* column = panel_.data() + panel_begin_[s] + j * m;
      Sums sum = Sums::Zero();
      for (std::size_t i = j + 1; i < m; ++i) sum += column[i] * row_of(rows[i]);
      row_of(rows[j]) = (row_of(rows[j]) - sum) / column[j];
    }
  }
}

template <int Count>
void SparseCholesky::solve_interleaved(std::span<double> b) const {
  std::vector<double> x(b.size());
  for (std::size_t i = 0; i < nodes_.place.size(); ++i)
    std::copy_n(b.data() + Count * i, Count, x.data() + Count * std::size_t{nodes_.place[i]});
  if constexpr (Count < 4)
    solve_permuted<Count>(x.data());
  else
    solve_rows<Count>(x.data());
  for (std::size_t i = 0; i < nodes_.place.size(); ++i)
    std::copy_n(x.data() + Count * std::size_t{nodes_.place[i]}, Count, b.data() + Count * i);
}

void SparseCholesky::solve_many(std::span<double> b, std::size_t count) const {
  if (count == 0 || b.size() != count * nodes_.place.size())
    throw std::invalid_argument("solve_many: the array does not hold `count` right-hand sides");
  at_width(count, [&]<int Count>() { solve_interleaved<Count>(b); });
}

void SparseCholesky::solve(std::span<double> b) const { solve_interleaved<1>(b); }

void SparseCholesky::solve(std::span<double> b, std::span<double> c) const {
  std::vector<double> x(2 * nodes_.place.size());
  for (std::size_t i = 0; i < nodes_.place.size(); ++i) {
    x[2 * nodes_.place[i]] = b[i];
    x[2 * nodes_.place[i] + 1] = c[i];
  }
  solve_permuted<2>(x.data());
  for (std::size_t i = 0; i < nodes_.place.size(); ++i) {
    b[i] = x[2 * nodes_.place[i]];
    c[i] = x[2 * nodes_.place[i] + 1];
  }
}

}  // namespace meander
