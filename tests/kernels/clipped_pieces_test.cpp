// Triangles clipped by planes: masses on both sides, nothing lost, points of cross-sections distributed by
// mass, and faces that a plane cannot part.
#include "kernels/partition/clipped_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/partition/balanced_order.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

namespace {

constexpr RandomKey soup_key{{5, 23}};
using Corners = std::array<Vector3, 3>;

double area_of_triangle(const Corners& t) { return triangle_area(t[0], t[1], t[2]); }

// The square from (x, y) with sides s at height z, as two triangles.
std::vector<Corners> square_at(double x, double y, double side, double z) {
  const Vector3 a{x, y, z}, b{x + side, y, z}, c{x + side, y + side, z}, d{x, y + side, z};
  return {{a, b, c}, {a, c, d}};
}

// Triangles of very different size in the cube [0, 1]^3.
std::vector<Corners> triangle_soup(std::uint32_t count) {
  std::vector<Corners> soup;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double size = std::exp2(-8 * random_pair(soup_key, Stream::test_shapes, i, 9).first);
    const UnitPair xy = random_pair(soup_key, Stream::test_shapes, i),
                   z = random_pair(soup_key, Stream::test_shapes, i, 1);
    Corners t;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const UnitPair u = random_pair(soup_key, Stream::test_shapes, i, 2 + 2 * k),
                     v = random_pair(soup_key, Stream::test_shapes, i, 3 + 2 * k);
      t[k] = {(1 - size) * xy.first + size * u.first, (1 - size) * xy.second + size * u.second,
              (1 - size) * z.first + size * v.first};
    }
    soup.push_back(t);
  }
  return soup;
}

// With room for the polygons of many nodes at once.
ClippedPieces pieces_of(const std::vector<Corners>& triangles) {
  ClippedPieces pieces;
  pieces.begin({0.5, 0.5, 0.5}, 64 * triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    pieces.add(triangles[i], area_of_triangle(triangles[i]), i);
  return pieces;
}

std::vector<MassPoint> elements_of(const std::vector<Corners>& triangles) {
  std::vector<MassPoint> elements;
  for (const Corners& t : triangles) {
    const Vector3 c = (1.0 / 3) * (t[0] + t[1] + t[2]);
    elements.push_back(
        {{static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)}, area_of_triangle(t)});
  }
  return elements;
}

// The cells of triangles and their points.
BalancedCells cells_of_triangles(const std::vector<Corners>& triangles, std::uint32_t n, std::uint64_t seed) {
  const ExactTriangles net{[&](std::uint32_t e) { return triangles[e]; }, make_random_key(seed, {})};
  return exact_order(elements_of(triangles), n, {}, net).value();
}

// The cells and the polygons that they are made of, at most so many.
BalancedCells polygons_of_triangles(const std::vector<Corners>& triangles, std::uint32_t n,
                                    std::uint64_t most) {
  const ExactTriangles exact{[&](std::uint32_t e) { return triangles[e]; }, {}, 0, most};
  return exact_order(elements_of(triangles), n, {}, exact).value_or(BalancedCells());
}

double area_of_polygon(std::span<const std::array<float, 2>> corner) {
  double twice = 0;
  for (std::size_t k = 0; k < corner.size(); ++k) {
    const std::array<float, 2>&a = corner[k], &b = corner[(k + 1) % corner.size()];
    twice += double(a[0]) * double(b[1]) - double(b[0]) * double(a[1]);
  }
  return std::abs(twice) / 2;
}

Vector3 place_of_point(const std::vector<Corners>& triangles, const CellPoint& point) {
  const Corners& t = triangles[point.name];
  const double first = point.first, second = point.second;
  return t[0] + first * (t[1] - t[0]) + second * (t[2] - t[0]);
}

}  // namespace

