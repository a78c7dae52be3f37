#include "kernels/analyse/mesh_distance.h"

#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/chi_square.h"
#include "kernels/core/status.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// A polygon mesh as triangles.
struct Surface {
  PolygonMesh mesh;
  std::vector<std::uint32_t> triangles;

  explicit Surface(PolygonMesh polygons) : mesh(std::move(polygons)) {
    for (std::size_t p = 0; p < mesh.polygon_count(); ++p)
      for (std::uint32_t c = mesh.polygon_begin[p] + 1; c + 1 < mesh.polygon_begin[p + 1]; ++c)
        triangles.insert(triangles.end(),
                         {mesh.corners[mesh.polygon_begin[p]], mesh.corners[c], mesh.corners[c + 1]});
  }
  TriangleSpans spans() const { return {mesh.x, mesh.y, mesh.z, triangles}; }
};

MeshDistance measure(const Surface& a, const Surface& b, const MeshDistanceParameters& parameters = {}) {
  static const EmbreeDevice device;
  return mesh_distance(device, a.spans(), b.spans(), parameters);
}

MeshDistanceParameters samples(std::uint64_t count) {
  MeshDistanceParameters parameters;
  parameters.samples = count;
  return parameters;
}

}  // namespace

TEST_CASE("mesh_distance: a mesh has distance 0 to itself") {
  for (const PolygonMesh& mesh :
       {icosphere(2), torus(20, 12), cube(), moved(torus(20, 12), 1e-20, 0, 0, 0)}) {
    const Surface surface(mesh);
    const MeshDistance found = measure(surface, surface, samples(5000));
    CHECK(found.forward.max <= 1e-15 * found.diagonal);
    CHECK(found.backward.max <= 1e-15 * found.diagonal);
    CHECK(found.forward.mean <= 3e-16 * found.diagonal);
    CHECK(found.forward.samples == 5000);
  }
}

TEST_CASE("mesh_distance: parallel planes have their distance") {
  const Surface low(grid_plane(7, 5));
  PolygonMesh raised = grid_plane(3, 4);
  for (double& z : raised.z) z += 0.125;
  const Surface high(raised);
  const MeshDistance found = measure(low, high);
  CHECK(found.diagonal == Approx(std::sqrt(2.0)));
  for (const OneSidedDistance& side : {found.forward, found.backward}) {
    CHECK(side.mean == Approx(0.125).epsilon(1e-14));
    CHECK(side.rms == Approx(0.125).epsilon(1e-14));
    CHECK(side.max == Approx(0.125).epsilon(1e-14));
    CHECK(side.samples == 50000);  // 100,000 a squared diagonal of 2
  }
  CHECK(found.forward.vertices == 48);
  CHECK(found.backward.vertices == 20);
  CHECK(found.percent(found.max()) == Approx(12.5 / std::sqrt(2.0)));
}

TEST_CASE("mesh_distance: crossing planes, where mean, RMS and max differ") {
  // z = 0 and z = x / 4 over the unit square. From the lower one the nearest point of the slope is along its
  // normal: distance x sin(atan(1/4)), for every x (the foot x cos^2 stays on the slope).
  const Surface flat(grid_plane(4, 4));
  PolygonMesh tilted = grid_plane(4, 4);
  for (std::size_t v = 0; v < tilted.x.size(); ++v) tilted.z[v] = 0.25 * tilted.x[v];
  const Surface slope(tilted);
  const MeshDistance found = measure(flat, slope, samples(40000));
  const double sine = 0.25 / std::sqrt(1.0625);
  CHECK(found.forward.mean == Approx(0.5 * sine).epsilon(1e-4));
  CHECK(found.forward.rms == Approx(sine / std::sqrt(3.0)).epsilon(1e-4));
  CHECK(found.forward.max == Approx(sine).epsilon(1e-14));
  CHECK(found.forward.farthest.x == 1);
  // The other way the foot is straight below: z.
  CHECK(found.backward.mean == Approx(0.125).epsilon(1e-4));
  CHECK(found.backward.rms == Approx(0.25 / std::sqrt(3.0)).epsilon(1e-4));
  CHECK(found.backward.max == 0.25);
}

