#include "kernels/curve/curve_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "kernels/core/random.h"
#include "kernels/core/status.h"
#include "kernels/curve/curve_frames.h"
#include "kernels/curve_reference.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

CurveTree random_tree(CurveKind kind, std::uint32_t seed, int rounds, double share) {
  std::mt19937 random(seed);
  std::bernoulli_distribution coin(share);
  CurveTree tree = curve_root(kind);
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint8_t> split(tree.leaf_count());
    for (auto& flag : split) flag = round == 0 || coin(random);
    tree = refine(tree, split);
  }
  return tree;
}

struct Point {
  double u, v;
};
Point corner_of(const CurveTree& tree, std::size_t leaf, std::uint8_t corner) {
  return {tree.u[leaf] + (corner & 1) * tree.side[leaf], tree.v[leaf] + (corner >> 1) * tree.side[leaf]};
}

// Length of the border that two axis-parallel squares share.
double shared_border(const CurveTree& tree, std::size_t a, std::size_t b) {
  const auto overlap = [&](const std::vector<double>& low) {
    return std::min(low[a] + tree.side[a], low[b] + tree.side[b]) - std::max(low[a], low[b]);
  };
  const double in_u = overlap(tree.u), in_v = overlap(tree.v);
  return std::abs(in_u) < 1e-12 || std::abs(in_v) < 1e-12 ? std::max(in_u, in_v) : -1;
}

std::uint64_t finest_cells(CurveKind kind, int depth) {
  std::uint64_t cells = 1;
  for (int level = depth; level < curve_key_levels(kind); ++level)
    cells *= kind == CurveKind::hilbert ? 4 : 9;
  return cells;
}

// The classic index of a cell along the Hilbert curve that starts at (0, 0), runs up first at odd levels and
// ends at (n - 1, 0): quadrants are visited one by one and rotated (Warren, "Hacker's Delight", chapter 16).
std::uint64_t textbook_hilbert(std::uint32_t side, std::uint32_t x, std::uint32_t y) {
  std::uint64_t index = 0;
  for (std::uint32_t s = side / 2; s > 0; s /= 2) {
    const std::uint32_t right = (x & s) > 0, upper = (y & s) > 0;
    index += std::uint64_t{s} * s * ((3 * right) ^ upper);
    if (upper == 0) {
      if (right == 1) {
        x = side - 1 - x;
        y = side - 1 - y;
      }
      std::swap(x, y);
    }
  }
  return index;
}

}  // namespace

TEST_CASE("curve_root: one leaf that is the unit square") {
  for (const CurveKind kind : curve_kinds) {
    const CurveTree tree = curve_root(kind);
    REQUIRE(tree.leaf_count() == 1);
    CHECK(tree.side[0] == 1.0);
    CHECK(tree.key[0] == 0);
    CHECK(tree.depth[0] == 0);
  }
}

TEST_CASE("refine: leaves of random adaptive trees tile the square in curve order") {
  for (const CurveKind kind : curve_kinds)
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
      const CurveTree tree = random_tree(kind, seed, kind == CurveKind::hilbert ? 9 : 5, 0.4);
      const FrameTable& table = frame_table(kind);
      const std::size_t count = tree.leaf_count();
      REQUIRE(count > 500);
      double area = 0, worst_gap = 0, least_border = 1;
      bool ascending = true, uneven = false;
      for (std::size_t i = 0; i < count; ++i) {
        area += tree.side[i] * tree.side[i];
        if (i == 0) continue;
        const Point exit = corner_of(tree, i - 1, table.exit[tree.frame[i - 1]]);
        const Point entry = corner_of(tree, i, table.entry[tree.frame[i]]);
        worst_gap = std::max({worst_gap, std::abs(exit.u - entry.u), std::abs(exit.v - entry.v)});
        least_border =
            std::min(least_border, shared_border(tree, i - 1, i) / std::min(tree.side[i - 1], tree.side[i]));
        ascending = ascending && tree.key[i - 1] < tree.key[i];
        uneven = uneven || tree.depth[i - 1] + 1 < tree.depth[i];
      }
      CAPTURE(static_cast<int>(kind), seed);
      CHECK(area == Approx(1.0).epsilon(1e-12));
      CHECK(worst_gap < 1e-12);
      CHECK(least_border > 1 - 1e-9);  // the whole side of the smaller of the two
      CHECK(ascending);
      CHECK(uneven);  // neighbors of very different depth do occur
    }
}

