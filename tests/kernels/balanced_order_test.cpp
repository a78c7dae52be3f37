// The balanced order: balance at every level, the mass of every share, compact cells, sheets, and one result
// whatever the threads.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/partition/balanced_order.h"
#include "kernels/partition/sheet_cut.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

namespace {

constexpr RandomKey key{{7, 11}};

// Uniform points of the unit square at z = 0 with masses between 1 and 2.
std::vector<MassPoint> square_points(std::uint32_t count) {
  std::vector<MassPoint> points;
  for (std::uint32_t i = 0; i < count; ++i) {
    const UnitPair at = random_pair(key, Stream::test_shapes, i);
    const double mass = 1 + random_pair(key, Stream::test_shapes, i, 1).first;
    points.push_back({{static_cast<float>(at.first), static_cast<float>(at.second), 0}, mass});
  }
  return points;
}

double total_of(const std::vector<MassPoint>& points) {
  double total = 0;
  for (const MassPoint& p : points) total += p.mass;
  return total;
}

// All entries in the order of the path.
struct BalancedOrder {
  std::vector<std::uint32_t> element, part;
  std::vector<double> cumulative{0};
};
BalancedOrder ordered(std::span<const MassPoint> elements, std::uint32_t n,
                      const ElementTraits& traits = {}) {
  const BalancedCells cells = balanced_order({elements.begin(), elements.end()}, n, traits);
  BalancedOrder order;
  std::vector<std::uint32_t> numbers;
  CellEntry passed{};
  for (const Cell& cell : cells.cell) {
    order_entries(cells, cell, numbers);
    for (const std::uint32_t number : numbers) {
      const CellEntry& entry = cells.entries(cell)[number];
      order.element.push_back(entry.element());
      order.part.push_back(entry.part());
      passed.mass += entry.mass;
      order.cumulative.push_back(cells.mass(passed));
    }
  }
  return order;
}

// The bounding box of each of n equal shares of the order: lengths along x, y, z.
std::vector<std::array<float, 3>> extents(const std::vector<MassPoint>& points, const BalancedOrder& order,
                                          std::uint32_t n) {
  std::vector<std::array<float, 3>> least(n, {9, 9, 9}), most(n, {-9, -9, -9});
  const double share = order.cumulative.back() / n;
  for (std::size_t i = 0; i < order.element.size(); ++i) {
    const double middle = 0.5 * (order.cumulative[i] + order.cumulative[i + 1]);
    const auto cell = static_cast<std::size_t>(std::min(middle / share, n - 1.0));
    for (std::size_t k = 0; k < 3; ++k) {
      least[cell][k] = std::min(least[cell][k], points[order.element[i]].at[k]);
      most[cell][k] = std::max(most[cell][k], points[order.element[i]].at[k]);
    }
  }
  for (std::size_t c = 0; c < n; ++c)
    for (std::size_t k = 0; k < 3; ++k) most[c][k] -= least[c][k];
  return most;
}

}  // namespace

TEST_CASE("balanced order: every element keeps its mass, and few are split") {
  for (const std::uint32_t n : {1u, 2u, 3u, 7u, 64u, 1000u}) {
    const std::vector<MassPoint> points = square_points(5000);
    const BalancedOrder order = ordered(points, n);
    REQUIRE(order.cumulative.size() == order.element.size() + 1);
    CHECK(order.element.size() <= points.size() + n - 1);
    CHECK(order.cumulative.front() == 0);
    CHECK(order.cumulative.back() == Approx(total_of(points)).epsilon(1e-14));
    CHECK(std::is_sorted(order.cumulative.begin(), order.cumulative.end()));
    std::vector<double> mass(points.size(), 0.0);
    for (std::size_t i = 0; i < order.element.size(); ++i)
      mass[order.element[i]] += order.cumulative[i + 1] - order.cumulative[i];
    double worst = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      worst = std::max(worst, std::abs(mass[i] - points[i].mass));
    CHECK(worst < 1e-10);
  }
}

