#include "kernels/flatten/sparse_cholesky.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace meander {

namespace {

constexpr std::uint32_t none = 0xFFFFFFFFu;
constexpr std::size_t small_front = 24;  // columns below which plain loops beat blocked products

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;
using Panel = Eigen::Map<Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;

// Elimination tree of the matrix in the given order (Liu 1990): parent[k] > k, or none.
std::vector<std::uint32_t> elimination_tree(const UnknownGraph& graph, std::span<const std::uint32_t> order,
                                            std::span<const std::uint32_t> place) {
  std::vector<std::uint32_t> parent(order.size(), none), ancestor(order.size(), none);
  for (std::uint32_t k = 0; k < order.size(); ++k)
    for (std::uint32_t e = graph.begin[order[k]]; e < graph.begin[order[k] + 1]; ++e) {
      std::uint32_t j = place[graph.neighbours[e]];
      while (j < k) {
        const std::uint32_t next = ancestor[j];
        ancestor[j] = k;
        if (next == none) parent[j] = k;
        if (next == none || next == k) break;
        j = next;
      }
    }
  return parent;
}

// Children before parents, every subtree contiguous: result[new place] = old place.
std::vector<std::uint32_t> postorder(std::span<const std::uint32_t> parent) {
  const auto n = static_cast<std::uint32_t>(parent.size());
  std::vector<std::uint32_t> child(n, none), sibling(n, none), result, stack;
  result.reserve(n);
  std::vector<std::uint32_t> roots;
  for (std::uint32_t k = n; k-- > 0;) {
    if (parent[k] == none) {
      roots.push_back(k);
      continue;
    }
    sibling[k] = child[parent[k]];
    child[parent[k]] = k;
  }
  for (std::size_t r = roots.size(); r-- > 0;) {
    stack.push_back(roots[r]);
    while (!stack.empty()) {
      const std::uint32_t k = stack.back();
      if (child[k] != none) {
        stack.push_back(child[k]);
        child[k] = sibling[stack.back()];
      } else {
        result.push_back(k);
        stack.pop_back();
      }
    }
  }
  return result;
}

// Entries of each column of L including the diagonal, for a postordered tree (Gilbert, Ng and Peyton 1994).
std::vector<std::uint32_t> column_counts(std::span<const std::uint32_t> begin,
                                         std::span<const std::uint32_t> row,
                                         std::span<const std::uint32_t> parent) {
  const auto n = static_cast<std::uint32_t>(parent.size());
  // first: the first descendant; a column is a leaf of the subtree of row i when its first descendant comes
  // after all that row i has met so far.
  std::vector<std::uint32_t> first(n, none), met(n, 0), last_leaf(n, none), ancestor(n);
  std::vector<std::int32_t> count(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    count[k] = first[k] == none ? 1 : 0;
    for (std::uint32_t j = k; j != none && first[j] == none; j = parent[j]) first[j] = k;
    ancestor[k] = k;
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    if (parent[k] != none) --count[parent[k]];
    for (std::uint32_t e = begin[k]; e < begin[k + 1]; ++e) {
      const std::uint32_t i = row[e];
      if (first[k] + 1 <= met[i]) continue;
      met[i] = first[k] + 1;
      ++count[k];
      const std::uint32_t previous = last_leaf[i];
      last_leaf[i] = k;
      if (previous == none) continue;
      std::uint32_t q = previous;
      while (q != ancestor[q]) q = ancestor[q];
      for (std::uint32_t j = previous; j != q;) {
        const std::uint32_t next = ancestor[j];
        ancestor[j] = q;
        j = next;
      }
      --count[q];
    }
    if (parent[k] != none) ancestor[k] = parent[k];
  }
  std::vector<std::uint32_t> result(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    if (parent[k] != none) count[parent[k]] += count[k];
    result[k] = static_cast<std::uint32_t>(count[k]);
  }
  return result;
}

// Factorises the first `columns` columns of the lower triangle of a dense front and updates the rest.
bool factorise_front(double* front, std::size_t rows, std::size_t columns) {
  if (columns >= small_front) {
    const auto n = static_cast<Eigen::Index>(rows), w = static_cast<Eigen::Index>(columns);
    Panel all(front, n, n, Eigen::OuterStride<>(n));
    Eigen::Ref<Matrix, 0, Eigen::OuterStride<>> top(all.topLeftCorner(w, w));
    Eigen::LLT<Eigen::Ref<Matrix, 0, Eigen::OuterStride<>>, Eigen::Lower> cholesky(top);
    if (cholesky.info() != Eigen::Success) return false;
    if (n == w) return true;
    auto below = all.bottomLeftCorner(n - w, w);
    all.topLeftCorner(w, w).triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
    all.bottomRightCorner(n - w, n - w).selfadjointView<Eigen::Lower>().rankUpdate(below, -1.0);
    return true;
  }
  for (std::size_t j = 0; j < columns; ++j) {
    double* column = front + j * rows;
    if (!(column[j] > 0)) return false;
    const double pivot = std::sqrt(column[j]), inverse = 1 / pivot;
    column[j] = pivot;
    for (std::size_t i = j + 1; i < rows; ++i) column[i] *= inverse;
    for (std::size_t k = j + 1; k < columns; ++k) {
      const double factor = column[k];
      double* target = front + k * rows;
      for (std::size_t i = k; i < rows; ++i) target[i] -= factor * column[i];
    }
  }
  for (std::size_t k = columns; k < rows; ++k) {
    double* target = front + k * rows;
    std::size_t j = 0;
    for (; j + 3 < columns; j += 4) {
      const double *a = front + j * rows, *b = a + rows, *c = b + rows, *d = c + rows;
      const double fa = a[k], fb = b[k], fc = c[k], fd = d[k];
      for (std::size_t i = k; i < rows; ++i) target[i] -= (fa * a[i] + fb * b[i]) + (fc * c[i] + fd * d[i]);
    }
    for (; j < columns; ++j) {
      const double* a = front + j * rows;
      const double fa = a[k];
      for (std::size_t i = k; i < rows; ++i) target[i] -= fa * a[i];
    }
  }
  return true;
}

}  // namespace

