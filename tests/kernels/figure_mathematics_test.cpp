// What the figures of histograms compare with: known histograms, areas of lifted triangles, nearest points.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "kernels/analyse/distance_shares.h"
#include "kernels/analyse/histogram_error.h"
#include "kernels/analyse/lifted_area.h"
#include "kernels/analyse/nearest_points.h"
#include "kernels/core/random.h"
#include "kernels/describe/distance_histogram.h"
#include "kernels/sample/curved_samples.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr std::uint32_t bins = 32;
constexpr double full_turn = 2 * std::numbers::pi;

double lifted_area(const PolygonMesh& mesh) {
  const auto triangles = triangles_of(mesh);
  const auto areas =
      lifted_areas(mesh.x, mesh.y, mesh.z, triangles, crease_normals(mesh.x, mesh.y, mesh.z, triangles));
  return std::accumulate(areas.begin(), areas.end(), 0.0);
}

}  // namespace

TEST_CASE("sphere_distance_shares: match random points of the sphere") {
  const std::vector<double> shares = sphere_distance_shares(bins);
  REQUIRE(shares.size() == bins);
  CHECK(std::accumulate(shares.begin(), shares.end(), 0.0) == Approx(1));
  std::vector<float> points;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const UnitPair u = random_pair({}, Stream::point_set, i);
    const double z = 2 * u.first - 1, r = std::sqrt(1 - z * z), turn = full_turn * u.second;
    for (const double c : {r * std::cos(turn), r * std::sin(turn), z})
      points.push_back(static_cast<float>(c));
  }
  DistanceHistogramParameters histogram;
  histogram.bins = bins;
  histogram.range = 2;
  CHECK(histogram_error(distance_histogram(points, histogram).shares, shares).relative < 0.01);
}

TEST_CASE("torus_distance_shares: match random points of the torus, and a thin tube is a circle") {
  constexpr double tube = 0.5;
  const std::vector<double> shares = torus_distance_shares(bins, tube);
  CHECK(std::accumulate(shares.begin(), shares.end(), 0.0) == Approx(1));
  std::vector<float> points;
  for (std::uint32_t i = 0; points.size() < 3 * 4000; ++i) {
    const UnitPair u = random_pair({}, Stream::point_set, 2 * i),
                   v = random_pair({}, Stream::point_set, 2 * i + 1);
    const double r = 1 + tube * std::cos(full_turn * u.first), turn = full_turn * u.second;
    if (v.first * (1 + tube) > r) continue;  // density in proportion to the radius
    for (const double c : {r * std::cos(turn), r * std::sin(turn), tube * std::sin(full_turn * u.first)})
      points.push_back(static_cast<float>(c));
  }
  DistanceHistogramParameters histogram;
  histogram.bins = bins;
  histogram.range = 2 + 2 * tube;
  CHECK(histogram_error(distance_histogram(points, histogram).shares, shares).relative < 0.02);

  // A chord of the unit circle is shorter than d with probability 2 asin(d / 2) / pi.
  const std::vector<double> thin = torus_distance_shares(8, 1e-6);
  double below = 0;
  for (std::size_t b = 0; b + 1 < thin.size(); ++b) {
    below += thin[b];
    CHECK(below == Approx(2 * std::asin((static_cast<double>(b) + 1) / 8) / std::numbers::pi).margin(1e-5));
  }
}

TEST_CASE("lifted_areas: exact for sphere and torus to fourth order, flat faces are unchanged") {
  const double sphere = 4 * std::numbers::pi;
  const double coarse = std::abs(lifted_area(icosphere(2)) - sphere),
               fine = std::abs(lifted_area(icosphere(3)) - sphere);
  INFO("sphere: " << coarse / sphere << ", finer " << fine / sphere);
  CHECK(coarse < 1e-3 * sphere);
  CHECK(fine < coarse / 12);
  CHECK(lifted_area(torus(64, 32)) == Approx(full_turn * full_turn * 0.4).epsilon(1e-3));
  CHECK(lifted_area(cube()) == Approx(24));
  // A triangle without area, and lengths that do not fit.
  const std::vector<double> x = {0, 1, 2}, y = {0, 0, 0}, none(9);
  const std::vector<std::uint32_t> line = {0, 1, 2};
  CHECK(lifted_areas(x, y, y, line, none).at(0) == Approx(0).margin(1e-15));
  CHECK_THROWS_AS(lifted_areas(x, y, y, line, x), std::invalid_argument);
}

TEST_CASE("nearest_points: equal a comparison with every point") {
  std::vector<double> points, queries;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const UnitPair u = random_pair({}, Stream::point_set, i);
    (i < 900 ? points : queries).insert((i < 900 ? points : queries).end(), {u.first, u.second});
  }
  const std::size_t found = queries.size() / 3;
  const std::vector<std::uint32_t> nearest = nearest_points(KdTree<3>(points), queries);
  REQUIRE(nearest.size() == found);
  for (std::size_t i = 0; i < found; ++i) {
    const auto squared = [&](std::size_t p) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double d = points[3 * p + k] - queries[3 * i + k];
        sum += d * d;
      }
      return sum;
    };
    double least = squared(0);
    for (std::size_t p = 1; p < points.size() / 3; ++p) least = std::min(least, squared(p));
    REQUIRE(squared(nearest[i]) == least);
  }
  CHECK(nearest_points(KdTree<3>(std::vector<double>{}), std::vector<double>{0, 0, 0}) ==
        std::vector<std::uint32_t>{KdTree<3>::none});
}