TEST_CASE("balanced order: the cells of every tree level are boxes that do not overlap") {
  // With 64 shares, the 2^k blocks of consecutive shares are the nodes of level k: boxes of equal mass.
  constexpr std::uint32_t n = 64;
  const std::vector<MassPoint> points = square_points(20000);
  const BalancedOrder order = ordered(points, n);
  for (std::uint32_t blocks = 2; blocks <= n; blocks *= 2) {
    double area = 0;
    for (const auto& e : extents(points, order, blocks))
      area += static_cast<double>(e[0]) * static_cast<double>(e[1]);
    INFO(blocks << " blocks cover " << area << " of the unit square");
    CHECK(area < 1.03);  // divided elements stick out of their cells
    CHECK(area > 0.8);   // and cells end at the centroids of their elements
  }
}

TEST_CASE("balanced order: shares are cut by mass, not by the number of elements") {
  // All elements left of the middle weigh three times as much: of 8 shares 6 lie there.
  std::vector<MassPoint> points = square_points(4096);
  for (MassPoint& p : points) p.mass = p.at[0] < 0.5f ? 3 : 1;
  const BalancedOrder order = ordered(points, 8);
  const double share = order.cumulative.back() / 8;
  std::array<double, 8> left{};
  for (std::size_t i = 0; i < order.element.size(); ++i) {
    const double middle = 0.5 * (order.cumulative[i] + order.cumulative[i + 1]);
    if (points[order.element[i]].at[0] < 0.5f)
      left[static_cast<std::size_t>(std::min(middle / share, 7.0))] +=
          order.cumulative[i + 1] - order.cumulative[i];
  }
  CHECK(std::accumulate(left.begin(), left.end(), 0.0) / share == Approx(6).epsilon(0.03));
}

TEST_CASE("balanced order: consecutive cells are neighbors") {
  constexpr std::uint32_t n = 1000;
  const std::vector<MassPoint> points = square_points(16000);
  const BalancedOrder order = ordered(points, n);
  std::vector<std::array<double, 2>> center(n, {0, 0});
  std::vector<double> mass(n, 0);
  for (std::size_t i = 0; i < order.element.size(); ++i) {
    const double m = order.cumulative[i + 1] - order.cumulative[i];
    const auto cell = static_cast<std::size_t>(std::min(
        0.5 * (order.cumulative[i] + order.cumulative[i + 1]) / order.cumulative.back() * n, n - 1.0));
    for (std::size_t k = 0; k < 2; ++k)
      center[cell][k] += m * static_cast<double>(points[order.element[i]].at[k]);
    mass[cell] += m;
  }
  double sum = 0;
  for (std::size_t c = 0; c + 1 < n; ++c)
    sum += std::hypot(center[c][0] / mass[c] - center[c + 1][0] / mass[c + 1],
                      center[c][1] / mass[c] - center[c + 1][1] / mass[c + 1]);
  const double step = sum / (n - 1) * std::sqrt(static_cast<double>(n));
  INFO("mean step " << step << " of a cell's width");
  CHECK(step < 1.25);  // 1 is the least; children in the order of the axes have 1.5
}

struct Splits {
  std::vector<std::uint32_t> element;
  std::vector<ElementSplit> split;
  operator ElementSplits() const { return {element, split}; }
  int levels(std::uint32_t e) const {
    const auto at = std::lower_bound(element.begin(), element.end(), e);
    return at == element.end() || *at != e ? 0 : split[static_cast<std::size_t>(at - element.begin())].levels;
  }
};

// Split to two levels, but for some to one or none; each part within a thousandth of the centroid.
Splits small_splits(std::uint32_t elements) {
  ElementSplit split{2, {0.001f, 0, 0}, {{0, 0.0005f, 0}, {0, 0.0004f, 0}}};
  Splits splits;
  for (std::uint32_t e = 0; e < elements; ++e) {
    if (e % 6 == 0) continue;
    split.levels = e % 6 == 3 ? 1 : 2;
    splits.element.push_back(e);
    splits.split.push_back(split);
  }
  return splits;
}