TEST_CASE("refine: keys agree with curve_key for every point of a leaf") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> inside(0.001, 0.999);
  for (const CurveKind kind : curve_kinds) {
    const CurveTree tree = random_tree(kind, 11, kind == CurveKind::hilbert ? 12 : 8, 0.3);
    std::size_t wrong = 0, next = 0;
    for (std::size_t i = 0; i < tree.leaf_count(); ++i) {
      const std::uint64_t cells = tree.depth[i] == 0 ? 0 : finest_cells(kind, tree.depth[i]);
      for (int k = 0; k < 4; ++k) {
        const double u = tree.u[i] + inside(random) * tree.side[i];
        const double v = tree.v[i] + inside(random) * tree.side[i];
        const std::uint64_t key = curve_key(kind, u, v);
        wrong += key < tree.key[i] || key - tree.key[i] >= cells;
      }
      next += i + 1 < tree.leaf_count() && tree.key[i + 1] != tree.key[i] + cells;
    }
    CAPTURE(static_cast<int>(kind));
    CHECK(wrong == 0);
    CHECK(next == 0);  // the key of a leaf is the first finest cell after the leaf before it
  }
}

TEST_CASE("refine: parents are recorded, and leaves at the finest level are never split") {
  for (const CurveKind kind : curve_kinds) {
    CurveTree tree = curve_root(kind);
    const int levels = curve_key_levels(kind);
    for (int round = 0; round < levels + 3; ++round) {  // always the second leaf from the end
      std::vector<std::uint8_t> split(tree.leaf_count(), 0);
      split[split.size() > 1 ? split.size() - 2 : 0] = 1;
      std::vector<std::uint32_t> parent;
      const CurveTree finer = refine(tree, split, &parent);
      REQUIRE(parent.size() == finer.leaf_count());
      std::vector<double> area(tree.leaf_count(), 0);
      for (std::size_t i = 0; i < parent.size(); ++i) area[parent[i]] += finer.side[i] * finer.side[i];
      for (std::size_t i = 0; i < area.size(); ++i) REQUIRE(area[i] == Approx(tree.side[i] * tree.side[i]));
      tree = finer;
    }
    CHECK(*std::max_element(tree.depth.begin(), tree.depth.end()) == levels);
    CHECK(std::is_sorted(tree.key.begin(), tree.key.end()));
    CHECK(std::adjacent_find(tree.key.begin(), tree.key.end()) == tree.key.end());
  }
}

TEST_CASE("refine: a wrong number of flags is an internal error") {
  const std::vector<std::uint8_t> two(2, 1);
  CHECK_THROWS_AS(refine(curve_root(CurveKind::hilbert), two), ItemError);
  CHECK_THROWS_AS(children_of(curve_root(CurveKind::hilbert), two), ItemError);
}

TEST_CASE("join_levels: the same leaves as repeated refine") {
  for (const CurveKind kind : curve_kinds) {
    std::mt19937 random(3);
    std::bernoulli_distribution coin(0.45);
    CurveTree tree = curve_root(kind);
    std::vector<CurveLevel> levels = {{curve_root(kind), {0}}};
    for (int depth = 0; depth < 7; ++depth) {
      CurveLevel& level = levels.back();
      std::vector<std::uint8_t> split(tree.leaf_count(), 0);
      std::size_t node = 0;
      for (std::size_t i = 0; i < tree.leaf_count(); ++i) {
        if (tree.depth[i] != depth) continue;
        split[i] = level.split[node++] = depth < 2 || coin(random);
      }
      REQUIRE(node == level.split.size());
      tree = refine(tree, split);
      CurveTree children = children_of(level.nodes, level.split);
      const std::size_t count = children.leaf_count();
      levels.push_back({std::move(children), std::vector<std::uint8_t>(count, 0)});
    }
    const CurveTree joined = join_levels(levels);
    CHECK(joined.key == tree.key);
    CHECK(joined.u == tree.u);
    CHECK(joined.v == tree.v);
    CHECK(joined.side == tree.side);
    CHECK(joined.depth == tree.depth);
    CHECK(joined.frame == tree.frame);
    CHECK(joined.kind == kind);
  }
}

