#include "kernels/mesh/clip_ears.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "support/catch.h"
#include "support/sanitized.h"

using namespace meander;
using meander::test::sanitized;

namespace {

// The definition: every corner tested in turn against all others.
std::vector<std::uint32_t> clipped_slowly(const std::vector<PlanePoint>& p) {
  const auto inside = [](PlanePoint q, PlanePoint a, PlanePoint b, PlanePoint c) {
    return turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0;
  };
  const auto same = [](PlanePoint a, PlanePoint b) { return a.x == b.x && a.y == b.y; };
  std::vector<std::uint32_t> ring(p.size()), triangles;
  for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = static_cast<std::uint32_t>(i);
  const auto is_ear = [&](std::size_t i) {
    const std::size_t n = ring.size();
    const PlanePoint a = p[ring[(i + n - 1) % n]], b = p[ring[i]], c = p[ring[(i + 1) % n]];
    if (turn(a, b, c) <= 0) return false;
    for (std::size_t j = 0; j < n; ++j) {
      const PlanePoint q = p[ring[j]];
      if (same(q, a) || same(q, b) || same(q, c)) continue;
      if (turn(p[ring[(j + n - 1) % n]], q, p[ring[(j + 1) % n]]) > 0) continue;
      if (inside(q, a, b, c)) return false;
    }
    return true;
  };
  std::size_t i = 0, misses = 0;
  while (ring.size() > 3 && misses < ring.size()) {
    const std::size_t n = ring.size();
    i %= n;
    if (!is_ear(i)) {
      ++i;
      ++misses;
      continue;
    }
    triangles.insert(triangles.end(), {ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
    ++i;
    misses = 0;
  }
  for (std::size_t k = 1; k + 1 < ring.size(); ++k)
    triangles.insert(triangles.end(), {ring[0], ring[k], ring[k + 1]});
  return triangles;
}

std::vector<std::uint32_t> clipped(const std::vector<PlanePoint>& p) {
  std::vector<std::uint32_t> triangles;
  clip_ears(p, triangles);
  return triangles;
}

double area_of(const std::vector<PlanePoint>& p) {
  double twice = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const PlanePoint a = p[i], b = p[(i + 1) % p.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return twice / 2;
}

// A star with rays of random length, turned by a random angle.
std::vector<PlanePoint> star(std::size_t corners, std::mt19937& random) {
  std::uniform_real_distribution<double> length(0.3, 1.0), angle(0, 1);
  const double from = angle(random);
  std::vector<PlanePoint> p;
  for (std::size_t i = 0; i < corners; ++i) {
    const double r = length(random),
                 at = 2 * std::numbers::pi * (static_cast<double>(i) / static_cast<double>(corners) + from);
    p.push_back({r * std::cos(at), r * std::sin(at)});
  }
  return p;
}

// A band that winds round the origin: its only ears are at its two ends.
std::vector<PlanePoint> spiral(std::size_t corners) {
  std::vector<PlanePoint> p;
  const auto place = [&](std::size_t i, double width) {
    const double at = 1 + 40 * static_cast<double>(i) / static_cast<double>(corners / 2);
    p.push_back({(at + width) * std::cos(at), (at + width) * std::sin(at)});
  };
  for (std::size_t i = 0; i < corners / 2; ++i) place(i, 1.5);
  for (std::size_t i = corners / 2; i-- > 0;) place(i, 0);
  return p;
}

}  // namespace

TEST_CASE("clip_ears: the triangles of testing every corner against all others") {
  std::mt19937 random(5);
  std::vector<std::vector<PlanePoint>> polygons;
  for (const std::size_t corners : {4u, 7u, 31u, 32u, 33u, 64u, 65u, 200u})
    for (int k = 0; k < 8; ++k) polygons.push_back(star(corners, random));
  polygons.push_back(spiral(60));
  polygons.push_back(spiral(300));
  // They cross themselves, have corners in one place and straight ones, and are left without ears.
  for (const int side : {2, 3, 6, 20, 1000})
    for (const std::size_t corners : {3u, 4u, 5u, 9u, 20u, 40u, 70u, 150u})
      for (int k = 0; k < (sanitized ? 3 : 20); ++k) {
        std::uniform_int_distribution<int> coordinate(0, side);
        std::vector<PlanePoint> p(corners);
        for (PlanePoint& q : p) q = {double(coordinate(random)), double(coordinate(random))};
        polygons.push_back(p);
      }
  std::size_t fanned = 0;
  for (const std::vector<PlanePoint>& p : polygons) {
    const std::vector<std::uint32_t> expected = clipped_slowly(p);
    INFO(p.size() << " corners");
    REQUIRE(expected.size() == 3 * (p.size() - 2));
    REQUIRE(clipped(p) == expected);
    fanned += expected[expected.size() - 3] == 0 && p.size() > 4;
  }
  CHECK(fanned > 10);
}

TEST_CASE("clip_ears: large outlines are covered once, without quadratic memory") {
  // Tests of all corners against all others would take hours.
  constexpr std::size_t corners = sanitized ? 20000 : 200000;
  std::mt19937 random(7);
  for (const std::vector<PlanePoint>& p : {star(corners, random), spiral(corners)}) {
    const std::vector<std::uint32_t> triangles = clipped(p);
    REQUIRE(triangles.size() == 3 * (corners - 2));
    double area = 0;
    bool all_left = true;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      const double twice = turn(p[triangles[t]], p[triangles[t + 1]], p[triangles[t + 2]]);
      all_left = all_left && twice >= 0;
      area += twice / 2;
    }
    CHECK(all_left);
    CHECK(area == Approx(area_of(p)).epsilon(1e-9));
  }
}

TEST_CASE("clip_ears: an expired deadline is noticed while corners are tested") {
  std::mt19937 random(9);
  CancelToken late;
  late.deadline = std::chrono::steady_clock::now();
  std::vector<std::uint32_t> triangles;
  CHECK_THROWS_AS(clip_ears(star(5000, random), triangles, late), ItemError);
}
