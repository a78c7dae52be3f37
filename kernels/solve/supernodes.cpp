#include "kernels/solve/supernodes.h"

#include <algorithm>
#include <utility>

namespace meander {

namespace {

constexpr std::uint32_t none = Supernodes::none;

// Elimination tree of the matrix in the given order (Liu 1990): parent[k] > k, or none.
std::vector<std::uint32_t> elimination_tree(const UnknownGraph& graph, std::span<const std::uint32_t> order,
                                            std::span<const std::uint32_t> place) {
  std::vector<std::uint32_t> parent(order.size(), none), ancestor(order.size(), none);
  for (std::uint32_t k = 0; k < order.size(); ++k)
    for (std::uint32_t e = graph.begin[order[k]]; e < graph.begin[order[k] + 1]; ++e) {
      std::uint32_t j = place[graph.neighbors[e]];
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
  // first: the first descendant. A column is a leaf of the subtree of row i when its first descendant comes
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

// First columns of the supernodes, and the end.
std::vector<std::uint32_t> first_columns(const LowerTriangle& lower, std::span<const std::uint32_t> parent) {
  const std::vector<std::uint32_t> column_count = column_counts(lower.begin, lower.row, parent);
  const auto n = static_cast<std::uint32_t>(parent.size());
  // A column joins the supernode before it when it is the parent of its last column and few zeros come in.
  std::vector<std::uint32_t> first;
  std::size_t entries = 0;  // of the true factor, in the current supernode
  for (std::uint32_t k = 0; k < n; ++k) {
    bool joined = false;
    if (k > 0 && parent[k - 1] == k) {
      const std::uint32_t begin = first.back(), width = k + 1 - begin;
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
    first.push_back(k);
    entries = column_count[k];
  }
  first.push_back(n);
  return first;
}

std::vector<std::uint32_t> parents_of(std::span<const std::uint32_t> first,
                                      std::span<const std::uint32_t> tree) {
  const std::size_t supernodes = first.size() - 1;
  std::vector<std::uint32_t> owner(tree.size()), parent(supernodes, none);
  for (std::uint32_t s = 0; s < supernodes; ++s)
    for (std::uint32_t k = first[s]; k < first[s + 1]; ++k) owner[k] = s;
  for (std::uint32_t s = 0; s < supernodes; ++s) {
    const std::uint32_t above = tree[first[s + 1] - 1];
    if (above != none) parent[s] = owner[above];
  }
  return parent;
}

void find_rows(const LowerTriangle& lower, Supernodes& nodes) {
  const auto supernodes = static_cast<std::uint32_t>(nodes.count());
  std::vector<std::uint32_t> child(supernodes, none), sibling(supernodes, none),
      mark(nodes.place.size(), none);
  nodes.row_begin.assign(1, 0);
  for (std::uint32_t s = 0; s < supernodes; ++s) {
    const std::uint32_t last = nodes.first[s + 1];
    const auto add = [&](std::uint32_t row) {
      if (row < last || mark[row] == s) return;
      mark[row] = s;
      nodes.rows.push_back(row);
    };
    for (std::uint32_t k = nodes.first[s]; k < last; ++k) nodes.rows.push_back(k);
    const std::size_t own = nodes.rows.size();
    for (std::uint32_t e = lower.begin[nodes.first[s]]; e < lower.begin[last]; ++e) add(lower.row[e]);
    for (std::uint32_t c = child[s]; c != none; c = sibling[c])
      for (std::size_t i = nodes.row_begin[c] + nodes.columns(c); i < nodes.row_begin[c + 1]; ++i)
        add(nodes.rows[i]);
    std::sort(nodes.rows.begin() + static_cast<std::ptrdiff_t>(own), nodes.rows.end());
    nodes.row_begin.push_back(nodes.rows.size());
    if (nodes.parent[s] == none) continue;
    sibling[s] = child[nodes.parent[s]];
    child[nodes.parent[s]] = s;
  }
}

}  // namespace

std::uint64_t Supernodes::elimination_work() const {
  std::uint64_t work = 0;
  for (std::size_t s = 0; s < count(); ++s)
    for (std::uint64_t j = 0, m = row_count(s); j < columns(s); ++j) work += (m - j) * (m - j);
  return work;
}

Elimination order_by_subtrees(const UnknownGraph& graph, std::span<const std::uint32_t> order) {
  const auto n = static_cast<std::uint32_t>(order.size());
  Elimination result;
  result.place.resize(n);
  for (std::uint32_t k = 0; k < n; ++k) result.place[order[k]] = k;
  const std::vector<std::uint32_t> parent = elimination_tree(graph, order, result.place);
  const std::vector<std::uint32_t> post = postorder(parent);
  std::vector<std::uint32_t> renamed(n);
  for (std::uint32_t k = 0; k < n; ++k) renamed[post[k]] = k;
  result.tree.resize(n);
  result.unknown.resize(n);
  for (std::uint32_t k = 0; k < n; ++k) {
    result.tree[renamed[k]] = parent[k] == none ? none : renamed[parent[k]];
    result.unknown[k] = order[post[k]];
  }
  for (std::uint32_t k = 0; k < n; ++k) result.place[result.unknown[k]] = k;
  return result;
}

Supernodes find_supernodes(const LowerTriangle& lower, Elimination elimination) {
  Supernodes nodes;
  nodes.first = first_columns(lower, elimination.tree);
  nodes.parent = parents_of(nodes.first, elimination.tree);
  nodes.place = std::move(elimination.place);
  find_rows(lower, nodes);
  return nodes;
}

}  // namespace meander