TEST_CASE("clipped pieces: a plane splits a square at the requested share") {
  for (const double share : {0.1, 0.25, 0.5, 0.9}) {
    ClippedPieces pieces = pieces_of(square_at(0, 0, 1, 0));
    const ClippedPieces::Extent whole = pieces.extent_of(pieces.all());
    CHECK(whole.mass == Approx(1));
    const auto [low, high] = pieces.cut(pieces.all(), whole, share, 1);
    const ClippedPieces::Extent lower = pieces.extent_of(low), upper = pieces.extent_of(high);
    INFO(share);
    CHECK(lower.mass == Approx(share).margin(0x1p-14));
    CHECK(lower.mass + upper.mass == Approx(1));
    const std::size_t axis = whole.axis;
    CHECK(axis < 2);
    // Along the axis each side is as long as its mass, but for the rotation of a few thousandths.
    CHECK(double(lower.high[axis] - lower.low[axis]) == Approx(share).margin(0.01));
    CHECK(double(upper.low[axis]) == Approx(double(lower.high[axis])).margin(1e-6));
  }
}

TEST_CASE("clipped pieces: repeated cuts do not overlap and lose nothing") {
  ClippedPieces pieces = pieces_of(triangle_soup(300));
  struct Part {
    ClippedPieces::List list;
    int depth;
  };
  std::vector<Part> open{{pieces.all(), 0}};
  const double total = pieces.extent_of(pieces.all()).mass, cell = total / 256;
  double sum = 0;
  while (!open.empty()) {
    const Part part = open.back();
    open.pop_back();
    const ClippedPieces::Extent extent = pieces.extent_of(part.list);
    if (part.depth == 8) {
      CHECK(extent.mass == Approx(cell).epsilon(8 * 0x1p-14));
      sum += extent.mass;
      continue;
    }
    const auto [low, high] = pieces.cut(part.list, extent, extent.mass / 2, cell);
    const ClippedPieces::Extent lower = pieces.extent_of(low), upper = pieces.extent_of(high);
    CHECK(lower.mass == Approx(extent.mass / 2).margin(cell * 0x1p-14));
    CHECK(lower.high[extent.axis] <= upper.low[extent.axis] + 1e-5f);
    open.push_back({low, part.depth + 1});
    open.push_back({high, part.depth + 1});
  }
  CHECK(sum == Approx(total));
}

TEST_CASE("clipped pieces: points of cross-sections are distributed by mass") {
  // A grid of shares: every triangle gets its part of the points, and these lie around its centroid.
  const std::vector<Corners> soup = triangle_soup(12);
  constexpr std::uint32_t side = 400;
  ClippedPieces pieces = pieces_of(soup);
  const ClippedPieces::Extent extent = pieces.extent_of(pieces.all());
  std::vector<double> count(soup.size()), first(soup.size()), second(soup.size());
  for (std::uint32_t i = 0; i < side; ++i) {
    pieces.cross(pieces.all(), extent, (i + 0.5) / side);
    for (std::uint32_t j = 0; j < side; ++j) {
      const CellPoint point = pieces.point((j + 0.5) / side, 0.5);
      const double u = point.first, v = point.second;
      CHECK((u >= -1e-6 && v >= -1e-6 && u + v <= 1 + 1e-6));
      count[point.name] += 1;
      first[point.name] += u;
      second[point.name] += v;
    }
  }
  for (std::size_t t = 0; t < soup.size(); ++t) {
    const double share = area_of_triangle(soup[t]) / extent.mass;
    INFO("triangle " << t << " of share " << share);
    CHECK(count[t] / (side * side) == Approx(share).margin(2e-4));
    if (share < 0.01) continue;
    CHECK(first[t] / count[t] == Approx(1.0 / 3).margin(0.01));
    CHECK(second[t] / count[t] == Approx(1.0 / 3).margin(0.01));
  }
}

TEST_CASE("clipped pieces: a riser between two steps gets its share of cross-section points") {
  // Faces across the longest extent, that the plane may jump over.
  for (const double height : {0.3, 0.04, 0.01}) {
    std::vector<Corners> stair;
    const auto rectangle = [&](const Vector3& corner, const Vector3& u, const Vector3& v) {
      stair.push_back({corner, corner + u, corner + v});
      stair.push_back({corner + u + v, corner + u, corner + v});
    };
    rectangle({0, 0, 0}, {0.5, 0, 0}, {0, 0.8, 0});
    rectangle({0.5, 0, height}, {0.5, 0, 0}, {0, 0.8, 0});
    rectangle({0.5, 0, 0}, {0, 0, height}, {0, 0.8, 0});
    ClippedPieces pieces = pieces_of(stair);
    const ClippedPieces::Extent extent = pieces.extent_of(pieces.all());
    REQUIRE(extent.axis == 0);
    constexpr int shares = 20000;
    double risers = 0;
    for (int i = 0; i < shares; ++i) {
      pieces.cross(pieces.all(), extent, (i + 0.5) / shares);
      const double turns = 0.6180339887498949 * i;  // next to the riser a section meets a step as well
      if (pieces.point(turns - std::floor(turns), 0.5).name >= 4) risers += 1;
    }
    CAPTURE(height);
    CHECK(risers / shares == Approx(height / (1 + height)).margin(0x1p-11));
  }
}