SparseCholesky::Lower SparseCholesky::permute(const UnknownGraph& graph, std::span<const double> values,
                                              std::span<const double> diagonal,
                                              std::span<const std::uint32_t> order) {
  const auto n = static_cast<std::uint32_t>(order.size());
  place_.resize(n);
  for (std::uint32_t k = 0; k < n; ++k) place_[order[k]] = k;
  const std::vector<std::uint32_t> parent = elimination_tree(graph, order, place_);
  const std::vector<std::uint32_t> post = postorder(parent);
  std::vector<std::uint32_t> renamed(n);
  for (std::uint32_t k = 0; k < n; ++k) renamed[post[k]] = k;
  tree_.resize(n);
  for (std::uint32_t k = 0; k < n; ++k) tree_[renamed[k]] = parent[k] == none ? none : renamed[parent[k]];
  for (std::uint32_t k = 0; k < n; ++k) place_[order[post[k]]] = k;
  Lower lower;
  lower.begin.reserve(n + 1);
  lower.row.reserve(graph.neighbours.size() / 2);
  lower.value.reserve(graph.neighbours.size() / 2);
  lower.diagonal.reserve(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t unknown = order[post[k]];
    lower.begin.push_back(static_cast<std::uint32_t>(lower.row.size()));
    lower.diagonal.push_back(diagonal[unknown]);
    for (std::uint32_t e = graph.begin[unknown]; e < graph.begin[unknown + 1]; ++e) {
      const std::uint32_t row = place_[graph.neighbours[e]];
      if (row <= k) continue;
      lower.row.push_back(row);
      lower.value.push_back(values[e]);
    }
  }
  lower.begin.push_back(static_cast<std::uint32_t>(lower.row.size()));
  return lower;
}

void SparseCholesky::find_supernodes(const Lower& lower, std::span<const std::uint32_t> parent) {
  const std::vector<std::uint32_t> column_count = column_counts(lower.begin, lower.row, parent);
  const auto n = static_cast<std::uint32_t>(parent.size());
  // A column joins the supernode before it when it is the parent of its last column and few zeros come in.
  first_.clear();
  std::size_t entries = 0;  // of the true factor in the supernode so far
  for (std::uint32_t k = 0; k < n; ++k) {
    bool joined = false;
    if (k > 0 && parent[k - 1] == k) {
      const std::uint32_t begin = first_.back(), width = k + 1 - begin;
      // All columns of the joined supernode get the rows of the last one.
      const std::size_t below = column_count[k] - 1;
      const std::size_t dense = std::size_t{width} * (width + 1) / 2 + std::size_t{width} * below;
      const std::size_t wanted = entries + column_count[k];
      const std::size_t zeros = dense > wanted ? dense - wanted : 0;
      joined = zeros == 0 || (width <= 8 && zeros <= dense / 3) || (width <= 32 && zeros <= dense / 10) ||
               zeros <= dense / 32;
      if (joined) entries = wanted;
    }
    if (joined) continue;
    first_.push_back(k);
    entries = column_count[k];
  }
  const std::size_t supernodes = first_.size();
  first_.push_back(n);
  std::vector<std::uint32_t> owner(n);
  for (std::uint32_t s = 0; s < supernodes; ++s)
    for (std::uint32_t k = first_[s]; k < first_[s + 1]; ++k) owner[k] = s;
  parent_.assign(supernodes, none);
  for (std::uint32_t s = 0; s < supernodes; ++s) {
    const std::uint32_t above = parent[first_[s + 1] - 1];
    if (above != none) parent_[s] = owner[above];
  }
}