TEST_CASE("mesh_distance: the two directions differ if one surface is part of the other") {
  const Surface whole(grid_plane(8, 8, 2, 1)), part(grid_plane(3, 3, 1, 1));
  const MeshDistance found = measure(part, whole, samples(20000));
  CHECK(found.forward.max < 1e-15);
  CHECK(found.backward.max == Approx(1));                    // the far edge, a unit away
  CHECK(found.backward.mean == Approx(0.25).epsilon(1e-3));  // half is 0, the other half 1/2 on average
  CHECK(found.backward.rms == Approx(std::sqrt(1.0 / 6)).epsilon(1e-3));
  CHECK(found.max() == found.backward.max);
  const MeshDistance swapped = measure(whole, part, samples(20000));
  CHECK(swapped.forward.mean == found.backward.mean);
  CHECK(swapped.forward.rms == found.backward.rms);
  CHECK(swapped.backward.max == found.forward.max);
  CHECK(swapped.diagonal == Approx(std::sqrt(5.0)));
  CHECK(found.diagonal == Approx(std::sqrt(2.0)));
}

TEST_CASE("mesh_distance: concentric spheres have the difference of their radii") {
  // Polyhedra with edges below 0.083 of the radius: up to 1.2e-3 (h^2 / 6) of it inside
  // their spheres.
  const Surface inner(icosphere(4)), outer(icosphere(4, 1.25));
  const MeshDistance found = measure(inner, outer, samples(20000));
  for (const OneSidedDistance& side : {found.forward, found.backward}) {
    CHECK(side.mean == Approx(0.25).margin(1.2e-3));
    CHECK(side.rms == Approx(0.25).margin(1.2e-3));
    CHECK(side.max == Approx(0.25).margin(1.5e-3));
  }
  CHECK(found.diagonal == Approx(2 * std::sqrt(3.0)).epsilon(1e-3));
}

TEST_CASE("mesh_distance: a coarse sphere inside a fine one") {
  // The distance to the sphere from an inscribed polyhedron of small equilateral triangles with edge h is
  // h^2 / (8 R) on average and h^2 / (6 R) at most (docs/METHODS.md 11). The 1280 triangles are nearly so:
  // their mean squared edge is 4 / sqrt(3) of the mean area.
  const Surface coarse(icosphere(3)), fine(icosphere(5));
  const MeshDistance found = measure(coarse, fine, samples(20000));
  const double squared_edge = 4 / std::sqrt(3.0) * 4 * std::numbers::pi / 1280;
  // The fine one lies 1/16 of that inside the sphere itself.
  CHECK(found.forward.mean == Approx(squared_edge / 8 * (1 - 1.0 / 16)).epsilon(0.05));
  CHECK(found.forward.max > squared_edge / 6 * 0.9);
  CHECK(found.forward.max < squared_edge / 6 * 1.3);
  CHECK(found.backward.mean == Approx(found.forward.mean).epsilon(0.05));
}

TEST_CASE("mesh_distance: invariant to motion, and scales with the unit") {
  const PolygonMesh a = torus(20, 12), b = icosphere(2, 1.2);
  const MeshDistance plain = measure(Surface(a), Surface(b), samples(20000));
  for (const double scale : {1e-12, 1.0, 1e30}) {
    const double shift = 3 * scale;
    const MeshDistance found = measure(Surface(moved(a, scale, shift, -shift, 2 * shift)),
                                       Surface(moved(b, scale, shift, -shift, 2 * shift)), samples(20000));
    // The samples themselves are others: the box, and with it the order of the triangles, turned.
    CHECK(found.forward.mean == Approx(scale * plain.forward.mean).epsilon(2e-3));
    CHECK(found.forward.rms == Approx(scale * plain.forward.rms).epsilon(2e-3));
    CHECK(found.forward.max == Approx(scale * plain.forward.max).epsilon(2e-3));
    CHECK(found.backward.mean == Approx(scale * plain.backward.mean).epsilon(2e-3));
    CHECK(found.backward.max == Approx(scale * plain.backward.max).epsilon(2e-3));
  }
  // A power of two without a turn: the same bits.
  PolygonMesh a2 = a, b2 = b;
  for (PolygonMesh* mesh : {&a2, &b2})
    for (auto* axis : {&mesh->x, &mesh->y, &mesh->z})
      for (double& value : *axis) value *= 1024;
  const MeshDistance doubled = measure(Surface(a2), Surface(b2), samples(20000));
  CHECK(doubled.forward.mean == 1024 * plain.forward.mean);
  CHECK(doubled.backward.rms == 1024 * plain.backward.rms);
}