TEST_CASE("balanced order: splits are resolved in small cells, and nothing is lost") {
  const std::vector<MassPoint> points = square_points(1000);
  const Splits splits = small_splits(1000);
  for (const std::uint32_t n : {1u, 8u, 33u, 100u, 129u, 500u}) {
    const BalancedOrder order = ordered(points, n, {{}, splits, {}, {}});
    CHECK(order.cumulative.back() == Approx(total_of(points)).epsilon(1e-14));
    std::vector<std::array<double, 8>> mass(points.size());
    for (std::size_t i = 0; i < order.element.size(); ++i)
      mass[order.element[i]][order.part[i]] += order.cumulative[i + 1] - order.cumulative[i];
    std::size_t divided = 0;
    for (std::uint32_t e = 0; e < points.size(); ++e) {
      double sum = 0;
      for (std::size_t part = 1; part < 8; ++part) {
        const int level = std::bit_width(part) - 1;
        CHECK((mass[e][part] == 0 || level <= splits.levels(e)));
        // No part weighs more than its share of the element.
        CHECK(mass[e][part] <= std::ldexp(points[e].mass, -level) * (1 + 1e-9));
        if (level < splits.levels(e) && mass[e][part] > 0) ++divided;
        sum += mass[e][part];
      }
      CHECK(sum == Approx(points[e].mass).epsilon(1e-9));
    }
    CHECK(divided <= 2 * (n / 16 + n / 64));  // only cuts of more than 32 shares keep elements whole
  }
}

TEST_CASE("balanced order: the same whether elements are freed early or not, with and without splits") {
  const std::vector<MassPoint> points = square_points(1000);
  const Splits splits = small_splits(1000);
  for (const bool with_splits : {false, true})
    for (const std::uint32_t n : {8u, 100u, 500u}) {
      ElementTraits traits;
      if (with_splits) traits.splits = splits;
      const BalancedCells kept = balanced_order(points, n, traits);
      const BalancedCells freed = balanced_order(points, n, traits, {}, n);
      REQUIRE(kept.cell.size() == freed.cell.size());
      std::size_t parts = 0;
      for (std::size_t c = 0; c < kept.cell.size(); ++c) {
        const std::span<const CellEntry> a = kept.entries(kept.cell[c]), b = freed.entries(freed.cell[c]);
        REQUIRE(a.size() == b.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
          CHECK((a[i].name == b[i].name && a[i].mass == b[i].mass));
          CHECK(std::equal(a[i].at, a[i].at + 3, b[i].at));
          parts += a[i].part() > 1;
        }
      }
      CHECK((parts > 0) == with_splits);
    }
}

TEST_CASE("balanced order: parts of splits lie where the element says") {
  // One element, whose parts are points of a line.
  const std::vector<MassPoint> points = {{{0, 0, 0}, 1.0}};
  const Splits splits{{0}, {{2, {0.4f, 0, 0}, {{-0.2f, 0, 0}, {0.2f, 0, 0}}}}};
  const BalancedOrder order = ordered(points, 4, {{}, splits, {}, {}});
  std::vector<std::uint32_t> along = order.part;
  if (along.front() != 7) std::reverse(along.begin(), along.end());
  // At -0.6, -0.2, 0.2 and 0.6.
  CHECK(along == std::vector<std::uint32_t>{7, 6, 4, 5});
}

TEST_CASE("entry_at: matches the order of all entries") {
  std::vector<MassPoint> points = square_points(3000);
  for (std::size_t i = 0; i < points.size(); i += 7) points[i].mass = 0;
  for (std::size_t i = 0; i + 1 < points.size(); i += 5) std::copy_n(points[i].at, 3, points[i + 1].at);
  for (const std::uint32_t n : {1u, 40u, 700u}) {
    const BalancedCells cells = balanced_order(points, n);
    std::vector<std::uint32_t> numbers;
    std::vector<std::uint64_t> scratch;
    for (std::size_t c = 0; c < n; ++c) {
      const Cell& cell = cells.cell[c];
      order_entries(cells, cell, numbers);
      double total = 0;
      for (const CellEntry& entry : cells.entries(cell)) total += cells.mass(entry);
      for (const double share : {0.0, 0.1, 0.5, 0.77, 1.0}) {
        const CellEntry& found = entry_at(cells, cell, share, scratch);
        CHECK(found.mass > 0);
        double before = 0;
        for (const std::uint32_t number : numbers) {
          const CellEntry& entry = cells.entries(cell)[number];
          if (&entry == &found) break;
          before += cells.mass(entry);
        }
        CHECK(before <= share * total * (1 + 1e-9));
        CHECK(before + cells.mass(found) >= share * total * (1 - 1e-9));
      }
    }
  }
}