TEST_CASE("clipped pieces: faces across the axis are cut along it like others") {
  // The long sides of a bar along x, and its ends: the middle cut of three cells falls into an end.
  std::vector<Corners> bar;
  const auto end_at = [&](double x, double side) {
    bar.push_back({Vector3{x, 0, 0}, Vector3{x, side, 0}, Vector3{x, 0, side}});
    bar.push_back({Vector3{x, side, side}, Vector3{x, side, 0}, Vector3{x, 0, side}});
  };
  end_at(0, 0.3);
  end_at(1, 0.1);
  ClippedPieces pieces = pieces_of(bar);
  const ClippedPieces::Extent extent = pieces.extent_of(pieces.all());
  REQUIRE(extent.axis == 0);
  const auto [low, high] = pieces.cut(pieces.all(), extent, extent.mass / 2, extent.mass / 2);
  const ClippedPieces::Extent lower = pieces.extent_of(low);
  CHECK(lower.mass == Approx(extent.mass / 2).epsilon(0x1p-13));
  // Half of all is five ninths of the large end: a strip or a corner of it, not all of it thinned out.
  const double lengths[2] = {double(lower.high[1] - lower.low[1]), double(lower.high[2] - lower.low[2])};
  INFO(lengths[0] << " x " << lengths[1]);
  CHECK(lengths[0] * lengths[1] < 0.99 * 0.3 * 0.3);
}

TEST_CASE("clipped pieces: coincident polygons share points by mass") {
  std::vector<Corners> same(7, Corners{Vector3{0, 0, 0}, Vector3{1e-12, 0, 0}, Vector3{0, 1e-12, 0}});
  ClippedPieces pieces;
  pieces.begin({0, 0, 0}, same.size());
  for (std::uint32_t i = 0; i < same.size(); ++i) pieces.add(same[i], 1, i);
  pieces.add(same[0], 0, 99);  // without mass: not there
  CHECK(pieces.all().count == 7);
  const ClippedPieces::Extent extent = pieces.extent_of(pieces.all());
  const auto [low, high] = pieces.cut(pieces.all(), extent, 2.5, 1);
  CHECK(pieces.extent_of(low).mass == Approx(2.5).margin(0x1p-13));
  CHECK(pieces.extent_of(high).mass == Approx(4.5).margin(0x1p-13));
  const ClippedPieces::Extent lower = pieces.extent_of(low);
  pieces.cross(low, lower, 0.7);
  CHECK(pieces.point(0.4, 0.3).name < 7);
}

TEST_CASE("clipped pieces: one sample in every elementary interval of two triangles") {
  const std::vector<Corners> square = square_at(-0.5, -0.5, 1, 0);
  for (const std::uint32_t k : {2u, 3u, 4u}) {
    const std::uint32_t side = 1u << k, n = side * side;
    const BalancedCells cells = cells_of_triangles(square, n, k);
    REQUIRE(cells.point.size() == n);
    // The square is turned by some thousandths: a row of points at a border is given to either side.
    std::vector<int> interval(n);
    for (const CellPoint& point : cells.point) {
      const Vector3 at = place_of_point(square, point);
      const auto x = static_cast<std::size_t>((at.x + 0.5) * side),
                 y = static_cast<std::size_t>((at.y + 0.5) * side);
      ++interval[std::min<std::size_t>(x, side - 1) * side + std::min<std::size_t>(y, side - 1)];
    }
    const auto empty = std::count(interval.begin(), interval.end(), 0);
    INFO(n);
    CHECK(empty <= static_cast<std::ptrdiff_t>(n / 10));
  }
}

