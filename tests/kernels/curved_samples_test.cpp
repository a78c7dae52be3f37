#include "kernels/sample/curved_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/random.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

struct Lifted {
  std::vector<double> flat, curved;
};

// Three random samples of every triangle, as they are and lifted.
Lifted lifted(const PolygonMesh& mesh, const CurvedSampleParameters& parameters = {}) {
  const auto triangles = triangles_of(mesh);
  std::vector<std::uint32_t> triangle;
  std::vector<float> weights;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const UnitPair u = random_pair({}, Stream::point_set, i);
    triangle.push_back(i / 3);
    const bool fold = u.first + u.second > 1;
    weights.push_back(static_cast<float>(fold ? 1 - u.first : u.first));
    weights.push_back(static_cast<float>(fold ? 1 - u.second : u.second));
  }
  const auto normals = crease_normals(mesh.x, mesh.y, mesh.z, triangles, parameters);
  const std::vector<double> none(normals.size());
  return {lift_samples(mesh.x, mesh.y, mesh.z, triangles, none, triangle, weights, parameters),
          lift_samples(mesh.x, mesh.y, mesh.z, triangles, normals, triangle, weights, parameters)};
}

template <class Distance>
double largest_distance(const std::vector<double>& points, const Distance& distance_to) {
  double most = 0;
  for (std::size_t i = 0; i < points.size(); i += 3)
    most = std::max(most, distance_to(Vector3{points[i], points[i + 1], points[i + 2]}));
  return most;
}

double off_sphere(Vector3 p) { return std::abs(norm(p) - 1); }
double off_torus(Vector3 p) { return std::abs(std::hypot(std::hypot(p.x, p.y) - 1, p.z) - 0.4); }

// The centroid of an equilateral triangle of edge h on the unit sphere.
double centroid_offset(double h) {
  const double s = h / std::sqrt(3.0), height = std::sqrt(1 - s * s), third = 2 * std::numbers::pi / 3;
  std::array<Vector3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const double turn = third * static_cast<double>(k);
    corners[k] = {s * std::cos(turn), s * std::sin(turn), height};
  }
  return curved_offset(corners, corners, {1.0 / 3, 1.0 / 3, 1.0 / 3});
}

}  // namespace

TEST_CASE("triangle offsets: on the unit sphere exact to fourth order") {
  const auto exact = [](double h) { return 1 - std::sqrt(1 - h * h / 3); };
  const double h = 0.236;
  CHECK(exact(h) == Approx(0.00933).margin(1e-5));
  CHECK(centroid_offset(h) == Approx(0.00928).margin(1e-5));
  CHECK(centroid_offset(h) == Approx(h * h / 6).epsilon(1e-12));
  for (const double edge : {0.4, 0.2, 0.1})  // the error is h^4 / 72
    CHECK(exact(edge) - centroid_offset(edge) == Approx(std::pow(edge, 4) / 72).epsilon(0.1));
}

TEST_CASE("lifted samples: approach the sphere to fourth order and the torus to third") {
  const double coarse_flat = largest_distance(lifted(icosphere(2)).flat, off_sphere);
  const double coarse = largest_distance(lifted(icosphere(2)).curved, off_sphere);
  const double fine = largest_distance(lifted(icosphere(3)).curved, off_sphere);
  CHECK(coarse < 0.02 * coarse_flat);
  CHECK(fine < coarse / 13);

  const double torus_flat = largest_distance(lifted(torus(64, 32)).flat, off_torus);
  const double torus_coarse = largest_distance(lifted(torus(64, 32)).curved, off_torus);
  const double torus_fine = largest_distance(lifted(torus(128, 64)).curved, off_torus);
  INFO("torus: flat " << torus_flat << ", lifted " << torus_coarse << ", finer " << torus_fine);
  CHECK(torus_coarse < 0.1 * torus_flat);
  CHECK(torus_fine < torus_coarse / 7);
}

