#include "kernels/density/density.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <span>

#include "kernels/core/parallel.h"
#include "kernels/density/curvature.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

// Area-weighted mean and largest relative errors against a closed form, in file units.
struct Errors {
  double mean = 0, worst = 0;
};
template <class Exact>
Errors relative_errors(const PreparedMesh& mesh, std::span<const double> area, std::span<const double> value,
                       const Exact& exact) {
  Errors errors;
  double total = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 p = mesh.center + mesh.unit * mesh.position(v);
    const double error = std::abs(value[v] - exact(p)) / std::abs(exact(p));
    errors.mean += area[v] * error;
    errors.worst = std::max(errors.worst, error);
    total += area[v];
  }
  errors.mean /= total;
  return errors;
}

// Open cylinder of radius 1 and height 2 about z; inner vertices moved on it by up to `jitter` of a cell.
PolygonMesh cylinder(std::uint32_t around, std::uint32_t rings, double jitter) {
  PolygonMesh mesh = grid_plane(around, rings);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> move(-jitter, jitter);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const bool rim = mesh.y[i] == 0 || mesh.y[i] == 1;
    const double s = 2 * std::numbers::pi * (mesh.x[i] + move(random) / around);
    const double height = 2 * (mesh.y[i] + (rim ? 0 : move(random) / rings));
    mesh.x[i] = std::cos(s);
    mesh.y[i] = std::sin(s);
    mesh.z[i] = height;
  }
  for (std::size_t i = 0; i < mesh.x.size(); i += around + 1) {  // the two ends of a ring are one place
    mesh.x[i + around] = mesh.x[i];
    mesh.y[i + around] = mesh.y[i];
    mesh.z[i + around] = mesh.z[i];
  }
  return mesh;
}

DensityParameters kind_of(DensityKind kind, std::string attribute = {}) {
  DensityParameters parameters;
  parameters.kind = kind;
  parameters.attribute = std::move(attribute);
  return parameters;
}

std::vector<double> file_vertex_density(const PolygonMesh& file, const PreparedMesh& mesh,
                                        const Density& density) {
  std::vector<double> value(file.vertex_count(), -1);
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h)
    value[file.corners[mesh.corner_slot[h]]] = density.corner[h];
  return value;
}

}  // namespace

TEST_CASE("vertex_curvature: mixed areas tile every mesh") {
  PolygonMesh slivers = grid_plane(3, 200, 1, 0.01);
  for (const PolygonMesh& file :
       {icosphere(3), cube(), torus(40, 9), two_sided_plate(5, 1e-3), moebius_strip(7), slivers}) {
    const PreparedMesh mesh = prepare_mesh(file);
    const VertexCurvature curvature = vertex_curvature(mesh);
    const double sum = std::accumulate(curvature.mixed_area.begin(), curvature.mixed_area.end(), 0.0);
    CHECK(sum == Approx(mesh.total_area).epsilon(1e-12));
    CHECK(*std::min_element(curvature.mixed_area.begin(), curvature.mixed_area.end()) > 0);
  }
}

TEST_CASE("vertex_curvature: sphere of radius R has H = 1/R and K = 1/R^2") {
  for (const double radius : {1.0, 250.0}) {
    double last_mean = 1, last_gaussian = 1;
    for (const int subdivisions : {2, 3, 4}) {
      const PreparedMesh mesh = prepare_mesh(icosphere(subdivisions, radius));
      VertexCurvature curvature = vertex_curvature(mesh);
      for (double& h : curvature.mean) h /= mesh.unit;
      for (double& k : curvature.gaussian) k /= mesh.unit * mesh.unit;
      const Errors mean =
          relative_errors(mesh, curvature.mixed_area, curvature.mean, [&](Vector3) { return 1 / radius; });
      const Errors gaussian = relative_errors(mesh, curvature.mixed_area, curvature.gaussian,
                                              [&](Vector3) { return 1 / (radius * radius); });
      CAPTURE(subdivisions, mean.mean, mean.worst, gaussian.mean, gaussian.worst);
      CHECK(mean.mean < 0.6 * last_mean);
      CHECK(gaussian.mean < 0.6 * last_gaussian);
      CHECK(mean.worst < 0.05);
      CHECK(gaussian.worst < 0.08);
      last_mean = mean.mean;
      last_gaussian = gaussian.mean;
    }
    CHECK(last_mean < 0.004);
    CHECK(last_gaussian < 0.006);
  }
}