TEST_CASE("clipped pieces: cells of two triangles stay compact in large sets") {
  // Samples of neighboring cells along the path lie about a cell's width apart; slabs would be far longer.
  const std::vector<Corners> square = square_at(-0.5, -0.5, 1, 0);
  constexpr std::uint32_t n = 65536;
  const BalancedCells cells = polygons_of_triangles(square, n, 1u << 20);
  std::vector<std::array<double, 2>> center;  // of the mass
  for (const Cell& cell : cells.cell) {
    std::array<double, 2> moment{};
    double mass = 0;
    for (const CellEntry& entry : cells.entries(cell)) {
      const double m = cells.mass(entry);
      for (std::size_t k = 0; k < 2; ++k) moment[k] += m * static_cast<double>(entry.at[k]);
      mass += m;
    }
    center.push_back({moment[0] / mass, moment[1] / mass});
  }
  std::uint32_t far = 0;
  for (std::size_t c = 1; c < n; ++c) {
    const auto &a = center[c - 1], &b = center[c];
    far += std::hypot(a[0] - b[0], a[1] - b[1]) * 256 > 2.5;
  }
  CHECK(far <= n / 500);
  // Of the centers of square cells the distances from a lattice are small; those of slabs are not.
  std::uint32_t off = 0;
  for (const std::array<double, 2>& place : center)
    for (const double coordinate : place) {
      const double at = (coordinate + 0.5) * 256 - 0.5;
      off += std::abs(at - std::round(at)) > 0.45;
    }
  CHECK(off <= n / 20);
}

TEST_CASE("clipped pieces: over many seeds every triangle gets its share of cell points") {
  const std::vector<Corners> soup = triangle_soup(40);
  constexpr std::uint32_t n = 37;
  constexpr int seeds = 2000;
  double total = 0;
  for (const Corners& t : soup) total += area_of_triangle(t);
  std::vector<double> count(soup.size());
  for (int seed = 1; seed <= seeds; ++seed)
    for (const CellPoint& point : cells_of_triangles(soup, n, static_cast<std::uint64_t>(seed)).point)
      count[point.name] += 1;
  for (std::size_t t = 0; t < soup.size(); ++t) {
    const double expected = seeds * n * area_of_triangle(soup[t]) / total;
    INFO("triangle " << t);
    // At most Poisson's variance: five standard deviations.
    CHECK(std::abs(count[t] - expected) <= 5 * std::sqrt(expected) + 1);
  }
}

TEST_CASE("clipped pieces: cells and points are the same for 1, 2 and 8 threads") {
  const std::vector<Corners> soup = triangle_soup(3000);
  std::vector<std::tuple<std::uint32_t, std::uint32_t, float, float>> expected;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const BalancedCells cells = test::on_threads(threads, [&] { return cells_of_triangles(soup, 20000, 3); });
    std::vector<std::tuple<std::uint32_t, std::uint32_t, float, float>> found;
    for (std::size_t c = 0; c < cells.cell.size(); ++c)
      found.emplace_back(cells.cell[c].leaf, cells.point[c].name, cells.point[c].first,
                         cells.point[c].second);
    if (expected.empty()) expected = found;
    CHECK(found == expected);
  }
}

TEST_CASE("clipped pieces: the polygons kept by cells tile the triangles, and weigh their area") {
  const std::vector<Corners> soup = triangle_soup(300);
  double total = 0;
  for (const Corners& t : soup) total += area_of_triangle(t);
  for (const std::uint32_t n : {1u, 100u, 5000u}) {
    const BalancedCells cells = polygons_of_triangles(soup, n, 1u << 20);
    REQUIRE(cells.cell.size() == n);
    CHECK(cells.point.empty());
    std::vector<double> share(soup.size());
    double moved = 0;  // what cuts have given to the other side as it is, without parting the polygon
    for (const Cell& cell : cells.cell) {
      double mass = 0;
      const std::span<const CellEntry> entries = cells.entries(cell);
      REQUIRE(!entries.empty());
      for (std::size_t i = 0; i < entries.size(); ++i) {
        const std::uint32_t t = entries[i].element();
        const auto polygon = cells.polygon[cell.block][cell.first + i];
        REQUIRE(polygon.size() >= 3);
        share[t] += cells.mass(entries[i]);
        mass += cells.mass(entries[i]);
        moved += std::abs(cells.mass(entries[i]) - 2 * area_of_polygon(polygon) * area_of_triangle(soup[t]));
        Vector3 mean;
        for (const std::array<float, 2>& w : polygon)
          mean = mean +
                 (1.0 / static_cast<double>(polygon.size())) * place_of_point(soup, CellPoint{t, w[0], w[1]});
        for (std::size_t k = 0; k < 3; ++k)
          CHECK(double(entries[i].at[k]) == Approx(k == 0 ? mean.x : k == 1 ? mean.y : mean.z).margin(1e-5));
      }
      CHECK(mass == Approx(total / n).epsilon(0x1p-11));
    }
    CHECK(moved <= 1e-3 * total);
    for (std::size_t t = 0; t < soup.size(); ++t)
      CHECK(share[t] == Approx(area_of_triangle(soup[t])).epsilon(1e-6).margin(1e-9 * total));
  }
}

