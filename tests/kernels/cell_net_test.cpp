// The net that samples of the default sequence form in the cells of balanced bisection: one sample in every
// elementary interval of a flat square, every entry as often as its share of the mass asks for, and an order
// whose prefixes have one sample in every node of the tree.
#include "kernels/sample/cell_net.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "support/catch.h"
#include "support/sanitized.h"

using namespace meander;
using namespace meander::test;

namespace {

// The centers of a grid of side x side points of equal mass in the unit square.
std::vector<MassPoint> square_grid(std::uint32_t side) {
  std::vector<MassPoint> points;
  for (std::uint32_t i = 0; i < side; ++i)
    for (std::uint32_t j = 0; j < side; ++j)
      points.push_back({{(static_cast<float>(i) + 0.5f) / static_cast<float>(side),
                         (static_cast<float>(j) + 0.5f) / static_cast<float>(side), 0},
                        1});
  return points;
}

// The entries that a set of samples lies in, by rank.
std::vector<CellEntry> net_of(const BalancedCells& cells, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  const DigitalShift shift = digital_shift(key);
  CellNetScratch scratch;
  std::vector<CellEntry> net;
  for (std::size_t c = 0; c < cells.cell.size(); ++c)
    net.push_back(
        entry_in_net(cells, cells.cell[c], shift, random_pair(key, Stream::sequence, c).first, scratch));
  return net;
}

// The order of a set whose samples lie in those entries.
std::vector<std::uint32_t> order_of(const BalancedCells& cells, std::uint64_t seed) {
  const std::vector<CellEntry> net = net_of(cells, seed);
  return cell_net_order(cells, make_random_key(seed, {}), [&](std::uint32_t rank) {
    return std::array<float, 3>{net[rank].at[0], net[rank].at[1], net[rank].at[2]};
  });
}

}  // namespace

TEST_CASE("cell net: one sample in every elementary interval of a flat square") {
  // 4^k samples, and intervals of that area from 4 times as wide as the cells to 4 times as high.
  for (const std::uint32_t k : {2u, 3u, 4u}) {
    const std::uint32_t side = 1u << k, n = side * side;
    const BalancedCells cells = balanced_order(square_grid(8 * side), n);
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const std::vector<CellEntry> net = net_of(cells, seed);
      for (int stretch = -2; stretch <= 2; ++stretch) {
        const auto columns = static_cast<float>(std::ldexp(side, stretch)),
                   rows = static_cast<float>(std::ldexp(side, -stretch));
        std::set<std::pair<int, int>> intervals;
        for (const CellEntry& entry : net)
          intervals.insert({static_cast<int>(entry.at[0] * columns), static_cast<int>(entry.at[1] * rows)});
        INFO(n << " samples, " << columns << " x " << rows << " intervals, seed " << seed);
        CHECK(intervals.size() == n);
      }
    }
  }
}

TEST_CASE("cell net: every entry is selected in proportion to its mass") {
  // Cells of entries of masses 1 to 16, in all three axes; chi-square over all of them, 2000 shifts.
  constexpr RandomKey key{{7, 11}};
  std::vector<MassPoint> points;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const UnitPair xy = random_pair(key, Stream::test_shapes, i),
                   zm = random_pair(key, Stream::test_shapes, i, 1);
    points.push_back(
        {{static_cast<float>(xy.first), static_cast<float>(xy.second), static_cast<float>(zm.first)},
         std::exp2(4 * zm.second)});
  }
  const BalancedCells cells = balanced_order(points, 20);
  constexpr int sets = 2000;
  std::vector<double> count(points.size()), expected(points.size());
  std::uint64_t cell_mass = 0;
  for (const CellEntry& entry : cells.entries(cells.cell[0])) cell_mass += entry.mass;
  for (const Cell& cell : cells.cell)
    for (const CellEntry& entry : cells.entries(cell))
      expected[entry.element()] += sets * static_cast<double>(entry.mass) / static_cast<double>(cell_mass);
  for (std::uint64_t seed = 0; seed < sets; ++seed)
    for (const CellEntry& entry : net_of(cells, seed)) ++count[entry.element()];
  double chi_square = 0;
  for (std::size_t e = 0; e < points.size(); ++e)
    chi_square += (count[e] - expected[e]) * (count[e] - expected[e]) / expected[e];
  // 380 degrees of freedom: 4 standard deviations are 110.
  INFO("chi-square " << chi_square);
  CHECK(chi_square < 380 + 110);
  CHECK(chi_square > 380 - 110);
}

