// Trees grow level by level on the frame tables: every step is a loop over the nodes of one level, in fixed
// blocks.
#include "kernels/curve/curve_tree.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/core/status.h"
#include "kernels/curve/curve_frames.h"

namespace meander {

namespace {

constexpr std::size_t node_block = 4096;

// Table of a curve with the number of finest cells in a cell of each depth. Depth 0 is left out: 4^32 does
// not fit into 64 bits, and no child has that depth.
struct Rules {
  const FrameTable& table;
  std::size_t children;
  int levels;
  std::array<std::uint64_t, 33> finest_cells{};

  explicit Rules(CurveKind kind)
      : table(frame_table(kind)),
        children(static_cast<std::size_t>(table.branching) * static_cast<std::size_t>(table.branching)),
        levels(curve_key_levels(kind)) {
    std::uint64_t cells = 1;
    for (int depth = levels; depth > 0; --depth, cells *= children)
      finest_cells[static_cast<std::size_t>(depth)] = cells;
  }
};

void resize(CurveTree& tree, std::size_t count) {
  tree.u.resize(count);
  tree.v.resize(count);
  tree.side.resize(count);
  tree.key.resize(count);
  tree.depth.resize(count);
  tree.frame.resize(count);
}

void copy_node(const CurveTree& from, std::size_t i, CurveTree& to, std::size_t at) {
  to.u[at] = from.u[i];
  to.v[at] = from.v[i];
  to.side[at] = from.side[i];
  to.key[at] = from.key[i];
  to.depth[at] = from.depth[i];
  to.frame[at] = from.frame[i];
}

// Writes the children of node i in curve order from `at` on.
void write_children(const Rules& rules, const CurveTree& from, std::size_t i, CurveTree& to, std::size_t at) {
  const auto branching = static_cast<std::uint8_t>(rules.table.branching);
  const std::size_t frame = from.frame[i];
  const double side = from.side[i] / branching;
  const auto depth = static_cast<std::uint8_t>(from.depth[i] + 1);
  const std::uint64_t step = rules.finest_cells[depth];
  for (std::size_t digit = 0; digit < rules.children; ++digit, ++at) {
    const std::uint8_t cell = rules.table.cell_of_digit[frame][digit];
    to.u[at] = from.u[i] + cell % branching * side;
    to.v[at] = from.v[i] + cell / branching * side;
    to.side[at] = side;
    to.key[at] = from.key[i] + digit * step;
    to.depth[at] = depth;
    to.frame[at] = rules.table.child_frame[frame][digit];
  }
}

// before[b] = sum of value(i) over the blocks before block b; the last entry is the total.
template <class Value>
std::vector<std::size_t> block_offsets(std::size_t count, const Value& value) {
  std::vector<std::size_t> before((count + node_block - 1) / node_block + 1, 0);
  parallel_blocks(count, node_block, [&](std::size_t begin, std::size_t end) {
    std::size_t sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += value(i);
    before[begin / node_block + 1] = sum;
  });
  for (std::size_t b = 1; b < before.size(); ++b) before[b] += before[b - 1];
  return before;
}

void check_flags(const CurveTree& tree, std::span<const std::uint8_t> split) {
  if (split.size() != tree.leaf_count())
    throw ItemError(Status::internal, "a curve tree of " + std::to_string(tree.leaf_count()) +
                                          " leaves was given " + std::to_string(split.size()) +
                                          " split flags");
}

}  // namespace

CurveTree curve_root(CurveKind kind) {
  CurveTree tree;
  tree.kind = kind;
  resize(tree, 1);
  tree.side[0] = 1;
  return tree;
}

int curve_depth(CurveKind kind, int hilbert_levels) {
  const int depth = kind == CurveKind::hilbert ? hilbert_levels : hilbert_levels * 2 / 3;
  return std::clamp(depth, 0, curve_key_levels(kind));
}

CurveTree refine(const CurveTree& tree, std::span<const std::uint8_t> split,
                 std::vector<std::uint32_t>* parent) {
  check_flags(tree, split);
  const Rules rules(tree.kind);
  const auto nodes_of = [&](std::size_t i) -> std::size_t {
    return split[i] != 0 && tree.depth[i] < rules.levels ? rules.children : 1;
  };
  const std::vector<std::size_t> before = block_offsets(tree.leaf_count(), nodes_of);
  CurveTree result;
  result.kind = tree.kind;
  resize(result, before.back());
  if (parent != nullptr) parent->resize(before.back());
  parallel_blocks(tree.leaf_count(), node_block, [&](std::size_t begin, std::size_t end) {
    std::size_t at = before[begin / node_block];
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t nodes = nodes_of(i);
      if (nodes > 1)
        write_children(rules, tree, i, result, at);
      else
        copy_node(tree, i, result, at);
      if (parent != nullptr)
        std::fill_n(parent->begin() + static_cast<std::ptrdiff_t>(at), nodes, static_cast<std::uint32_t>(i));
      at += nodes;
    }
  });
  return result;
}