TEST_CASE("vertex_curvature: angle defects of a closed mesh sum to 2 pi chi") {
  const auto sum_of = [](const PolygonMesh& file) {
    const PreparedMesh mesh = prepare_mesh(file);
    const VertexCurvature curvature = vertex_curvature(mesh);
    return std::inner_product(curvature.gaussian.begin(), curvature.gaussian.end(),
                              curvature.mixed_area.begin(), 0.0);
  };
  CHECK(sum_of(icosphere(3)) == Approx(4 * std::numbers::pi));
  CHECK(sum_of(cube()) == Approx(4 * std::numbers::pi));
  CHECK(sum_of(torus(31, 17)) == Approx(0).margin(1e-9));
}

TEST_CASE("vertex_curvature: cylinder has H = 1 / (2 R) and K = 0, boundary vertices too") {
  for (const double jitter : {0.0, 0.2}) {
    const PreparedMesh mesh = prepare_mesh(cylinder(96, 32, jitter));
    VertexCurvature curvature = vertex_curvature(mesh);
    for (double& h : curvature.mean) h /= mesh.unit;
    for (double& k : curvature.gaussian) k = k / (mesh.unit * mesh.unit) + 1;
    const Errors mean =
        relative_errors(mesh, curvature.mixed_area, curvature.mean, [](Vector3) { return 0.5; });
    const Errors gaussian =
        relative_errors(mesh, curvature.mixed_area, curvature.gaussian, [](Vector3) { return 1.0; });
    CAPTURE(jitter, mean.mean, mean.worst, gaussian.mean, gaussian.worst);
    // Inscribed in the cylinder by regular rings the operator is right to the float32 floor; on an irregular
    // mesh it is consistent on average only.
    CHECK(mean.worst < (jitter == 0 ? 1e-9 : 0.5));
    CHECK(mean.mean < (jitter == 0 ? 1e-9 : 0.12));
    CHECK(gaussian.worst < (jitter == 0 ? 1e-9 : 0.1));
  }
}

TEST_CASE("vertex_curvature: a torus has its closed forms") {
  const double major = 1, minor = 0.4;
  const auto cosine = [&](Vector3 p) { return (std::hypot(p.x, p.y) - major) / minor; };
  double last_mean = 1, last_gaussian = 1;
  for (const std::uint32_t across : {20u, 40u, 80u}) {
    const PreparedMesh mesh = prepare_mesh(torus(2 * across, across, major, minor));
    VertexCurvature curvature = vertex_curvature(mesh);
    for (double& h : curvature.mean) h /= mesh.unit;
    // K is zero on two circles: the error is measured against the largest K, that of the inner circle.
    std::vector<double> shifted(curvature.gaussian);
    const double largest = 1 / (minor * (major - minor));
    for (double& k : shifted) k = k / (mesh.unit * mesh.unit) + 10 * largest;
    const Errors mean = relative_errors(mesh, curvature.mixed_area, curvature.mean, [&](Vector3 p) {
      const double c = cosine(p);
      return 0.5 * (1 / minor + c / (major + minor * c));
    });
    const Errors gaussian = relative_errors(mesh, curvature.mixed_area, shifted, [&](Vector3 p) {
      const double c = cosine(p);
      return c / (minor * (major + minor * c)) + 10 * largest;
    });
    CAPTURE(across, mean.mean, mean.worst, gaussian.mean, gaussian.worst);
    CHECK(mean.worst < 0.35 * last_mean);
    CHECK(gaussian.worst < 0.35 * last_gaussian);
    last_mean = mean.worst;
    last_gaussian = gaussian.worst;
  }
  CHECK(last_mean < 0.005);
  CHECK(last_gaussian < 0.001);
}

TEST_CASE("make_density: a sphere is nearly uniform for every curvature kind") {
  const PolygonMesh file = icosphere(4);
  const PreparedMesh mesh = prepare_mesh(file);
  for (const DensityKind kind : {DensityKind::mean, DensityKind::gaussian, DensityKind::max}) {
    const Density density = make_density(file, mesh, kind_of(kind));
    REQUIRE(density.corner.size() == 3 * mesh.triangle_count());
    const auto [low, high] = std::minmax_element(density.corner.begin(), density.corner.end());
    CHECK(*high == 1.0);
    CHECK(*low > (kind == DensityKind::max ? 0.75 : 0.9));  // max holds the root of what is left of H^2 - K
  }
}