void SparseCholesky::find_rows(const Lower& lower) {
  const auto supernodes = static_cast<std::uint32_t>(parent_.size());
  std::vector<std::uint32_t> child(supernodes, none), sibling(supernodes, none), mark(place_.size(), none);
  row_begin_.assign(1, 0);
  panel_begin_.assign(1, 0);
  rows_.clear();
  for (std::uint32_t s = 0; s < supernodes; ++s) {
    const std::size_t begin = rows_.size();
    const std::uint32_t last = first_[s + 1];
    for (std::uint32_t k = first_[s]; k < last; ++k) {
      rows_.push_back(k);
      mark[k] = s;
    }
    const std::size_t own = rows_.size();
    for (std::uint32_t k = first_[s]; k < last; ++k)
      for (std::uint32_t e = lower.begin[k]; e < lower.begin[k + 1]; ++e) {
        const std::uint32_t row = lower.row[e];
        if (row < last || mark[row] == s) continue;
        mark[row] = s;
        rows_.push_back(row);
      }
    for (std::uint32_t c = child[s]; c != none; c = sibling[c])
      for (std::size_t i = row_begin_[c] + (first_[c + 1] - first_[c]); i < row_begin_[c + 1]; ++i) {
        const std::uint32_t row = rows_[i];
        if (row < last || mark[row] == s) continue;
        mark[row] = s;
        rows_.push_back(row);
      }
    std::sort(rows_.begin() + static_cast<std::ptrdiff_t>(own), rows_.end());
    row_begin_.push_back(rows_.size());
    panel_begin_.push_back(panel_begin_.back() + (rows_.size() - begin) * (last - first_[s]));
    if (parent_[s] != none) {
      sibling[s] = child[parent_[s]];
      child[parent_[s]] = s;
    }
  }
}

void SparseCholesky::factorise(const UnknownGraph& graph, std::span<const double> values,
                               std::span<const double> diagonal, std::span<const std::uint32_t> order,
                               const CancelToken& cancel) {
  succeeded_ = false;
  const Lower lower = permute(graph, values, diagonal, order);
  find_supernodes(lower, tree_);
  find_rows(lower);
  cancel.check();
  panel_.resize(panel_begin_.back());
  std::vector<double> front, stack;  // update matrices of finished subtrees, last one on top
  std::vector<std::uint32_t> local(place_.size(), 0);  // row -> row of the front
  std::vector<std::uint32_t> waiting;                  // supernodes whose updates are on the stack
  std::vector<std::uint32_t> mapped;
  for (std::uint32_t s = 0; s + 1 < first_.size(); ++s) {
    if (s % 4096 == 0) cancel.check();
    const std::uint32_t* rows = rows_.data() + row_begin_[s];
    const std::size_t m = row_begin_[s + 1] - row_begin_[s], w = first_[s + 1] - first_[s];
    for (std::size_t i = 0; i < m; ++i) local[rows[i]] = static_cast<std::uint32_t>(i);
    front.assign(m * m, 0);
    for (std::uint32_t k = first_[s]; k < first_[s + 1]; ++k) {
      double* column = front.data() + (k - first_[s]) * m;
      column[k - first_[s]] = lower.diagonal[k];
      for (std::uint32_t e = lower.begin[k]; e < lower.begin[k + 1]; ++e)
        column[local[lower.row[e]]] += lower.value[e];
    }
    while (!waiting.empty() && parent_[waiting.back()] == s) {
      const std::uint32_t c = waiting.back();
      waiting.pop_back();
      const std::size_t child_width = first_[c + 1] - first_[c];
      const std::size_t count = row_begin_[c + 1] - row_begin_[c] - child_width;
      const std::uint32_t* child_rows = rows_.data() + row_begin_[c] + child_width;
      mapped.resize(count);
      for (std::size_t i = 0; i < count; ++i) mapped[i] = local[child_rows[i]];
      const double* update = stack.data() + (stack.size() - count * count);
      for (std::size_t j = 0; j < count; ++j) {
        double* column = front.data() + mapped[j] * m;
        for (std::size_t i = j; i < count; ++i) column[mapped[i]] += update[j * count + i];
      }
      stack.resize(stack.size() - count * count);
    }
    if (!factorise_front(front.data(), m, w)) return;
    std::copy(front.begin(), front.begin() + static_cast<std::ptrdiff_t>(m * w),
              panel_.begin() + static_cast<std::ptrdiff_t>(panel_begin_[s]));
    if (parent_[s] == none) continue;
    waiting.push_back(s);
    const std::size_t count = m - w, top = stack.size();
    stack.resize(top + count * count);
    for (std::size_t j = 0; j < count; ++j)
      std::copy_n(front.data() + (w + j) * m + w + j, count - j, stack.data() + top + j * count + j);
  }
  succeeded_ = true;
}