CurveTree children_of(const CurveTree& tree, std::span<const std::uint8_t> split) {
  check_flags(tree, split);
  const Rules rules(tree.kind);
  const auto children = [&](std::size_t i) -> std::size_t {
    return split[i] != 0 && tree.depth[i] < rules.levels ? rules.children : 0;
  };
  const std::vector<std::size_t> before = block_offsets(tree.leaf_count(), children);
  CurveTree result;
  result.kind = tree.kind;
  resize(result, before.back());
  parallel_blocks(tree.leaf_count(), node_block, [&](std::size_t begin, std::size_t end) {
    std::size_t at = before[begin / node_block];
    for (std::size_t i = begin; i < end; ++i) {
      if (children(i) == 0) continue;
      write_children(rules, tree, i, result, at);
      at += rules.children;
    }
  });
  return result;
}

CurveTree join_levels(std::span<const CurveLevel> levels) {
  CurveTree result;
  if (levels.empty()) return result;
  result.kind = levels.front().nodes.kind;
  const std::size_t branches = Rules(result.kind).children;
  // Bottom up: the number of leaves below each node. The nodes of the next level belong, `branches` at a
  // time, to the split nodes of this level in their order.
  std::vector<std::vector<std::uint64_t>> start(levels.size());
  for (std::size_t level = levels.size(); level-- > 0;) {
    const CurveLevel& here = levels[level];
    check_flags(here.nodes, here.split);
    start[level].assign(here.split.size(), 1);
    std::size_t child = 0;
    for (std::size_t i = 0; i < here.split.size(); ++i) {
      if (here.split[i] == 0) continue;
      if (level + 1 == levels.size() || child + branches > start[level + 1].size())
        throw ItemError(Status::internal,
                        "level " + std::to_string(level) +
                            " of a curve tree has more split nodes than the next has room for");
      start[level][i] = 0;
      for (std::size_t c = 0; c < branches; ++c) start[level][i] += start[level + 1][child++];
    }
  }
  // Top down: counts become positions.
  std::uint64_t total = 0;
  for (std::uint64_t& entry : start.front()) total += std::exchange(entry, total);
  resize(result, total);
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const CurveLevel& here = levels[level];
    std::size_t child = 0;
    for (std::size_t i = 0; i < here.split.size(); ++i) {
      std::uint64_t at = start[level][i];
      if (here.split[i] == 0) {
        copy_node(here.nodes, i, result, at);
        continue;
      }
      for (std::size_t c = 0; c < branches; ++c, ++child) at += std::exchange(start[level + 1][child], at);
    }
  }
  return result;
}

namespace {

// Triangles of positive mass, in curve order of their UV centroids.
struct CentroidsOnCurve {
  std::vector<std::uint64_t> key;  // ascending
  std::vector<double> mass, uv_area;

