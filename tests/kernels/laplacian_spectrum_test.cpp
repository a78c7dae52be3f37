#include "kernels/describe/laplacian_spectrum.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/solve/intrinsic_delaunay.h"
#include "kernels/solve/surface_laplacian.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;
constexpr std::size_t values = 40;

// In file units, by its only component.
IntrinsicSurface surface_of(const PolygonMesh& file) {
  const PreparedMesh mesh = prepare_mesh(file);
  REQUIRE(mesh.components.size() == 1);
  IntrinsicSurface surface = intrinsic_component(mesh, mesh.components.front());
  for (double& length : surface.length) length *= mesh.unit;
  mollify(surface.length);
  make_intrinsic_delaunay(surface);
  return surface;
}

// The torus of the plane over the lattice of u = (ux, 0) and v = (vx, vy), n x m vertices.
IntrinsicSurface flat_torus(std::uint32_t n, std::uint32_t m, double ux, double vx, double vy) {
  IntrinsicSurface surface;
  surface.vertex_count = n * m;
  const double along = ux / n, across = std::hypot(vx, vy) / m;
  const double diagonal = std::hypot(ux / n + vx / m, vy / m);
  const auto vertex = [&](std::uint32_t i, std::uint32_t j) { return (i % n) + n * (j % m); };
  const auto lower = [&](std::uint32_t i, std::uint32_t j) { return 6 * ((i % n) + n * (j % m)); };
  for (std::uint32_t j = 0; j < m; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      // Below the diagonal, then above it.
      surface.triangles.insert(surface.triangles.end(),
                               {vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j),
                                vertex(i + 1, j + 1), vertex(i, j + 1)});
      surface.length.insert(surface.length.end(), {along, across, diagonal, diagonal, along, across});
      const std::uint32_t here = lower(i, j);
      surface.opposite.insert(surface.opposite.end(), {lower(i, j + m - 1) + 4, lower(i + 1, j) + 5, here + 3,
                                                       here + 2, lower(i, j + 1), lower(i + n - 1, j) + 1});
    }
  make_intrinsic_delaunay(surface);
  return surface;
}

std::vector<double> lowest(std::vector<double> all, std::size_t count = values) {
  std::sort(all.begin(), all.end());
  all.erase(all.begin());  // the constant function
  all.resize(count);
  return all;
}

std::vector<double> of_unit_sphere() {
  std::vector<double> all;
  for (int l = 0; l < 8; ++l) all.insert(all.end(), static_cast<std::size_t>(2 * l + 1), l * (l + 1.0));
  return lowest(all);
}

std::vector<double> of_flat_torus(double ux, double vx, double vy) {
  std::vector<double> all;
  for (int p = -12; p <= 12; ++p)
    for (int q = -12; q <= 12; ++q) {
      const double x = p / ux, y = (q - p * vx / ux) / vy;  // of the dual lattice
      all.push_back(4 * pi * pi * (x * x + y * y));
    }
  return lowest(all);
}

std::vector<double> of_rectangle(double width, double height) {
  std::vector<double> all;
  for (int p = 0; p <= 40; ++p)
    for (int q = 0; q <= 40; ++q)
      all.push_back(pi * pi * (p * p / (width * width) + q * q / (height * height)));
  return lowest(all);
}

double largest_error(const std::vector<double>& found, const std::vector<double>& expected) {
  REQUIRE(found.size() == expected.size());
  double largest = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    largest = std::max(largest, std::abs(found[i] / expected[i] - 1));
  return largest;
}

// The slow version: dense matrices filled triangle by triangle from the hat functions.
std::vector<double> by_dense_elements(const IntrinsicSurface& surface) {
  const auto n = static_cast<Eigen::Index>(surface.vertex_count);
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(n, n), mass = stiffness;
  for (std::size_t t = 0; t < surface.triangle_count(); ++t) {
    const double* l = surface.length.data() + 3 * t;
    // Laid out in the plane.
    const double x = (l[0] * l[0] + l[2] * l[2] - l[1] * l[1]) / (2 * l[0]);
    const double y = std::sqrt(std::max(l[2] * l[2] - x * x, 0.0));
    const Eigen::Vector2d corner[3] = {{0, 0}, {l[0], 0}, {x, y}};
    const double area = l[0] * y / 2;
    Eigen::Vector2d gradient[3];
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d edge = corner[(k + 2) % 3] - corner[(k + 1) % 3];
      gradient[k] = Eigen::Vector2d(-edge.y(), edge.x()) / (2 * area);
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const Eigen::Index a = surface.triangles[3 * t + static_cast<std::size_t>(i)],
                           b = surface.triangles[3 * t + static_cast<std::size_t>(j)];
        stiffness(a, b) += area * gradient[i].dot(gradient[j]);
        const double consistent = i == j ? area / 6 : area / 12, lumped = i == j ? area / 3 : 0;
        mass(a, b) += (consistent + lumped) / 2;
      }
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness, mass,
                                                                         Eigen::EigenvaluesOnly);
  return {solver.eigenvalues().begin() + 1, solver.eigenvalues().end()};
}

}  // namespace