template <int Count>
void SparseCholesky::solve_permuted(double* x) const {
  const std::size_t supernodes = parent_.size();
  for (std::size_t s = 0; s < supernodes; ++s) {
    const std::uint32_t* rows = rows_.data() + row_begin_[s];
    const std::size_t m = row_begin_[s + 1] - row_begin_[s], w = first_[s + 1] - first_[s];
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
    const std::uint32_t* rows = rows_.data() + row_begin_[s];
    const std::size_t m = row_begin_[s + 1] - row_begin_[s], w = first_[s + 1] - first_[s];
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

// As solve_permuted, operation by operation for each right-hand side, but by rows: the Count sums of a row
// stay in registers.
template <int Count>
void SparseCholesky::solve_rows(double* x) const {
  using Sums = Eigen::Array<double, Count, 1>;
  const auto row_of = [&](std::size_t row) { return Eigen::Map<Sums>(x + Count * row); };
  const std::size_t supernodes = parent_.size();
  for (std::size_t s = 0; s < supernodes; ++s) {
    const std::uint32_t* rows = rows_.data() + row_begin_[s];
    const std::size_t m = row_begin_[s + 1] - row_begin_[s], w = first_[s + 1] - first_[s];
    const double* panel = panel_.data() + panel_begin_[s];
    const double* own = x + Count * std::size_t{first_[s]};
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
    const std::uint32_t* rows = rows_.data() + row_begin_[s];
    const std::size_t m = row_begin_[s + 1] - row_begin_[s], w = first_[s + 1] - first_[s];
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
  for (std::size_t i = 0; i < place_.size(); ++i)
    std::copy_n(b.data() + Count * i, Count, x.data() + Count * std::size_t{place_[i]});
  if constexpr (Count < 4)
    solve_permuted<Count>(x.data());
  else
    solve_rows<Count>(x.data());
  for (std::size_t i = 0; i < place_.size(); ++i)
    std::copy_n(x.data() + Count * std::size_t{place_[i]}, Count, b.data() + Count * i);
}

void SparseCholesky::solve_many(std::span<double> b, std::size_t count) const {
  if (count == 0 || b.size() != count * place_.size())
    throw std::invalid_argument("solve_many: the array does not hold `count` right-hand sides");
  switch (count) {
    case 1:
      return solve_interleaved<1>(b);
    case 2:
      return solve_interleaved<2>(b);
    case 4:
      return solve_interleaved<4>(b);
    case 8:
      return solve_interleaved<8>(b);
    case 16:
      return solve_interleaved<16>(b);
    default:
      throw std::invalid_argument("solve_many: count must be 1, 2, 4, 8 or 16");
  }
}

void SparseCholesky::solve(std::span<double> b) const {
  std::vector<double> x(place_.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[place_[i]] = b[i];
  solve_permuted<1>(x.data());
  for (std::size_t i = 0; i < x.size(); ++i) b[i] = x[place_[i]];
}

void SparseCholesky::solve(std::span<double> b, std::span<double> c) const {
  std::vector<double> x(2 * place_.size());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    x[2 * place_[i]] = b[i];
    x[2 * place_[i] + 1] = c[i];
  }
  solve_permuted<2>(x.data());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    b[i] = x[2 * place_[i]];
    c[i] = x[2 * place_[i] + 1];
  }
}

}  // namespace meander
