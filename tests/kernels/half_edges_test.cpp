#include "kernels/mesh/half_edges.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "kernels/curve/curve_key.h"
#include "kernels/mesh/components.h"
#include "support/catch.h"

using namespace meander;

namespace {

std::uint32_t below(std::mt19937& random, std::uint32_t count) {
  return static_cast<std::uint32_t>(random() % count);
}

// Random triangles over few vertices: edges of one, two and more triangles in either direction. Vertex 0
// takes part in `hubs` of ten.
std::vector<std::uint32_t> random_triangles(std::mt19937& random, std::size_t count, std::uint32_t vertices,
                                            std::uint32_t hubs) {
  std::vector<std::uint32_t> triangles;
  while (triangles.size() < 3 * count) {
    const std::uint32_t a = below(random, 10) < hubs ? 0 : below(random, vertices),
                        b = below(random, vertices), c = below(random, vertices);
    if (a == b || b == c || c == a) continue;
    triangles.insert(triangles.end(), {a, b, c});
  }
  return triangles;
}

// A closed fan of `corners` triangles around vertex `center`, its rim from vertex `first` on.
void add_fan(std::uint32_t center, std::uint32_t first, std::uint32_t corners, bool closed,
             std::vector<std::uint32_t>& triangles) {
  for (std::uint32_t k = 0; k < corners; ++k)
    triangles.insert(triangles.end(),
                     {center, first + k, closed && k + 1 == corners ? first : first + k + 1});
}

void check_against_map(const std::vector<std::uint32_t>& triangles, std::uint32_t vertices) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> edges;
  for (std::uint32_t h = 0; h < triangles.size(); ++h)
    edges[std::minmax(triangles[h], triangles[next_half_edge(h)])].push_back(h);
  std::vector<std::uint32_t> expected(triangles.size(), no_index), opposite;
  std::uint32_t crowded = 0;
  bool consistent = true;
  for (const auto& [edge, sides] : edges) {
    crowded += sides.size() > 2;
    if (sides.size() != 2) continue;
    expected[sides[0]] = sides[1];
    expected[sides[1]] = sides[0];
    consistent = consistent && triangles[sides[0]] != triangles[sides[1]];
  }
  FanSurvey survey;
  CHECK(pair_half_edges(triangles, vertices, opposite, &survey) == crowded);
  CHECK(opposite == expected);
  CHECK(survey.consistent == consistent);
  CHECK(pair_half_edges(triangles, vertices, opposite) == crowded);
  CHECK(opposite == expected);
  // Joins of corners at a vertex across paired edges, whatever the winding.
  std::vector<std::uint32_t> fan(triangles.size());
  std::iota(fan.begin(), fan.end(), 0u);
  const auto corner_at = [&](std::uint32_t h, std::uint32_t v) {
    return triangles[h] == v ? h : next_half_edge(h);
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t h = 0; h < triangles.size(); ++h) {
      if (expected[h] == no_index) continue;
      for (const std::uint32_t v : {triangles[h], triangles[next_half_edge(h)]}) {
        std::uint32_t &one = fan[corner_at(h, v)], &other = fan[corner_at(expected[h], v)];
        changed = changed || one != other;
        one = other = std::min(one, other);
      }
    }
  }
  std::vector<std::set<std::uint32_t>> fans(vertices);
  for (std::uint32_t h = 0; h < triangles.size(); ++h) fans[triangles[h]].insert(fan[h]);
  std::vector<std::size_t> corners(vertices, 0);
  for (const std::uint32_t v : triangles) ++corners[v];
  for (std::uint32_t v = 0; v < vertices; ++v) {
    if (survey.one_fan[v]) CHECK(fans[v].size() <= 1);
    if (consistent && fans[v].size() <= 1 && corners[v] < 32) CHECK(survey.one_fan[v] == 1);
  }
}

}  // namespace

TEST_CASE("pair_half_edges: agrees with an edge map on random triangles, hubs and crowded edges") {
  std::mt19937 random(7);
  for (const std::uint32_t vertices : {4u, 6u, 12u, 40u, 200u})
    for (const std::size_t count : {1u, 3u, 9u, 30u, 100u, 300u})
      for (const std::uint32_t hubs : {0u, 2u, 10u})
        check_against_map(random_triangles(random, count, vertices, hubs), vertices);
}

TEST_CASE("pair_half_edges: tells one fan of any size from several") {
  for (std::uint32_t corners = 2; corners < 70; ++corners)
    for (const bool closed : {false, true}) {
      if (closed && corners < 3) continue;
      std::vector<std::uint32_t> triangles;
      add_fan(0, 1, corners, closed, triangles);
      check_against_map(triangles, 200);
      for (const std::uint32_t others : {1u, 3u, 4u, 5u}) {  // a second fan at the same vertex
        std::vector<std::uint32_t> both = triangles;
        add_fan(0, 100, others, others > 2 && closed, both);
        check_against_map(both, 200);
        std::rotate(both.begin(), both.begin() + 3, both.end());
        check_against_map(both, 200);
      }
      // One triangle turned round.
      std::swap(triangles[1], triangles[2]);
      check_against_map(triangles, 200);
    }
}

TEST_CASE("places_along_curve: sorts by the whole key, stable for ties") {
  std::mt19937 random(3);
  for (const std::size_t count : {1u, 2u, 50u, 1023u, 5000u}) {
    std::vector<CentroidSum> sums(count);
    std::vector<std::uint64_t> key;
    for (CentroidSum& sum : sums) {
      // Few places, each with neighbors that only the last bits of the key tell apart.
      const auto coordinate = [&] {
        return 0.25 * (below(random, 5) - 2.0) + 0x1p-20 * static_cast<double>(below(random, 4));
      };
      sum.add(1, {coordinate(), coordinate(), coordinate()});
      key.push_back(hilbert_key_3d(sum.centroid()));
    }
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
    const std::vector<std::uint32_t> place = places_along_curve(sums);
    bool same = place.size() == count;
    for (std::uint32_t i = 0; same && i < count; ++i) same = place[order[i]] == i;
    CHECK(same);
  }
}