TEST_CASE("make_density: torus follows the mean curvature, the outside more than the inside") {
  const PolygonMesh file = torus(120, 60);
  const PreparedMesh mesh = prepare_mesh(file);
  DensityParameters parameters = kind_of(DensityKind::mean);
  parameters.floor = 0.1;
  parameters.quantile = 1;
  const std::vector<double> value = file_vertex_density(file, mesh, make_density(file, mesh, parameters));
  const double outer = 0.5 * (1 / 0.4 + 1 / 1.4), inner = 0.5 * (1 / 0.4 - 1 / 0.6);
  CHECK(value[0] == Approx(1.0).epsilon(0.01));
  CHECK(value[30] == Approx(0.1 + 0.9 * inner / outer).epsilon(0.01));
  parameters.exponent = 2;
  const std::vector<double> squared = file_vertex_density(file, mesh, make_density(file, mesh, parameters));
  CHECK(squared[30] == Approx(0.1 + 0.9 * std::pow(inner / outer, 2)).epsilon(0.02));
}

TEST_CASE("make_density: invariant to scale and motion") {
  const PolygonMesh file = torus(36, 18);
  const PreparedMesh mesh = prepare_mesh(file);
  for (const DensityKind kind : {DensityKind::mean, DensityKind::gaussian, DensityKind::max})
    for (const double scale : {1e-20, 3.0, 1e25}) {
      const PolygonMesh other = moved(file, scale, 4 * scale, -2 * scale, scale);
      const PreparedMesh other_mesh = prepare_mesh(other);
      const auto expected = file_vertex_density(file, mesh, make_density(file, mesh, kind_of(kind)));
      const auto found =
          file_vertex_density(other, other_mesh, make_density(other, other_mesh, kind_of(kind)));
      double worst = 0;
      for (std::size_t v = 0; v < expected.size(); ++v)
        worst = std::max(worst, std::abs(expected[v] - found[v]));
      // the diagonal of the box turns with the mesh, but density is relative to a quantile
      CHECK(worst < 1e-9);
    }
}

TEST_CASE("make_density: flat surfaces are uniform, whatever float32 made of their coordinates") {
  for (const bool round : {false, true}) {
    PolygonMesh file = moved(grid_plane(60, 60), 7, 3, 1, -2);
    if (round)
      for (auto* axis : {&file.x, &file.y, &file.z})
        for (double& c : *axis) c = static_cast<float>(c);
    const PreparedMesh mesh = prepare_mesh(file);
    for (const DensityKind kind : {DensityKind::mean, DensityKind::gaussian, DensityKind::max})
      CHECK(make_density(file, mesh, kind_of(kind)).uniform());
  }
}

TEST_CASE("make_density: a few curved places on a flat surface get the density") {
  PolygonMesh file = grid_plane(80, 80);
  file.z[40 * 81 + 40] = 0.02;  // one spike, far less than one per cent of the area
  const PreparedMesh mesh = prepare_mesh(file);
  const auto value = file_vertex_density(file, mesh, make_density(file, mesh, kind_of(DensityKind::max)));
  CHECK(value[40 * 81 + 40] > 0.8);
  CHECK(*std::max_element(value.begin(), value.end()) == 1.0);
  CHECK(value[10 * 81 + 10] == Approx(0.02));
}

TEST_CASE("make_density: noise, needles and zero-area triangles stay finite") {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.05);
  PolygonMesh file = icosphere(3);
  for (auto* axis : {&file.x, &file.y, &file.z})
    for (double& c : *axis) c += noise(random);
  // needles: an edge of 1e-12, and a vertex on the middle of an edge (no area)
  file = merged(file, polygon_mesh({3, 0, 0, 4, 0, 0, 3.5, 1e-12, 0, 3.5, 0, 0, 3.5, 1, 0, 3.5, -1, 0},
                                   {{0, 2, 1}, {0, 3, 1}, {0, 4, 2}, {2, 4, 1}, {5, 3, 0}, {5, 1, 3}}));
  const PreparedMesh mesh = prepare_mesh(file);
  for (const DensityKind kind : {DensityKind::mean, DensityKind::gaussian, DensityKind::max}) {
    const Density density = make_density(file, mesh, kind_of(kind));
    REQUIRE_FALSE(density.uniform());
    CHECK(std::all_of(density.corner.begin(), density.corner.end(),
                      [](double d) { return d >= 0.02 && d <= 1.0; }));
    CHECK(std::isfinite(blocked_sum(triangle_masses(mesh, density))));
  }
}

TEST_CASE("make_density: a mesh with boundary vertices only has no curvature") {
  const PolygonMesh strip = moebius_strip(12);
  const PreparedMesh mesh = prepare_mesh(strip);
  CHECK(make_density(strip, mesh, kind_of(DensityKind::mean)).uniform());
}