TEST_CASE("build_curve_tree: leaves are light, deep enough, and cover the square") {
  std::mt19937 random(5);
  std::normal_distribution<double> bump(0.3, 0.05);
  std::vector<double> u, v, mass;
  for (int i = 0; i < 20000; ++i) {
    u.push_back(std::clamp(bump(random), 0.0, 1.0));
    v.push_back(std::clamp(bump(random), 0.0, 1.0));
    mass.push_back(i % 10 == 0 ? 0.0 : 1.0);
  }
  const double total = std::accumulate(mass.begin(), mass.end(), 0.0);
  for (const CurveKind kind : curve_kinds) {
    CurveParameters parameters;
    parameters.kind = kind;
    const double leaf_mass = total / 512;
    const CurveTree tree = build_curve_tree(u, v, mass, {}, leaf_mass, 5, parameters);
    std::vector<double> gathered(tree.leaf_count(), 0);
    for (std::size_t t = 0; t < mass.size(); ++t) {
      const std::uint64_t key = curve_key(kind, u[t], v[t]);
      const auto leaf = std::upper_bound(tree.key.begin(), tree.key.end(), key) - tree.key.begin() - 1;
      gathered[static_cast<std::size_t>(leaf)] += mass[t];
    }
    double area = 0, heaviest = 0;
    int shallowest = 99;
    for (std::size_t i = 0; i < tree.leaf_count(); ++i) {
      area += tree.side[i] * tree.side[i];
      heaviest = std::max(heaviest, gathered[i]);
      if (gathered[i] > 0) shallowest = std::min<int>(shallowest, tree.depth[i]);
    }
    CHECK(area == Approx(1.0).epsilon(1e-12));
    CHECK(heaviest <= leaf_mass);
    CHECK(shallowest >= curve_depth(kind, 5));
    CHECK(tree.leaf_count() > 512);
    CHECK(tree.leaf_count() < 20 * 512);
  }
}

TEST_CASE("build_curve_tree: a large triangle does not refine the tree only at its centroid") {
  const std::vector<double> u = {1.0 / 3}, v = {1.0 / 3}, mass = {1}, uv_area = {0.5};
  const CurveTree with_area = build_curve_tree(u, v, mass, uv_area, 1.0 / 64, 0, {});
  CHECK(*std::max_element(with_area.depth.begin(), with_area.depth.end()) == 4);  // 4^-4 / 0.5 <= 1 / 64
  const CurveTree point_mass = build_curve_tree(u, v, mass, {}, 1.0 / 64, 0, {});
  CHECK(*std::max_element(point_mass.depth.begin(), point_mass.depth.end()) == 24);
  CHECK(point_mass.leaf_count() == 1 + 3 * 24);
}

TEST_CASE("build_curve_tree: without points the square stays one leaf") {
  CHECK(build_curve_tree({}, {}, {}, {}, 1, 6, {}).leaf_count() == 1);
  const std::vector<double> u = {0.5, 0.2}, v = {1.0, 0.0}, mass = {0, 0};
  CHECK(build_curve_tree(u, v, mass, {}, 1, 6, {}).leaf_count() == 1);
}

TEST_CASE("build_curve_tree: points on and beyond the border of the square have a leaf") {
  const std::vector<double> u = {0, 1, 1, 0, 1.0000001}, v = {0, 0, 1, 1, -1e-9}, mass = {1, 1, 1, 1, 1};
  for (const CurveKind kind : curve_kinds) {
    CurveParameters parameters;
    parameters.kind = kind;
    const CurveTree tree = build_curve_tree(u, v, mass, {}, 1.5, 4, parameters);
    const double area = std::inner_product(tree.side.begin(), tree.side.end(), tree.side.begin(), 0.0);
    CHECK(area == Approx(1.0));
    // two points at (1, 0) can never be separated by a leaf mass of 1.5
    CHECK(*std::max_element(tree.depth.begin(), tree.depth.end()) == curve_depth(kind, 24));
  }
}

TEST_CASE("build_curve_tree: the same tree on one thread and on two") {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<double> u(120000), v(u.size()), mass(u.size());
  for (std::size_t t = 0; t < u.size(); ++t) {
    u[t] = unit(random);
    v[t] = unit(random) * unit(random);
    mass[t] = unit(random);
  }
  const auto build = [&](std::size_t threads) {
    return test::on_threads(threads, [&] { return build_curve_tree(u, v, mass, {}, 1.0, 4, {}); });
  };
  const CurveTree one = build(1), two = build(2);
  CHECK(one.leaf_count() > 60000);
  CHECK(one.key == two.key);
  CHECK(one.depth == two.depth);
}

TEST_CASE("build_curve_tree: respects the deadline") {
  CancelToken late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  const std::vector<double> one = {0.5};
  CHECK_THROWS_AS(build_curve_tree(one, one, one, {}, 0.1, 4, {}, late), ItemError);
}

