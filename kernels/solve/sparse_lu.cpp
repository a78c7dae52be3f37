#include "kernels/solve/sparse_lu.h"

#include <algorithm>
#include <utility>

#include "kernels/solve/dense_fronts.h"

namespace meander {

namespace {

// Sorts entries (column, row, value) into columns.
LowerTriangle by_columns(std::size_t count, std::span<const std::uint32_t> column,
                         std::span<const std::uint32_t> row, std::span<const double> value) {
  LowerTriangle triangle;
  triangle.begin.assign(count + 1, 0);
  for (const std::uint32_t k : column) ++triangle.begin[k + 1];
  for (std::size_t k = 0; k < count; ++k) triangle.begin[k + 1] += triangle.begin[k];
  triangle.row.resize(row.size());
  triangle.value.resize(row.size());
  std::vector<std::uint32_t> cursor(triangle.begin.begin(), triangle.begin.end() - 1);
  for (std::size_t e = 0; e < row.size(); ++e) {
    const std::uint32_t at = cursor[column[e]]++;
    triangle.row[at] = row[e];
    triangle.value[at] = value[e];
  }
  return triangle;
}

}  // namespace

SparseLu::Triangles SparseLu::analyse(const GraphMatrix& matrix, std::span<const std::uint32_t> order) {
  Elimination elimination = order_by_subtrees(matrix.graph, order);
  const std::size_t n = order.size();
  Triangles triangles;
  triangles.diagonal.reserve(n);
  std::vector<std::uint32_t> row, column;
  std::vector<double> value;
  const auto collect = [&](bool upper) {
    row.clear();
    column.clear();
    value.clear();
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t unknown = elimination.unknown[k];
      for (std::uint32_t e = matrix.graph.begin[unknown]; e < matrix.graph.begin[unknown + 1]; ++e) {
        const std::uint32_t other = elimination.place[matrix.graph.neighbors[e]];
        if ((other > k) != upper) continue;
        column.push_back(upper ? k : other);
        row.push_back(upper ? other : k);
        value.push_back(matrix.values[e]);
      }
    }
    return by_columns(n, column, row, value);
  };
  triangles.lower = collect(false);
  triangles.upper = collect(true);
  for (const std::uint32_t unknown : elimination.unknown)
    triangles.diagonal.push_back(matrix.diagonal[unknown]);
  nodes_ = find_supernodes(triangles.lower, std::move(elimination));
  left_begin_.assign(1, 0);
  right_begin_.assign(1, 0);
  for (std::size_t s = 0; s < nodes_.count(); ++s) {
    left_begin_.push_back(left_begin_.back() + nodes_.row_count(s) * nodes_.columns(s));
    right_begin_.push_back(right_begin_.back() + nodes_.rows_below(s) * nodes_.columns(s));
  }
  return triangles;
}

bool SparseLu::factorize(GraphMatrix&& matrix, std::span<const std::uint32_t> order,
                         const CancelToken& cancel, WorkBudget* budget) {
  const Triangles triangles = analyse(matrix, order);
  matrix = {};
  if (!spend(budget, nodes_.elimination_work())) return false;
  cancel.check();
  left_.resize(left_begin_.back());
  right_.resize(right_begin_.back());
  const auto update_entries = [&](std::size_t s) { return nodes_.rows_below(s) * nodes_.rows_below(s); };
  WaitingUpdates updates(nodes_, update_entries);
  std::vector<double> front;
  for (std::uint32_t s = 0; s < nodes_.count(); ++s) {
    if (s % 1024 == 0) cancel.check();
    const std::size_t m = updates.begin_front(s).size(), w = nodes_.columns(s);
    front.assign(m * m, 0);
    for (std::uint32_t k = nodes_.first[s]; k < nodes_.first[s + 1]; ++k) {
      const std::size_t j = k - nodes_.first[s];
      front[j * m + j] = triangles.diagonal[k];
      for (std::uint32_t e = triangles.lower.begin[k]; e < triangles.lower.begin[k + 1]; ++e)
        front[j * m + updates.place(triangles.lower.row[e])] += triangles.lower.value[e];
      for (std::uint32_t e = triangles.upper.begin[k]; e < triangles.upper.begin[k + 1]; ++e)
        front[updates.place(triangles.upper.row[e]) * m + j] += triangles.upper.value[e];
    }
    updates.take(s, [values = front.data(), m](std::span<const std::uint32_t> places, const double* update) {
      const std::size_t count = places.size();
      for (std::size_t j = 0; j < count; ++j) {
        double* column = values + places[j] * m;
        for (std::size_t i = 0; i < count; ++i) column[places[i]] += update[j * count + i];
      }
    });
    if (!eliminate_front(front.data(), m, w)) return false;
    std::copy_n(front.data(), m * w, left_.data() + left_begin_[s]);
    double* right = right_.data() + right_begin_[s];
    for (std::size_t j = 0; j < w; ++j)
      for (std::size_t i = w; i < m; ++i) *right++ = front[i * m + j];
    if (!updates.put(s)) continue;
    for (std::size_t j = w; j < m; ++j) {
      const double* column = front.data() + j * m;
      updates.append(column + w, column + m);
    }
  }
  return true;
}

void SparseLu::solve(std::span<double> b, std::span<double> c) const {
  const std::size_t n = nodes_.place.size();
  std::vector<double> x(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    x[2 * nodes_.place[i]] = b[i];
    x[2 * nodes_.place[i] + 1] = c[i];
  }
  for (std::size_t s = 0; s < nodes_.count(); ++s) {
    const std::span<const std::uint32_t> rows = nodes_.rows_of(s);
    for (std::size_t j = 0; j < nodes_.columns(s); ++j) {
      const double* column = left_.data() + left_begin_[s] + j * rows.size();
      const double *own = x.data() + 2 * std::size_t{rows[j]}, first = own[0], second = own[1];
      for (std::size_t i = j + 1; i < rows.size(); ++i) {
        x[2 * std::size_t{rows[i]}] -= column[i] * first;
        x[2 * std::size_t{rows[i]} + 1] -= column[i] * second;
      }
    }
  }
  for (std::size_t s = nodes_.count(); s-- > 0;) {
    const std::span<const std::uint32_t> rows = nodes_.rows_of(s);
    const std::size_t m = rows.size(), w = nodes_.columns(s);
    const double* left = left_.data() + left_begin_[s];
    for (std::size_t j = w; j-- > 0;) {
      const double* right = right_.data() + right_begin_[s] + j * (m - w);
      double sums[2] = {x[2 * std::size_t{rows[j]}], x[2 * std::size_t{rows[j]} + 1]};
      for (std::size_t i = j + 1; i < m; ++i) {
        const double value = i < w ? left[i * m + j] : right[i - w];
        sums[0] -= value * x[2 * std::size_t{rows[i]}];
        sums[1] -= value * x[2 * std::size_t{rows[i]} + 1];
      }
      x[2 * std::size_t{rows[j]}] = sums[0] / left[j * m + j];
      x[2 * std::size_t{rows[j]} + 1] = sums[1] / left[j * m + j];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    b[i] = x[2 * nodes_.place[i]];
    c[i] = x[2 * nodes_.place[i] + 1];
  }
}

}  // namespace meander