TEST_CASE("balanced order: equal points, no extent, elements without mass and one share") {
  std::vector<MassPoint> points;
  for (std::uint32_t i = 0; i < 1000; ++i) points.push_back({{0.25f, 0.5f, -0.5f}, i % 3 == 0 ? 0.0 : 1.0});
  for (const std::uint32_t n : {1u, 5u, 700u}) {
    const BalancedOrder order = ordered(points, n);
    CHECK(order.cumulative.back() == Approx(total_of(points)).epsilon(1e-14));
    CHECK(std::set<std::uint32_t>(order.element.begin(), order.element.end()).size() == points.size());
  }
  CHECK_THROWS_AS(balanced_order(points, 0), std::invalid_argument);
  CHECK_THROWS_AS(balanced_order({}, 4), std::invalid_argument);
}

TEST_CASE("balanced order: more shares than elements") {
  const BalancedOrder order = ordered(square_points(10), 1000);
  CHECK(order.element.size() <= 1009);
  CHECK(order.cumulative.back() == Approx(total_of(square_points(10))).epsilon(1e-14));
}

TEST_CASE("balanced order: masses of very different size") {
  std::vector<MassPoint> points = square_points(3000);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].mass = std::ldexp(1.0, -static_cast<int>(i % 80));
  const BalancedOrder order = ordered(points, 50);
  CHECK(order.cumulative.back() == Approx(total_of(points)).epsilon(1e-12));
  CHECK(std::is_sorted(order.cumulative.begin(), order.cumulative.end()));
}

TEST_CASE("balanced order: extents and totals at the limits of float and double") {
  for (const double unit : {5e-324, 1e-306, 1e-300, 1.0, 1e300}) {
    std::vector<MassPoint> points = square_points(300);
    for (MassPoint& p : points) {
      for (float& x : p.at) x *= 1e-40f;
      p.mass = unit;
    }
    for (const std::uint32_t n : {1u, 2u, 7u, 40u}) {
      const BalancedOrder order = ordered(points, n);
      INFO(unit << ", " << n << " shares");
      CHECK(order.cumulative.back() / unit == Approx(300).epsilon(1e-9));
      CHECK(std::is_sorted(order.cumulative.begin(), order.cumulative.end()));
    }
  }
}

TEST_CASE("balanced order: traits that do not fit the elements are refused") {
  const std::vector<MassPoint> points = square_points(10);
  const std::vector<float> normal(30);
  CHECK_THROWS_AS(balanced_order(points, 4, {{}, {}, normal, {}}), std::invalid_argument);
  const std::vector<ElementSplit> two(2);
  for (const std::vector<std::uint32_t>& numbers :
       {std::vector<std::uint32_t>{3}, {3, 3}, {4, 3}, {3, 10}, {3, 4, 5}})
    CHECK_THROWS_AS(balanced_order(points, 4, {{}, {numbers, two}, {}, {}}), std::invalid_argument);
  const std::vector<std::uint32_t> good = {3, 9};
  CHECK_NOTHROW(balanced_order(points, 4, {{}, {good, two}, {}, {}}));
}

