#include "kernels/describe/shape_dna.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// One sample in each of n equal shares of the area, in the order of the triangles.
std::vector<float> values_of(const PolygonMesh& file, std::uint32_t n = 1024, std::uint64_t seed = 1,
                             const CancelToken& cancel = {}) {
  const PreparedMesh mesh = prepare_mesh(file);
  std::vector<double> until;
  double area = 0;
  for (const double own : mesh.area) until.push_back(area += own);
  const RandomKey key = make_random_key(seed, {});
  std::vector<std::uint32_t> triangle, rank;
  std::vector<float> weights;
  for (std::uint32_t i = 0; i < n; ++i) {
    const UnitPair a = random_pair(key, Stream::point_set, i, 0),
                   b = random_pair(key, Stream::point_set, i, 1);
    const double share = area * (i + a.first) / n;
    triangle.push_back(
        static_cast<std::uint32_t>(std::upper_bound(until.begin(), until.end() - 1, share) - until.begin()));
    rank.push_back(i);
    const double root = std::sqrt(b.first);
    weights.push_back(static_cast<float>(root * (1 - b.second)));
    weights.push_back(static_cast<float>(root * b.second));
  }
  return shape_dna(mesh, {triangle, weights, rank}, cancel);
}

double largest_ratio(const std::vector<float>& found, const std::vector<float>& expected) {
  REQUIRE(found.size() == shape_dna_values);
  REQUIRE(expected.size() == shape_dna_values);
  double largest = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    largest = std::max(largest, std::abs(double{found[i]} / double{expected[i]} - 1));
  return largest;
}

// From eigenvalues times the area over 4 pi.
std::vector<float> descriptor_of(std::vector<double> eigenvalues) {
  std::sort(eigenvalues.begin(), eigenvalues.end());
  std::vector<float> values;
  for (std::size_t i = 0; i < shape_dna_values; ++i)
    values.push_back(static_cast<float>(std::sqrt(eigenvalues[i] / static_cast<double>(i + 1))));
  return values;
}

// Of `copies` equal spheres.
std::vector<float> of_spheres(int copies) {
  std::vector<double> all;
  for (int l = 1; l < 8; ++l)
    all.insert(all.end(), static_cast<std::size_t>(copies * (2 * l + 1)), copies * l * (l + 1.0));
  return descriptor_of(all);
}

// A sheet of 2 x 1 rolled up to a part of a cylinder.
PolygonMesh rolled_sheet(double angle) {
  PolygonMesh sheet = grid_plane(40, 20, 2, 1);
  if (angle == 0) return sheet;
  const double radius = 2 / angle;
  for (std::size_t v = 0; v < sheet.vertex_count(); ++v) {
    const double turn = sheet.x[v] / radius;
    sheet.x[v] = radius * std::sin(turn);
    sheet.z[v] = radius * std::cos(turn);
  }
  return sheet;
}

}  // namespace

TEST_CASE("shape DNA: spheres have l (l + 1), 2 l + 1 times, whatever their triangles and samples") {
  const std::vector<float> expected = of_spheres(1);
  for (const int subdivisions : {3, 4})
    CHECK(largest_ratio(values_of(icosphere(subdivisions)), expected) < 0.015);
  CHECK(largest_ratio(values_of(icosphere(4), 600, 2), expected) < 0.015);
  // All four triangles of each are cut in four.
  CHECK(largest_ratio(values_of(icosphere(4), 150), expected) < 0.05);
}

TEST_CASE("shape DNA: two components give the union of their spectra") {
  const PolygonMesh two = merged(icosphere(4), moved(icosphere(4), 1, 5, 0, 0));
  CHECK(largest_ratio(values_of(two), of_spheres(2)) < 0.01);
}

TEST_CASE("shape DNA: invariant to motion, size, handedness, winding, triangles and samples") {
  const PolygonMesh ring = torus(50, 30);
  const std::vector<float> reference = values_of(ring);
  PolygonMesh mirrored = ring;
  for (double& x : mirrored.x) x = -x;
  CHECK(largest_ratio(values_of(moved(ring, 7, 1, 2, 3)), reference) < 0.005);
  CHECK(largest_ratio(values_of(mirrored), reference) < 0.01);
  CHECK(largest_ratio(values_of(inside_out(ring)), reference) < 0.01);
  CHECK(largest_ratio(values_of(torus(101, 61)), reference) < 0.01);
  CHECK(largest_ratio(values_of(ring, 1024, 2), reference) < 0.01);
  CHECK(largest_ratio(values_of(ring, 4096), reference) < 0.01);
  CHECK(largest_ratio(values_of(icosphere(3)), reference) > 0.1);
}

TEST_CASE("shape DNA: bending without stretching changes little") {
  const std::vector<float> flat = values_of(rolled_sheet(0));
  CHECK(largest_ratio(values_of(rolled_sheet(2)), flat) < 0.01);
  CHECK(largest_ratio(values_of(rolled_sheet(5)), flat) < 0.015);
}

TEST_CASE("shape DNA: a flat rectangle in closed form") {
  // Of 2 x 1: pi^2 (p^2 / 4 + q^2), times the area over 4 pi.
  std::vector<double> expected;
  for (int p = 0; p < 20; ++p)
    for (int q = 0; q < 20; ++q)
      if (p + q > 0) expected.push_back(std::numbers::pi / 2 * (p * p / 4.0 + q * q));
  CHECK(largest_ratio(values_of(rolled_sheet(0)), descriptor_of(expected)) < 0.01);
}

TEST_CASE("shape DNA: NaN where the topology needs too many vertices") {
  // 60 x 60 holes, each of which keeps three vertices at least.
  const std::vector<float> found = values_of(plate_with_holes(60));
  REQUIRE(found.size() == shape_dna_values);
  CHECK(std::all_of(found.begin(), found.end(), [](float value) { return std::isnan(value); }));
}

TEST_CASE("shape DNA: an expired deadline ends the work") {
  CancelToken late;
  late.deadline = std::chrono::steady_clock::time_point::min();
  CHECK_THROWS_AS(values_of(icosphere(3), 1024, 1, late), ItemError);
}