TEST_CASE("mesh_distance: more samples converge, the seed matters little", "[statistics]") {
  const Surface a(torus(20, 12)), b(icosphere(2, 1.2));
  const double exact = measure(a, b, samples(400000)).forward.mean;
  double worst[2] = {0, 0};
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    for (int k = 0; k < 2; ++k) {
      MeshDistanceParameters parameters = samples(k == 0 ? 1000 : 16000);
      parameters.seed = seed;
      worst[k] = std::max(worst[k], std::abs(measure(a, b, parameters).forward.mean / exact - 1));
    }
  CHECK(worst[0] < 0.025);  // 480 triangles: two samples each
  CHECK(worst[1] < 1e-3);
  CHECK(worst[0] > 0);
}

TEST_CASE("mesh_distance: one thread and many give the same bits") {
  const Surface a(torus(20, 12)), b(icosphere(2, 1.2));
  const MeshDistance many = measure(a, b, samples(40000));
  MeshDistance one;
  oneapi::tbb::task_arena(1).execute([&] { one = measure(a, b, samples(40000)); });
  CHECK(one.forward.mean == many.forward.mean);
  CHECK(one.forward.rms == many.forward.rms);
  CHECK(one.backward.mean == many.backward.mean);
  CHECK(one.backward.max == many.backward.max);
}

TEST_CASE("area_samples: uniform by area, exact in number, pure in the seed") {
  // A plane with triangles of very different size: columns of width 2^-k.
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t k = 0; k <= 8; ++k) {
    const double x = k == 8 ? 0 : std::ldexp(1.0, -static_cast<int>(k));
    xyz.insert(xyz.end(), {x, 0, 0, x, 1, 0});
    if (k > 0) faces.push_back({2 * k - 2, 2 * k - 1, 2 * k + 1, 2 * k});
  }
  faces.push_back({0, 0, 1});  // no area: never sampled
  const Surface plane(polygon_mesh(xyz, faces));
  constexpr std::size_t n = 20000;
  const std::vector<double> points = area_samples(plane.spans(), n, 3);
  REQUIRE(points.size() == 3 * n);
  CHECK(points == area_samples(plane.spans(), n, 3));
  CHECK(points != area_samples(plane.spans(), n, 4));
  CHECK(area_samples(plane.spans(), 0, 3).empty());
  std::vector<std::uint64_t> counts(64, 0);
  for (std::size_t i = 0; i < n; ++i) {
    CHECK(points[3 * i + 2] == 0);
    const double x = points[3 * i], y = points[3 * i + 1];
    REQUIRE((x >= 0 && x <= 1 && y >= 0 && y <= 1));
    ++counts[8 * std::min<std::size_t>(7, static_cast<std::size_t>(8 * x)) +
             std::min<std::size_t>(7, static_cast<std::size_t>(8 * y))];
  }
  const ChiSquare uniform = chi_square_test(counts, std::vector<double>(64, 1));
  CHECK(uniform.statistic < 32);  // 63 for random points
  // Few samples on many triangles, over seeds: every column by its area still.
  std::vector<std::uint64_t> columns(4, 0);
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const std::vector<double> few = area_samples(plane.spans(), 3, seed);
    for (std::size_t i = 0; i < 3; ++i)
      ++columns[few[3 * i] > 0.5 ? 0 : few[3 * i] > 0.25 ? 1 : few[3 * i] > 0.125 ? 2 : 3];
  }
  CHECK(chi_square_test(columns, std::vector<double>{0.5, 0.25, 0.125, 0.125}).p_value > 1e-3);
}

TEST_CASE("mesh_distance: invalid arguments are refused") {
  const Surface good(cube()), flat(polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0}, {{0, 1, 2}}));
  CHECK_THROWS_AS(measure(good, flat), ItemError);
  CHECK_THROWS_AS(measure(good, Surface(PolygonMesh{})), std::invalid_argument);
  MeshDistanceParameters parameters;
  parameters.density = 1e12;
  CHECK_THROWS_AS(measure(good, good, parameters), std::invalid_argument);
  parameters.density = std::nan("");
  CHECK(measure(good, good, samples(1)).forward.samples == 1);
}