namespace {

// A thin stack of layers over a square, of so many points each, all facing up or down; over layers of the
// same side lie others of it.
struct Stack {
  std::vector<MassPoint> points;
  std::vector<float> normals;
  std::vector<std::uint32_t> triangle;
  void add_layer(std::uint32_t rows, float height, float up) {
    constexpr std::uint32_t side = 20;
    for (std::uint32_t i = 0; i < rows; ++i)
      for (std::uint32_t j = 0; j < side; ++j) {
        const auto place = [](std::uint32_t k, std::uint32_t of) {
          return (static_cast<float>(k) + 0.5f) / static_cast<float>(of);
        };
        points.push_back({{place(i, rows), 0.9f * place(j, side), height}, 1});
        triangle.push_back(static_cast<std::uint32_t>(triangle.size()));
        for (const float x : {0.0f, 0.0f, up}) normals.push_back(x);
      }
  }
};

}  // namespace

TEST_CASE("cell net: the first sample of the file is uniform, on sheets and for any number of samples",
          "[statistics]") {
  // The sheets' own digits and those of samples in their cells must not follow from each other, nor those of
  // halves that are sheets and of sheets that are none.
  const std::uint32_t n = GENERATE(64u, 85u, 96u);
  const int layers = GENERATE(2, 3, 4);
  // Release builds judge all pairs.
  if (sanitized && (layers == 2 ? n != 64 : layers == 3 ? n != 85 : n != 96)) return;
  Stack stack;
  if (layers == 2) {
    stack.add_layer(20, 0, -1);
    stack.add_layer(20, 0.01f, 1);
  } else if (layers == 3) {
    stack.add_layer(12, 0, -1);
    stack.add_layer(20, 0.01f, 1);
  } else {  // both sides weigh the same, their layers do not
    stack.add_layer(12, 0, -1);
    stack.add_layer(20, 0.004f, -1);
    stack.add_layer(12, 0.008f, 1);
    stack.add_layer(20, 0.012f, 1);
  }
  const BalancedCells cells = balanced_order(stack.points, n, {stack.triangle, {}, stack.normals, {}});
  const auto parted = std::count_if(cells.cut.begin(), cells.cut.end(),
                                    [](const TreeCut& cut) { return cut.axis == TreeCut::between_parts; });
  CHECK(parted >= (layers == 4 ? 3 : 1));
  constexpr int sets = 20000;
  std::vector<double> count(stack.points.size());
  for (std::uint64_t seed = 0; seed < sets; ++seed)
    ++count[net_of(cells, seed)[order_of(cells, seed)[0]].element()];
  const auto degrees = static_cast<double>(stack.points.size() - 1);
  const double expected = static_cast<double>(sets) / static_cast<double>(stack.points.size());
  double chi_square = 0;
  for (const double c : count) chi_square += (c - expected) * (c - expected) / expected;
  CAPTURE(n, layers, chi_square, degrees);
  CHECK(chi_square < degrees + 4 * std::sqrt(2 * degrees));
}

TEST_CASE("cell net: on a flat square every sample is equally often the first") {
  // The root of the tree is not cut in halves: samples are bisected. Chi-square, four standard deviations.
  for (const std::uint32_t n : {3u, 5u, 7u, 12u, 100u}) {
    const BalancedCells cells = balanced_order(square_grid(30), n);
    constexpr int sets = 6000;
    std::vector<int> first(n);
    for (std::uint64_t seed = 0; seed < sets; ++seed) ++first[order_of(cells, seed)[0]];
    double chi_square = 0;
    for (const int count : first) chi_square += std::pow(count - sets / static_cast<double>(n), 2) * n / sets;
    CAPTURE(n, chi_square);
    CHECK(chi_square < (n - 1) + 4 * std::sqrt(2.0 * (n - 1)));
  }
}