TEST_CASE("triangle_masses: area times the mean of the corners") {
  const PolygonMesh file = cube();
  const PreparedMesh mesh = prepare_mesh(file);
  CHECK(triangle_masses(mesh, {}) == mesh.area);
  Density density;
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h)
    density.corner.push_back(static_cast<double>(h % 3));
  const std::vector<double> mass = triangle_masses(mesh, density);
  for (std::size_t t = 0; t < mass.size(); ++t) CHECK(mass[t] == Approx(mesh.area[t]));
}

TEST_CASE("make_density: vertex and face attributes follow the numbering of the file") {
  PolygonMesh file = cube();  // quads: two triangles a polygon
  file.vertex_attributes = {{"other", std::vector<double>(8, 7.0)}, {"weight", {0, 1, 2, 3, 4, 5, 6, 7}}};
  file.face_attributes = {{"weight", {10, 11, 12, 13, 14, 15}}};
  const PreparedMesh mesh = prepare_mesh(file);
  const Density vertex = make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "weight"));
  const Density face = make_density(file, mesh, kind_of(DensityKind::face_attribute, "weight"));
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h) {
    CHECK(vertex.corner[h] == file.corners[mesh.corner_slot[h]]);
    CHECK(face.corner[h] == 10.0 + mesh.polygon[h / 3]);
  }
  // each face has 4 square units: the integral of a constant over it
  CHECK(blocked_sum(triangle_masses(mesh, face)) * mesh.unit * mesh.unit == Approx(4 * (6 * 10 + 15)));
}

TEST_CASE("make_density: the reason for a missing attribute lists the existing ones") {
  PolygonMesh file = cube();
  const PreparedMesh mesh = prepare_mesh(file);
  CHECK_THROWS_WITH(make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "heat")),
                    ContainsSubstring("\"heat\"") && ContainsSubstring("no vertex attributes"));
  file.vertex_attributes = {{"red", std::vector<double>(8, 1.0)}, {"quality", std::vector<double>(8, 1.0)}};
  CHECK_THROWS_WITH(make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "heat")),
                    ContainsSubstring("\"heat\"") && ContainsSubstring("red, quality"));
  try {
    make_density(file, mesh, kind_of(DensityKind::face_attribute, "red"));
    FAIL("a face attribute was found that is not there");
  } catch (const ItemError& error) {
    CHECK(error.status() == Status::missing_attribute);
  }
}

TEST_CASE("make_density: negative, infinite and NaN values are named, unless no face uses them") {
  PolygonMesh file = cube();
  file.x.push_back(9);  // a vertex that no face uses
  file.y.push_back(9);
  file.z.push_back(9);
  const PreparedMesh mesh = prepare_mesh(file);
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, nan, infinite, -infinite, -1e-300}) {
    file.vertex_attributes = {{"weight", std::vector<double>(9, 1.0)}};
    file.vertex_attributes[0].values[8] = bad;
    CHECK_NOTHROW(make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "weight")));
    file.vertex_attributes[0].values[6] = file.vertex_attributes[0].values[3] = bad;
    CHECK_THROWS_WITH(make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "weight")),
                      ContainsSubstring("\"weight\"") && ContainsSubstring("vertex 3;"));
    file.face_attributes = {{"load", {1, 1, 1, 1, bad, 1}}};
    CHECK_THROWS_WITH(make_density(file, mesh, kind_of(DensityKind::face_attribute, "load")),
                      ContainsSubstring("\"load\"") && ContainsSubstring("face 4;"));
  }
  for (const double large : {1e39, 1e308}) {
    file.vertex_attributes = {{"weight", std::vector<double>(9, large)}};
    CHECK_THROWS_WITH(make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "weight")),
                      ContainsSubstring("too large"));
  }
}

TEST_CASE("make_density: zero everywhere is zero_density") {
  PolygonMesh file = cube();
  file.vertex_attributes = {{"weight", std::vector<double>(8, -0.0)}};
  const PreparedMesh mesh = prepare_mesh(file);
  try {
    make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "weight"));
    FAIL("a density of zero was accepted");
  } catch (const ItemError& error) {
    CHECK(error.status() == Status::zero_density);
    CHECK_THAT(error.what(), ContainsSubstring("weight"));
  }
  file.vertex_attributes[0].values[5] = 1e-9;
  CHECK_NOTHROW(make_density(file, mesh, kind_of(DensityKind::vertex_attribute, "weight")));
}
