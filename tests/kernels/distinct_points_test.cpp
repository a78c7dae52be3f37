#include "kernels/sample/distinct_points.h"

#include <cmath>
#include <set>

#include "support/catch.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

using Point = std::array<float, 3>;

// Points of a lattice with `places` places, by rank and counter: the fewer places, the more points are equal.
struct LatticePoints {
  std::uint32_t places;
  Point at(std::uint32_t rank, std::uint32_t counter) const {
    std::uint64_t word = (std::uint64_t{rank} << 32 | counter) * 0x9E3779B97F4A7C15u;
    word = (word ^ (word >> 31)) * 0xBF58476D1CE4E5B9u;
    const auto place = static_cast<std::uint32_t>((word >> 33) % places);
    return {static_cast<float>(place % 64), static_cast<float>(place / 64), 1};
  }
};

constexpr int redraws = 8;

// One rank after the other, against all points before it.
Redraws by_turns(std::uint32_t count, const LatticePoints& points) {
  Redraws result;
  std::set<Point> taken;
  std::uint32_t limit = redraws;
  for (std::uint32_t rank = 0; rank < count; ++rank) {
    if (taken.insert(points.at(rank, 0)).second) continue;
    bool distinct = false;
    std::uint32_t counter = 0;
    while (!distinct && counter < limit) distinct = taken.insert(points.at(rank, ++counter)).second;
    result.redraw.push_back({rank, counter});
    if (!distinct) ++result.coincident;
    limit = distinct ? redraws : std::max(1u, limit / 2);
  }
  return result;
}

Redraws at_once(std::uint32_t count, const LatticePoints& points) {
  return find_redraws(
      count, [&](std::uint32_t rank) { return points.at(rank, 0); }, [](std::uint32_t) { return 1u; },
      [&](std::uint32_t rank, std::uint32_t counter) {
        return DrawnPoint{points.at(rank, counter), counter + 1};
      },
      redraws, {});
}

}  // namespace

TEST_CASE("find_redraws: the redraws of comparing points one after the other") {
  for (const std::uint32_t count : {1u, 2u, 100u, 3000u, 20000u})
    // From fewer places than points, where most redraws fail, to places enough.
    for (const double places_per_point : {0.01, 0.5, 1.0, 1.5, 4.0, 1000.0}) {
      const LatticePoints points{
          static_cast<std::uint32_t>(std::max(1.0, std::ceil(places_per_point * count)))};
      const Redraws expected = by_turns(count, points), found = at_once(count, points);
      INFO(count << " points at " << points.places << " places");
      CHECK(found.redraw == expected.redraw);
      CHECK(found.coincident == expected.coincident);
    }
}

TEST_CASE("find_redraws: a redrawn point displaces a higher rank from its first position") {
  // Rank 1 is where rank 0 is, and moves to where rank 2 is, which moves on; rank 3 then finds rank 2 there.
  const float place[4][3] = {{1, 0, 0}, {1, 2, 0}, {2, 3, 0}, {3, 4, 0}};
  const Redraws found = find_redraws(
      4,
      [&](std::uint32_t rank) {
        return Point{place[rank][0], 0, 0};
      },
      [](std::uint32_t) { return 1u; },
      [&](std::uint32_t rank, std::uint32_t counter) {
        return DrawnPoint{{place[rank][counter], 0, 0}, counter + 1};
      },
      1, {});
  CHECK(found.redraw == std::vector<Redraw>{{1, 1}, {2, 1}, {3, 1}});
  CHECK(found.coincident == 0);
}

TEST_CASE("find_redraws: the same for 1, 2 and 8 threads, and nothing if all points differ") {
  constexpr std::uint32_t count = 300000;
  const LatticePoints points{count / 2 * 3};
  Redraws first;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const Redraws found = on_threads(threads, [&] { return at_once(count, points); });
    if (threads == 1) first = found;
    CHECK(found.redraw == first.redraw);
  }
  CHECK(first.redraw.size() > count / 10);
  const Redraws none = find_redraws(
      count,
      [](std::uint32_t rank) {
        return Point{static_cast<float>(rank), 0, 0};
      },
      [](std::uint32_t) { return 1u; },
      [](std::uint32_t, std::uint32_t counter) {
        return DrawnPoint{{}, counter + 1};
      },
      1, {});
  CHECK(none.redraw.empty());
}