TEST_CASE("balanced order: the same for 1, 2 and 8 threads, with splits, normals and a stack") {
  std::vector<MassPoint> points = square_points(200000);
  std::vector<std::uint32_t> triangle(points.size());
  std::vector<float> normal;
  const Splits splits = small_splits(200000);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    triangle[i] = i / 2;
    const bool top = i / 2 % 3 == 0;
    points[i].at[2] = top ? 0.001f : 0.0f;
    if (i % 2 != 0) continue;
    normal.insert(normal.end(), {0, 0, top ? 1.0f : -1.0f});
  }
  BalancedOrder expected;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const BalancedOrder order = test::on_threads(threads, [&] {
      return ordered(points, 3000, {triangle, splits, normal, {}});
    });
    if (expected.element.empty()) expected = order;
    CHECK(order.element == expected.element);
    CHECK(order.part == expected.part);
    CHECK(order.cumulative == expected.cumulative);
  }
}

TEST_CASE("balanced order: the same for 1, 2 and 8 threads") {
  const std::vector<MassPoint> points = square_points(200000);
  BalancedOrder expected;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const BalancedOrder order = test::on_threads(threads, [&] { return ordered(points, 3000); });
    if (expected.element.empty()) expected = order;
    CHECK(order.element == expected.element);
    CHECK(order.part == expected.part);
    CHECK(order.cumulative == expected.cumulative);
  }
}

TEST_CASE("balanced order: invariant to scaling and axis order up to rounding") {
  const std::vector<MassPoint> points = square_points(2000);
  std::vector<MassPoint> other = points;
  for (MassPoint& p : other) p = {{0, 0.25f * p.at[0], 0.25f * p.at[1]}, 16 * p.mass};
  const BalancedOrder a = ordered(points, 100);
  const BalancedOrder b = ordered(other, 100);
  CHECK(a.element == b.element);
}

TEST_CASE("balanced order: groups stay together, in their order") {
  std::vector<MassPoint> points = square_points(3000);
  std::vector<std::uint32_t> triangle(points.size()), group(points.size());
  std::iota(triangle.begin(), triangle.end(), 0u);
  for (std::size_t i = 0; i < points.size(); ++i) group[i] = i < 700 ? 2 : i < 710 ? 5 : i < 2000 ? 16 : 48;
  for (const std::uint32_t n : {1u, 10u, 333u}) {
    const BalancedOrder order = ordered(points, n, {triangle, {}, {}, group});
    std::uint32_t before = 0;
    std::size_t descents = 0;
    for (const std::uint32_t e : order.element) {
      descents += group[e] < before;
      before = group[e];
    }
    INFO(n);
    CHECK(descents == 0);
  }
}

TEST_CASE("balanced order: the sides of a thin plate are separated by their normals") {
  // Two coincident squares, 0.002 apart.
  std::vector<MassPoint> points = square_points(16000);
  std::vector<float> normal;
  std::vector<std::uint32_t> triangle(points.size());
  std::iota(triangle.begin(), triangle.end(), 0u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool top = i % 2 == 0;
    points[i].at[2] = top ? 0.002f : 0.0f;
    points[i].mass = 1;
    normal.insert(normal.end(), {0, 0, top ? 1.0f : -1.0f});
  }
  constexpr std::uint32_t n = 500;
  const auto mixed = [&](const BalancedOrder& order) {
    std::array<std::vector<int>, 2> counts = {std::vector<int>(n), std::vector<int>(n)};
    for (std::size_t i = 0; i < order.element.size(); ++i) {
      const auto cell = static_cast<std::size_t>(std::min(
          0.5 * (order.cumulative[i] + order.cumulative[i + 1]) / order.cumulative.back() * n, n - 1.0));
      ++counts[order.element[i] % 2][cell];
    }
    int cells = 0;
    for (std::size_t c = 0; c < n; ++c) cells += counts[0][c] > 0 && counts[1][c] > 0;
    return cells;
  };
  CHECK(mixed(ordered(points, n, {triangle, {}, normal, {}})) <= 2);
  CHECK(mixed(ordered(points, n, {triangle, {}, {}, {}})) > 400);

  // Nor does a speck far away, first in the list, keep them from it. (Its number is even, as those of the
  // top.)
  points.insert(points.begin(), 2, {{-1, -1, -1}, 1e-6});
  normal.insert(normal.begin(), {0, 0, 1, 0, 0, 1});
  triangle.push_back(16000);
  triangle.push_back(16001);
  CHECK(mixed(ordered(points, n, {triangle, {}, normal, {}})) <= 6);
}