TEST_CASE("vertex normals: are split at creases, so that flat faces stay flat") {
  for (const PolygonMesh& mesh : {cube(), tetrahedron(), grid_plane(4, 3), two_sided_plate(4, 0.1)}) {
    const Lifted samples = lifted(mesh);
    CHECK(samples.curved == samples.flat);
  }
  // Without creases the corners of the cube are rounded: along the diagonals of space.
  const PolygonMesh mesh = cube();
  const auto triangles = triangles_of(mesh);
  const auto round = crease_normals(mesh.x, mesh.y, mesh.z, triangles, {.crease_degrees = 180});
  for (std::size_t c = 0; c < triangles.size(); ++c) {
    CHECK(norm({round[3 * c], round[3 * c + 1], round[3 * c + 2]}) == Approx(1));
    CHECK(round[3 * c] * mesh.x[triangles[c]] > 0);
  }
  CHECK(lifted(mesh, {.crease_degrees = 180}).curved != lifted(mesh).flat);

  // A prism of 12 sides: 30 degrees between its sides, 90 at its ends.
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces(2);
  for (std::uint32_t k = 0; k < 12; ++k) {
    const double turn = 2 * std::numbers::pi * k / 12;
    for (const double height : {0.0, 1.0}) xyz.insert(xyz.end(), {std::cos(turn), std::sin(turn), height});
    faces[0].insert(faces[0].begin(), 2 * k);
    faces[1].push_back(2 * k + 1);
    const std::uint32_t next = (k + 1) % 12;
    faces.push_back({2 * k, 2 * next, 2 * next + 1, 2 * k + 1});
  }
  const PolygonMesh prism = polygon_mesh(xyz, faces);
  const auto normals = crease_normals(prism.x, prism.y, prism.z, triangles_of(prism));
  const auto sides = triangles_of(prism);
  for (std::size_t c = 0; c < sides.size(); ++c) {
    const bool cap = c < 60;  // two fans of ten triangles
    const Vector3 n{normals[3 * c], normals[3 * c + 1], normals[3 * c + 2]};
    CHECK(std::abs(n.z) == Approx(cap ? 1 : 0).margin(1e-12));
    if (!cap) CHECK(n.x * prism.x[sides[c]] + n.y * prism.y[sides[c]] > 0.99);
  }
}

TEST_CASE("triangle offsets: are bounded, and invalid arguments are refused") {
  const std::array<Vector3, 3> corners{Vector3{0, 0, 0}, Vector3{1, 0, 0}, Vector3{0, 1, 0}};
  const std::array<Vector3, 3> wild{Vector3{-40, 0, 0}, Vector3{40, 0, 0}, Vector3{0, 40, 0}};
  CHECK(curved_offset(corners, wild, {0.4, 0.3, 0.3}) == Approx(0.25 * std::sqrt(2.0)));
  CHECK(curved_offset(corners, wild, {0.4, 0.3, 0.3}, 0.1) == Approx(0.1 * std::sqrt(2.0)));
  CHECK(curved_offset(corners, wild, {1, 0, 0}) == 0);
  // Scale does not matter to normals, however small.
  const PolygonMesh large = icosphere(1, 1e50), small = icosphere(1, 1e-50);
  const auto triangles = triangles_of(large);
  const auto a = crease_normals(large.x, large.y, large.z, triangles);
  const auto b = crease_normals(small.x, small.y, small.z, triangles);
  for (std::size_t k = 0; k < a.size(); ++k) CHECK(a[k] == Approx(b[k]).margin(1e-12));
  const std::vector<std::uint32_t> sample{0};
  const std::vector<float> weights{0.2f, 0.2f};
  const auto lift = [&](const std::vector<double>& normals, const std::vector<std::uint32_t>& triangle) {
    return lift_samples(large.x, large.y, large.z, triangles, normals, triangle, weights);
  };
  CHECK_NOTHROW(lift(a, sample));
  CHECK_THROWS_AS(lift({0, 0, 1}, sample), std::invalid_argument);
  CHECK_THROWS_AS(lift(a, {100000}), std::invalid_argument);
  CHECK_THROWS_AS(crease_normals(large.x, large.y, large.z, triangles, {.crease_degrees = 200}),
                  std::invalid_argument);
}