  double in_leaf(std::size_t i, double leaf_area) const {
    return uv_area[i] <= leaf_area ? mass[i] : mass[i] * (leaf_area / uv_area[i]);
  }
};

CentroidsOnCurve sort_along_curve(CurveKind kind, std::span<const double> u, std::span<const double> v,
                                  std::span<const double> mass, std::span<const double> uv_area) {
  std::vector<KeyIndex> order(mass.size()), scratch;
  parallel_blocks(mass.size(), node_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      order[t] = {curve_key(kind, u[t], v[t]), static_cast<std::uint32_t>(t)};
  });
  std::erase_if(order, [&](const KeyIndex& entry) { return !(mass[entry.index] > 0); });
  radix_sort(order, scratch);
  CentroidsOnCurve sorted;
  sorted.key.resize(order.size());
  sorted.mass.resize(order.size());
  sorted.uv_area.resize(order.size());
  parallel_blocks(order.size(), node_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      sorted.key[i] = order[i].key;
      sorted.mass[i] = mass[order[i].index];
      sorted.uv_area[i] = uv_area.empty() ? 0.0 : uv_area[order[i].index];
    }
  });
  return sorted;
}

// Node i of a level owns the triangles range[2 i] .. range[2 i + 1] - 1 (nodes that were not split leave
// gaps). Returns the ranges of the children.
std::vector<std::uint32_t> ranges_of_children(const CurveLevel& level, const CurveTree& children,
                                              std::span<const std::uint32_t> range,
                                              const CentroidsOnCurve& triangles) {
  const std::size_t branches = Rules(level.nodes.kind).children;
  std::vector<std::uint32_t> parents;
  for (std::uint32_t i = 0; i < level.split.size(); ++i)
    if (level.split[i] != 0) parents.push_back(i);
  std::vector<std::uint32_t> result(2 * children.leaf_count());
  const auto key = triangles.key.begin();
  parallel_blocks(parents.size(), node_block / 16, [&](std::size_t first, std::size_t last) {
    for (std::size_t p = first; p < last; ++p) {
      const std::uint32_t family_end = range[2 * parents[p] + 1];
      std::uint32_t at = range[2 * parents[p]];
      for (std::size_t c = p * branches; c < (p + 1) * branches; ++c) {
        result[2 * c] = at;
        if (c + 1 == (p + 1) * branches)
          at = family_end;
        else
          at = static_cast<std::uint32_t>(std::lower_bound(key + at, key + family_end, children.key[c + 1]) -
                                          key);
        result[2 * c + 1] = at;
      }
    }
  });
  return result;
}

}  // namespace

CurveTree build_curve_tree(std::span<const double> u, std::span<const double> v, std::span<const double> mass,
                           std::span<const double> uv_area, double leaf_mass, int min_depth,
                           const CurveParameters& parameters, const CancelToken& cancel) {
  const int deepest = curve_depth(parameters.kind, parameters.max_depth);
  const int shallowest = std::min(deepest, curve_depth(parameters.kind, min_depth));
  const CentroidsOnCurve triangles = sort_along_curve(parameters.kind, u, v, mass, uv_area);
  std::vector<std::uint32_t> range = {0, static_cast<std::uint32_t>(triangles.key.size())};

  std::vector<CurveLevel> levels;
  levels.push_back({curve_root(parameters.kind), {0}});
  for (int depth = 0; depth < deepest; ++depth) {
    cancel.check();
    CurveLevel& level = levels.back();
    parallel_blocks(level.split.size(), node_block / 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const double leaf_area = level.nodes.side[i] * level.nodes.side[i];
        bool split = depth < shallowest && range[2 * i] < range[2 * i + 1];
        double sum = 0;
        for (std::uint32_t k = range[2 * i]; !split && k < range[2 * i + 1]; ++k) {
          sum += triangles.in_leaf(k, leaf_area);
          split = sum > leaf_mass;
        }
        level.split[i] = split;
      }
    });
    CurveTree children = children_of(level.nodes, level.split);
    const std::size_t count = children.leaf_count();
    if (count == 0) break;
    range = ranges_of_children(level, children, range, triangles);
    levels.push_back({std::move(children), std::vector<std::uint8_t>(count, 0)});
  }
  return join_levels(levels);
}

}  // namespace meander