TEST_CASE("curve_key: Hilbert keys match the textbook index") {
  constexpr std::uint32_t side =
      64;  // six levels: an even number, so both curves start in the same direction
  const auto of_cell = [](std::uint32_t x, std::uint32_t y) {
    return curve_key(CurveKind::hilbert, (x + 0.5) / side, (y + 0.5) / side) >> (2 * (32 - 6));
  };
  std::size_t wrong = 0;
  const bool transposed = of_cell(0, 1) != textbook_hilbert(side, 0, 1);
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x)
      wrong += of_cell(x, y) != (transposed ? textbook_hilbert(side, y, x) : textbook_hilbert(side, x, y));
  CHECK(wrong == 0);
}

TEST_CASE("curve_key: every kind visits neighboring cells consecutively") {
  for (const CurveKind kind : curve_kinds) {
    const std::uint32_t side = kind == CurveKind::hilbert ? 32 : 27;
    const int depth = kind == CurveKind::hilbert ? 5 : 3;
    std::vector<std::array<int, 2>> cell(side * side, {-1, -1});
    for (std::uint32_t y = 0; y < side; ++y)
      for (std::uint32_t x = 0; x < side; ++x) {
        const std::uint64_t key = curve_key(kind, (x + 0.5) / side, (y + 0.5) / side);
        cell.at(key / finest_cells(kind, depth)) = {static_cast<int>(x), static_cast<int>(y)};
      }
    std::size_t jumps = 0;
    for (std::size_t i = 1; i < cell.size(); ++i)
      jumps += std::abs(cell[i][0] - cell[i - 1][0]) + std::abs(cell[i][1] - cell[i - 1][1]) != 1;
    CHECK(jumps == 0);
    CHECK(cell[0] == std::array<int, 2>{0, 0});
  }
}

TEST_CASE("curve_key: clamps points outside the square") {
  for (const CurveKind kind : curve_kinds) {
    CHECK(curve_key(kind, -3, -1e300) == curve_key(kind, 0, 0));
    CHECK(curve_key(kind, 1, 0.25) == curve_key(kind, 1 - 1e-12, 0.25));
    CHECK(curve_key(kind, 1e300, 2) == curve_key(kind, 1, 1));
  }
}

TEST_CASE("hilbert_key_3d: a bijection of the coarse grid, consecutive cells touch") {
  constexpr int side = 8;  // three levels of 21
  std::vector<std::array<int, 3>> cell(side * side * side, {-9, -9, -9});
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const auto middle = [](int i) { return (i + 0.5) * 2 / side - 1; };
        const std::uint64_t key = hilbert_key_3d({middle(x), middle(y), middle(z)}) >> (3 * (21 - 3));
        REQUIRE(key < cell.size());
        REQUIRE(cell[key][0] == -9);  // not taken yet
        cell[key] = {x, y, z};
      }
  std::size_t jumps = 0;
  for (std::size_t i = 1; i < cell.size(); ++i) {
    int steps = 0;
    for (std::size_t k = 0; k < 3; ++k) steps += std::abs(cell[i][k] - cell[i - 1][k]);
    jumps += steps != 1;
  }
  CHECK(jumps == 0);
}

TEST_CASE("hilbert_key_3d: agrees with Skilling's own transform on all 21 levels") {
  std::mt19937 random(6);
  std::uniform_int_distribution<std::uint32_t> cell(0, (1u << 21) - 1);
  std::size_t wrong = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::array<std::uint32_t, 3> c = {cell(random), cell(random), cell(random)};
    const auto middle = [](std::uint32_t k) { return (k + 0.5) * 0x1p-20 - 1; };
    wrong += hilbert_key_3d({middle(c[0]), middle(c[1]), middle(c[2])}) != skilling_key(c);
  }
  CHECK(wrong == 0);
}

TEST_CASE("hilbert_key_3d: clamps, and distinguishes the finest cells") {
  CHECK(hilbert_key_3d({2, -7, 0.5}) == hilbert_key_3d({1, -1, 0.5}));
  const double cell = 0x1p-20;
  CHECK(hilbert_key_3d({0.5 * cell, 0, 0}) != hilbert_key_3d({1.5 * cell, 0, 0}));
  CHECK(hilbert_key_3d({0.25 * cell, 0, 0}) == hilbert_key_3d({0.75 * cell, 0, 0}));
}
