#include "kernels/describe/depth_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kernels/core/random.h"
#include "kernels/core/rotation.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;

std::vector<float> views_of(const PolygonMesh& file) { return depth_views(prepare_mesh(file)); }

// A box of three different sides with a smaller one on it, off the middle: no symmetry, three different
// moments.
PolygonMesh stepped_block() {
  PolygonMesh low = cube(), high = cube();
  for (std::size_t v = 0; v < low.vertex_count(); ++v) {
    low.x[v] *= 2;
    low.z[v] *= 0.5;
    high.x[v] = 0.4 * high.x[v] + 1.2;
    high.y[v] = 0.5 * high.y[v] + 0.3;
    high.z[v] = 0.4 * high.z[v] + 0.9;
  }
  return merged(low, high);
}

PolygonMesh turned(const PolygonMesh& mesh, std::uint64_t number) {
  const Rotation turn = random_rotation(make_random_key(number, {}), Stream::point_set);
  PolygonMesh result = mesh;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 p = rotated(turn, {mesh.x[v], mesh.y[v], mesh.z[v]});
    result.x[v] = p.x;
    result.y[v] = p.y;
    result.z[v] = p.z;
  }
  return result;
}

double sum_of_differences(const std::vector<float>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == depth_view_values);
  REQUIRE(b.size() == depth_view_values);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(double{a[i]} - double{b[i]});
  return sum;
}

// Mean over [-1, 1] of cos(pi u t) on [-side, side].
double wave_mean(double side, int u) { return u == 0 ? side : std::sin(pi * u * side) / (pi * u); }

}  // namespace

TEST_CASE("depth views: a box in closed form") {
  PolygonMesh box = cube();
  const std::array<double, 3> half = {3, 2, 1.2};
  for (std::size_t v = 0; v < box.vertex_count(); ++v) {
    box.x[v] *= half[0];
    box.y[v] *= half[1];
    box.z[v] *= half[2];
  }
  // The mean square distance of the surface from its center, face by face.
  double area = 0, square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double a = half[(k + 1) % 3], b = half[(k + 2) % 3], face = 8 * a * b;
    area += face;
    square += face * (half[k] * half[k] + a * a / 3 + b * b / 3);
  }
  const double cube_side = 2 * std::sqrt(square / area);
  const std::vector<float> found = views_of(box);
  REQUIRE(found.size() == depth_view_values);
  // The axis of the least moment of inertia is the longest side.
  std::size_t at = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double right = half[axis == 0 ? 1 : 0] / cube_side, up = half[axis == 2 ? 1 : 2] / cube_side;
    const double depth = (1 + half[axis] / cube_side) / 2;
    for (int v = 0; v <= 8; ++v)
      for (int u = 0; u * u + v * v <= 64; ++u) {
        CAPTURE(axis, u, v);
        // Edges of the box lie up to half a pixel off.
        const double expected = depth * std::abs(wave_mean(right, u) * wave_mean(up, v));
        CHECK(double{found[at]} * double{found[at]} == Approx(expected).margin(0.012));
        CHECK(found[at + 1] == Approx(0).margin(1e-6));  // equal from both ends
        at += 2;
      }
    at += 58;  // parts
  }
}

TEST_CASE("depth views: invariant to direction, position, size, handedness and face orientation") {
  const PolygonMesh block = stepped_block();
  const std::vector<float> reference = views_of(block);
  for (std::uint64_t number = 0; number < 12; ++number)
    CHECK(sum_of_differences(views_of(turned(block, number)), reference) < 0.5);
  CHECK(sum_of_differences(views_of(moved(block, 7, 1, -2, 3)), reference) < 0.5);
  PolygonMesh mirrored = block;
  for (double& y : mirrored.y) y = -y;
  CHECK(sum_of_differences(views_of(mirrored), reference) < 0.5);
  CHECK(sum_of_differences(views_of(inside_out(block)), reference) < 1e-3);
  PolygonMesh other = block;
  for (double& z : other.z) z *= 1.3;
  CHECK(sum_of_differences(views_of(other), reference) > 2);
}

TEST_CASE("depth views: other triangles of the same surface change little") {
  const std::vector<float> coarse = views_of(torus(60, 40)), fine = views_of(torus(120, 80));
  // A torus has two equal moments: its rows depend on how it stands, so both stand alike.
  CHECK(sum_of_differences(coarse, fine) < 1);
  CHECK(sum_of_differences(coarse, views_of(icosphere(4))) > 5);
}

TEST_CASE("depth views: a sheet seen edge-on is an empty image") {
  const std::vector<float> found = views_of(grid_plane(8, 4, 2, 1));
  REQUIRE(found.size() == depth_view_values);
  const std::size_t axis = depth_view_values / 3;
  CHECK(std::all_of(found.begin(), found.begin() + 2 * axis, [](float value) { return value < 0.1f; }));
  CHECK(found[2 * axis] > 0.3f);
}

TEST_CASE("depth views: layers beyond the limit are drawn with fewer pixels") {
  // 20,000 sheets over the whole picture would be 3 x 10^8 pixels at full size.
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const double z = 1e-5 * i;
    xyz.insert(xyz.end(), {-1.2, -1, z, 1.2, -1, z, 1.2, 1, z, -1.2, 1, z});
    faces.push_back({4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
  }
  const std::vector<float> found = views_of(polygon_mesh(xyz, faces));
  PolygonMesh sheet = polygon_mesh({-1.2, -1, 0, 1.2, -1, 0, 1.2, 1, 0, -1.2, 1, 0}, {{0, 1, 2, 3}});
  // Of the last axis, the lowest frequencies.
  const std::vector<float> one = views_of(sheet);
  const std::size_t axis = 2 * depth_view_values / 3;
  CHECK(found[axis] == Approx(one[axis]).epsilon(0.1));
}

TEST_CASE("depth views: an expired deadline ends the drawing") {
  CancelToken late;
  late.deadline = std::chrono::steady_clock::time_point::min();
  CHECK_THROWS_AS(depth_views(prepare_mesh(icosphere(3)), late), ItemError);
}