TEST_CASE("sheet cut: stacks are recognized, bends, patches and flipped faces are not") {
  // As they are, and tilted and far from the origin.
  const bool tilted = GENERATE(false, true);
  SheetScratch scratch;
  const auto turned = [tilted](std::array<float, 3> v) {
    if (!tilted) return v;
    const std::array<float, 3> w = {0.6f * v[0] - 0.8f * v[1], 0.8f * v[0] + 0.6f * v[1], v[2]};
    return std::array<float, 3>{w[0], 0.28f * w[1] - 0.96f * w[2], 0.96f * w[1] + 0.28f * w[2]};
  };
  const auto probes = [&](auto make, std::size_t count) {
    scratch.probes.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      const UnitPair at = random_pair(key, Stream::test_shapes, i, 3);
      SheetProbe probe = make(static_cast<float>(at.first), static_cast<float>(at.second), i);
      probe.at = turned(probe.at);
      probe.normal = turned(probe.normal);
      if (tilted)
        for (float& x : probe.at) x -= 0.5f;
      scratch.probes.push_back(probe);
    }
  };
  const auto fill = [&](auto make) {
    probes(make, many_sheet_probes);
    return find_sheet_cut(scratch, 64);
  };
  const auto plate = [](float thickness) {
    return [thickness](float x, float y, std::uint32_t i) {
      return SheetProbe{{x, y, i % 2 == 0 ? 0.0f : thickness}, {0, 0, i % 2 == 0 ? -1.0f : 1.0f}};
    };
  };
  const std::optional<SheetCut> sides = fill(plate(0.01f));
  REQUIRE(sides);
  CHECK(sides->by_normal);
  CHECK_FALSE(fill(plate(0.3f)));  // thicker than a sample's share is wide
  CHECK_FALSE(fill(plate(0.0f)));  // faces of one flat sheet, turned differently
  const std::optional<SheetCut> layers = fill([](float x, float y, std::uint32_t i) {
    return SheetProbe{{x, y, 0.01f * static_cast<float>(i % 4)}, {0, 0, 1}};
  });
  REQUIRE(layers);
  CHECK_FALSE(layers->by_normal);
  // Two layers on either side.
  const std::array<float, 3> up = turned({0, 0, 1});
  const float shift = tilted ? -0.5f * (up[0] + up[1] + up[2]) : 0.0f;
  CHECK(std::abs(layers->threshold) == Approx(std::abs(0.015f + shift)).margin(1e-4));
  CHECK_FALSE(fill([](float x, float y, std::uint32_t) { return SheetProbe{{x, y, 0}, {0, 0, 1}}; }));
  CHECK_FALSE(fill([](float x, float y, std::uint32_t) {  // a step: patches beside each other
    return SheetProbe{{x, y, x < 0.5f ? 0.0f : 0.01f}, {0, 0, 1}};
  }));
  CHECK_FALSE(fill([](float x, float y, std::uint32_t) {  // a sphere's cap
    const float z = std::sqrt(4 - x * x - y * y);
    return SheetProbe{{x, y, z}, {x / 2, y / 2, z / 2}};
  }));

  // By few probes stacks may be there, and what is far from one is not.
  const auto may_be = [&](auto make) {
    probes(make, few_sheet_probes);
    return may_be_stack(scratch, 64);
  };
  CHECK(may_be(plate(0.01f)));
  CHECK_FALSE(may_be(plate(1.0f)));
  CHECK_FALSE(may_be(plate(0.0f)));
  CHECK_FALSE(may_be([](float x, float y, std::uint32_t) { return SheetProbe{{x, y, 0}, {0, 0, 1}}; }));
  CHECK_FALSE(may_be([](float x, float y, std::uint32_t i) {  // two patches that face different ways
    return SheetProbe{{x + (i % 2 == 0 ? 0.0f : 1.1f), y, 0.01f * static_cast<float>(i % 2)},
                      {0, 0, i % 2 == 0 ? 1.0f : -1.0f}};
  }));
}