TEST_CASE("cell net: half of an odd number of samples covers all parts of a square evenly over many sets") {
  // Of 101 samples the larger half of a node lies on either side.
  constexpr std::uint32_t n = 101, prefix = 64;
  constexpr int sets = 2000;
  const BalancedCells cells = balanced_order(square_grid(60), n);
  std::array<double, 16> held{}, all{};
  for (std::uint64_t seed = 0; seed < sets; ++seed) {
    const std::vector<CellEntry> net = net_of(cells, seed);
    const std::vector<std::uint32_t> order = order_of(cells, seed);
    for (std::uint32_t i = 0; i < n; ++i) {
      const CellEntry& entry = net[order[i]];
      const auto part =
          static_cast<std::size_t>(entry.at[0] * 4) * 4 + static_cast<std::size_t>(entry.at[1] * 4);
      ++all[part];
      if (i < prefix) ++held[part];
    }
  }
  for (std::size_t part = 0; part < held.size(); ++part) {
    CAPTURE(part, held[part] / all[part]);
    CHECK(held[part] / all[part] == Approx(static_cast<double>(prefix) / n).margin(0.06));
  }
}

TEST_CASE("cell net: orders are permutations, for any number of samples") {
  for (const std::uint32_t n : {1u, 2u, 3u, 7u, 64u, 100u, 1000u, 1024u}) {
    std::vector<std::uint32_t> order = order_of(balanced_order(square_grid(100), n), n);
    REQUIRE(order.size() == n);
    std::sort(order.begin(), order.end());
    for (std::uint32_t r = 0; r < n; ++r) REQUIRE(order[r] == r);
  }
}

TEST_CASE("cell net: prefixes of powers of two have one sample in every node of the tree") {
  for (const std::uint32_t n : {2u, 64u, 1024u}) {
    const BalancedCells cells = balanced_order(square_grid(128), n);
    const std::vector<std::uint32_t> order = order_of(cells, n);
    for (std::uint32_t prefix = 1; prefix <= n; prefix *= 2) {
      std::set<std::uint32_t> nodes;
      for (std::uint32_t i = 0; i < prefix; ++i) nodes.insert(cells.cell[order[i]].leaf / (n / prefix));
      INFO("the first " << prefix << " of " << n);
      CHECK(nodes.size() == prefix);
    }
  }
}

TEST_CASE("cell net: power-of-two prefixes of other sets lie in equal parts of the surface") {
  // Of 4^j samples about one lies in each of as many small squares.
  for (const std::uint32_t n : {1000u, 1500u, 3000u}) {
    const BalancedCells cells = balanced_order(square_grid(256), n);
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const std::vector<CellEntry> net = net_of(cells, seed);
      const std::vector<std::uint32_t> order = order_of(cells, seed);
      for (const std::uint32_t side : {2u, 4u, 8u, 16u}) {
        std::vector<int> held(std::size_t{side} * side);
        for (std::uint32_t i = 0; i < side * side; ++i) {
          const CellEntry& entry = net[order[i]];
          const auto column = static_cast<std::uint32_t>(entry.at[0] * static_cast<float>(side)),
                     row = static_cast<std::uint32_t>(entry.at[1] * static_cast<float>(side));
          ++held[column * side + row];
        }
        const auto empty = std::count(held.begin(), held.end(), 0);
        INFO("the first " << side * side << " of " << n << ", seed " << seed << ": " << empty
                          << " squares are empty");
        // Of random points 37 % would be.
        CHECK(static_cast<double>(empty) <= 0.15 * side * side);
        CHECK(*std::max_element(held.begin(), held.end()) <= 3);
      }
    }
  }
}

TEST_CASE("cell net: every prefix is spread over the surface") {
  // Between powers of two a node of the level has one sample or two, and nodes with two are everywhere: of
  // any 16 nodes that follow each other in the tree as many as of all, but for a few.
  constexpr std::uint32_t n = 1024, level = 256;
  const BalancedCells cells = balanced_order(square_grid(128), n);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<std::uint32_t> order = order_of(cells, seed);
    for (std::uint32_t length = level; length <= n; length += 37) {
      std::array<int, 16> held{};
      for (std::uint32_t i = 0; i < length; ++i) ++held[cells.cell[order[i]].leaf / 64];
      for (const int count : held) CHECK(std::abs(count - length / 16.0) <= 1.0);
    }
  }
}

TEST_CASE("cell net: cells without extent, with one entry, and with massless entries") {
  std::vector<MassPoint> points(40, {{0.25f, 0.5f, -0.5f}, 1});
  for (std::size_t i = 0; i < points.size(); i += 2) points[i].mass = 0;
  for (const std::uint32_t n : {1u, 5u, 100u}) {
    const BalancedCells cells = balanced_order(points, n);
    for (std::uint64_t seed = 0; seed < 50; ++seed)
      for (const CellEntry& entry : net_of(cells, seed)) REQUIRE(entry.mass > 0);
    CHECK(order_of(cells, 1).size() == n);
  }
}