TEST_CASE("laplacian spectrum: the regular tetrahedron in closed form") {
  // K = (4 I - J) / sqrt(3), and M is 2 / 3 of a triangle's area on functions of mean 0.
  const IntrinsicSurface surface = surface_of(tetrahedron());
  const double side = std::sqrt(8.0);
  const std::vector<double> found = laplacian_spectrum(surface, 10);
  REQUIRE(found.size() == 3);
  for (const double value : found) CHECK(value == Approx(8 / (side * side)).epsilon(1e-12));
}

TEST_CASE("laplacian spectrum: iterations match dense matrices, multiple eigenvalues included") {
  for (const PolygonMesh& file : {icosphere(2), torus(20, 12), cube(), grid_plane(12, 9, 2, 1)}) {
    const IntrinsicSurface surface = surface_of(file);
    std::vector<double> dense = by_dense_elements(surface);
    dense.resize(std::min(dense.size(), values));
    CAPTURE(surface.vertex_count);
    const std::vector<double> found = laplacian_spectrum(surface, values);
    REQUIRE(found.size() == dense.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      CAPTURE(i);
      CHECK(found[i] == Approx(dense[i]).epsilon(1e-4));  // the masses are spread by 1e-3
    }
  }
}

TEST_CASE("laplacian spectrum: sphere, flat tori and rectangle match closed forms, about 1,000 vertices") {
  CHECK(largest_error(laplacian_spectrum(surface_of(icosphere(3)), values), of_unit_sphere()) < 0.01);
  CHECK(largest_error(laplacian_spectrum(flat_torus(32, 32, 1, 0, 1), values), of_flat_torus(1, 0, 1)) <
        0.03);
  CHECK(largest_error(laplacian_spectrum(flat_torus(40, 25, 1.6, 0.5, 1), values),
                      of_flat_torus(1.6, 0.5, 1)) < 0.01);
  CHECK(largest_error(laplacian_spectrum(surface_of(grid_plane(40, 25, 1.6, 1)), values),
                      of_rectangle(1.6, 1)) < 0.02);
}

TEST_CASE("laplacian spectrum: within 1 % of closed forms at 20,000 vertices", "[statistics]") {
  if (sanitized) {
    WARN("skipped: too slow with sanitizers; the release build runs it");
    return;
  }
  std::vector<double> found = laplacian_spectrum(surface_of(icosphere(5)), values);
  CHECK(largest_error(found, of_unit_sphere()) < 0.01);
  found = laplacian_spectrum(flat_torus(160, 125, 1.6, 0.5, 1), values);
  CHECK(largest_error(found, of_flat_torus(1.6, 0.5, 1)) < 0.01);
  found = laplacian_spectrum(surface_of(grid_plane(160, 125, 1.6, 1)), values);
  CHECK(largest_error(found, of_rectangle(1.6, 1)) < 0.01);
}

TEST_CASE("laplacian spectrum: few vertices give fewer eigenvalues, one gives none") {
  CHECK(laplacian_spectrum(surface_of(cube()), values).size() == 7);
  CHECK(laplacian_spectrum(surface_of(tetrahedron()), 2).size() == 2);
  CHECK(laplacian_spectrum(surface_of(tetrahedron()), 0).empty());
  CHECK(laplacian_spectrum(IntrinsicSurface{}, 5).empty());
}

TEST_CASE("joint spectrum: the lowest of all components, including equal and small ones") {
  const IntrinsicSurface ball = surface_of(icosphere(2)), ring = surface_of(torus(24, 12)),
                         block = surface_of(cube()), speck = surface_of(icosphere(1, 0.01));
  const std::vector<IntrinsicSurface> components = {ball, speck, ring, ball, block, ball};
  std::vector<double> expected;
  for (const IntrinsicSurface& component : components) {
    const std::vector<double> own = laplacian_spectrum(component, values);
    expected.insert(expected.end(), own.begin(), own.end());
  }
  std::sort(expected.begin(), expected.end());
  expected.resize(values);
  const std::vector<double> found = joint_spectrum(components, values);
  REQUIRE(found.size() == values);
  for (std::size_t i = 0; i < values; ++i) CHECK(found[i] == Approx(expected[i]).epsilon(1e-6));
  CHECK(joint_spectrum(std::span(components).subspan(4, 1), values).size() == 7);
  CHECK(joint_spectrum({}, values).empty());
}

TEST_CASE("laplacian spectrum: an expired deadline ends the iterations") {
  CancelToken late;
  late.deadline = std::chrono::steady_clock::time_point::min();
  CHECK_THROWS_AS(laplacian_spectrum(surface_of(icosphere(3)), values, late), ItemError);
}
