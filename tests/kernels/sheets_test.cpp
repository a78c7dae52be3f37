#include "kernels/rays/sheets.h"

#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "kernels/mesh/prepared_mesh.h"
#include "support/catch.h"

using namespace meander;

namespace {

// A strip of n triangles, each the neighbor of the next.
std::vector<std::uint32_t> strip(std::uint32_t n) {
  std::vector<std::uint32_t> opposite(3 * n, no_index);
  for (std::uint32_t t = 0; t + 1 < n; ++t) {
    opposite[3 * t + 1] = 3 * (t + 1);
    opposite[3 * (t + 1)] = 3 * t + 1;
  }
  return opposite;
}

}  // namespace

TEST_CASE("separate_sheets: without conflicts everything is sheet 0") {
  const std::vector<double> mass(10, 1.0);
  CHECK(separate_sheets(strip(10), mass, {}, {}) == std::vector<std::uint8_t>(10, 0));
  CHECK(separate_sheets({}, {}, {}, {}).empty());
}

TEST_CASE("separate_sheets: an overlapping end moves as a whole, the lighter one") {
  // triangles 0..2 lie over 7..9; 3..6 are free
  std::vector<double> mass(10, 1.0);
  mass[8] = 2;
  const std::vector<Conflict> conflicts = {{0, 9}, {1, 8}, {2, 7}, {1, 8}, {0, 8}};
  CHECK(separate_sheets(strip(10), mass, conflicts, {}) ==
        std::vector<std::uint8_t>{1, 1, 1, 0, 0, 0, 0, 0, 0, 0});
  SheetParameters heavy;
  heavy.min_mass = 3;  // the end weighs just 3
  CHECK(separate_sheets(strip(10), mass, conflicts, heavy) == std::vector<std::uint8_t>(10, 0));
}

TEST_CASE("separate_sheets: a coil of k turns takes k sheets, up to the limit") {
  constexpr std::uint32_t turn = 6;
  for (const std::uint32_t turns : {2u, 3u, 16u, 20u}) {
    const std::uint32_t n = turn * turns;
    std::vector<Conflict> conflicts;
    for (std::uint32_t a = 0; a < n; ++a)
      for (std::uint32_t b = a + turn; b < n; b += turn) conflicts.push_back({a, b});
    const std::vector<double> mass(n, 1.0);
    const std::vector<std::uint8_t> sheet = separate_sheets(strip(n), mass, conflicts, {});
    for (std::uint32_t t = 0; t < n; ++t) CHECK(sheet[t] == (t / turn < 16 ? t / turn : 0));
    SheetParameters three;
    three.max_sheets = 3;
    const std::vector<std::uint8_t> few = separate_sheets(strip(n), mass, conflicts, three);
    for (std::uint32_t t = 0; t < n; ++t) CHECK(few[t] == (t / turn < 3 ? t / turn : 0));
  }
}

TEST_CASE("separate_sheets: regions that do not conflict share a sheet") {
  // two overlaps far from each other: 0 over 2, and 10 over 12
  std::vector<double> mass(13, 1.0);
  mass[2] = mass[12] = 5;
  const std::vector<std::uint8_t> sheet =
      separate_sheets(strip(13), mass, std::vector<Conflict>{{0, 2}, {10, 12}}, {});
  std::vector<std::uint8_t> expected(13, 0);
  expected[0] = expected[10] = 1;
  CHECK(sheet == expected);
}

TEST_CASE("ConflictSet: holds each pair once, in order, however often it is added") {
  std::mt19937 random(3);
  std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
  ConflictSet set(300);
  for (int i = 0; i < 200000; ++i) {
    const std::uint32_t a = random() % 300, b = random() % 300;
    if (a == b) continue;
    set.add(a, b);
    expected.insert(std::minmax(a, b));
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
  for (const Conflict c : set.take()) found.emplace_back(c.first, c.second);
  CHECK(found.size() > 40000);
  CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
  CHECK(set.take().empty());
}

TEST_CASE("ConflictSet: holds at most the allowed number for a chart that overlaps itself everywhere") {
  constexpr std::uint32_t triangles = 3000;
  ConflictSet set(triangles);
  for (std::uint32_t a = 0; a < triangles; ++a)
    for (std::uint32_t b = a + 1; b < triangles; b += 3) set.add(a, b);
  const std::size_t found = set.take().size();
  CHECK(found > most_conflicts(triangles) / 2);
  CHECK(found <= most_conflicts(triangles));
}