TEST_CASE("clipped pieces: above the limit of polygons there are no cells") {
  const std::vector<Corners> soup = triangle_soup(300);
  const BalancedCells cells = polygons_of_triangles(soup, 1000, 1u << 20);
  std::size_t count = 0;
  for (const Cell& cell : cells.cell) count += cell.entries;
  CHECK(polygons_of_triangles(soup, 1000, count).cell.size() == 1000);
  CHECK(polygons_of_triangles(soup, 1000, count - 1).cell.empty());
  // Nodes of many cells are cut by several threads.
  const BalancedCells many = polygons_of_triangles(soup, 20000, 1u << 24);
  count = 0;
  for (const Cell& cell : many.cell) count += cell.entries;
  for (const std::size_t threads : {1u, 8u}) {
    const auto cells_with = [&](std::uint64_t most) {
      return test::on_threads(threads, [&] { return polygons_of_triangles(soup, 20000, most); }).cell.size();
    };
    CHECK(cells_with(count) == 20000);
    CHECK(cells_with(count - 1) == 0);
  }
}

TEST_CASE("clipped pieces: cells of needles without stored polygons weigh the same") {
  std::vector<Corners> needles;
  double total = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const UnitPair from = random_pair(soup_key, Stream::test_shapes, i),
                   to = random_pair(soup_key, Stream::test_shapes, i, 1),
                   z = random_pair(soup_key, Stream::test_shapes, i, 2);
    needles.push_back({Vector3{from.first, from.second, z.first}, Vector3{to.first, to.second, z.second},
                       Vector3{to.first + 1e-3, to.second, z.second + 1e-3}});
    total += area_of_triangle(needles.back());
  }
  const BalancedCells cells = polygons_of_triangles(needles, 3000, 1u << 24);
  REQUIRE(cells.cell.size() == 3000);
  std::size_t alone = 0;
  for (const Cell& cell : cells.cell) {
    double mass = 0;
    for (const CellEntry& entry : cells.entries(cell)) mass += cells.mass(entry);
    CHECK(mass == Approx(total / 3000).epsilon(0x1p-10));
    alone += cell.entries == 1;
  }
  CHECK(alone < 300);
}

TEST_CASE("clipped pieces: polygons of cells are the same for 1, 2 and 8 threads") {
  const std::vector<Corners> soup = triangle_soup(3000);
  std::vector<std::tuple<std::uint32_t, std::uint64_t, float, float>> expected;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const BalancedCells cells =
        test::on_threads(threads, [&] { return polygons_of_triangles(soup, 20000, 1u << 24); });
    REQUIRE(cells.cell.size() == 20000);
    std::vector<std::tuple<std::uint32_t, std::uint64_t, float, float>> found;
    for (const Cell& cell : cells.cell)
      for (std::size_t i = 0; i < cell.entries; ++i)
        for (const std::array<float, 2>& corner : cells.polygon[cell.block][cell.first + i])
          found.emplace_back(cells.entries(cell)[i].name, cells.entries(cell)[i].mass, corner[0], corner[1]);
    if (expected.empty()) expected = found;
    CHECK(found == expected);
  }
}

TEST_CASE("clipped pieces: net points of elements with splits or groups are refused") {
  const std::vector<MassPoint> elements{{{0, 0, 0}, 1}};
  const std::vector<std::uint32_t> number = {0};
  const std::vector<ElementSplit> split(1);
  const ExactTriangles net{[](std::uint32_t) { return Corners{}; }, {}, 0};
  ElementTraits traits;
  traits.splits = {number, split};
  CHECK_THROWS_AS(exact_order(elements, 1, traits, net), std::invalid_argument);
}
