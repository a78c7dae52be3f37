#include "kernels/tensor/singularities.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <set>

#include "kernels/cut/open_seams.h"
#include "kernels/cut/topology_seams.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/tensor/make_tensor_field.h"
#include "kernels/tensor/vertex_tensors.h"
#include "kernels/unit_vector.h"
#include "support/catch.h"
#include "support/hand_charts.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// Sum of the indices (not doubled) of one component.
double index_sum(const TensorIndices& indices, const Component& component) {
  std::int64_t half_turns = 0;
  for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) {
    half_turns += indices.triangle[t];
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) half_turns += indices.edge[h];
  }
  for (std::uint32_t v = component.vertex_begin; v < component.vertex_end; ++v)
    half_turns += indices.vertex[v];
  return 0.5 * static_cast<double>(half_turns);
}

// A surface of genus 2, by marching over a grid of cubes: the faces between solid and empty cells of a slab
// with two tunnels, each cut into n x n quads and relaxed.
PolygonMesh double_torus(std::uint32_t n) {
  const auto solid = [&](int i, int j, int k) {
    const int a = static_cast<int>(n);
    if (i < 0 || j < 0 || k < 0 || i >= 5 * a || j >= 3 * a || k >= a) return false;
    return !((i / a) % 2 == 1 && j / a == 1);
  };
  const int nx = static_cast<int>(5 * n), ny = static_cast<int>(3 * n), nz = static_cast<int>(n);
  std::vector<double> xyz;
  std::vector<std::uint32_t> number(static_cast<std::size_t>((nx + 1) * (ny + 1) * (nz + 1)), no_index);
  const auto at = [&](int i, int j, int k) {
    std::uint32_t& v = number[static_cast<std::size_t>((k * (ny + 1) + j) * (nx + 1) + i)];
    if (v == no_index) {
      v = static_cast<std::uint32_t>(xyz.size() / 3);
      xyz.insert(xyz.end(), {1.0 * i / n, 1.0 * j / n, 1.0 * k / n});
    }
    return v;
  };
  std::vector<std::vector<std::uint32_t>> faces;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        if (!solid(i, j, k)) continue;
        if (!solid(i + 1, j, k))
          faces.push_back(
              {at(i + 1, j, k), at(i + 1, j + 1, k), at(i + 1, j + 1, k + 1), at(i + 1, j, k + 1)});
        if (!solid(i - 1, j, k))
          faces.push_back({at(i, j, k), at(i, j, k + 1), at(i, j + 1, k + 1), at(i, j + 1, k)});
        if (!solid(i, j + 1, k))
          faces.push_back(
              {at(i, j + 1, k), at(i, j + 1, k + 1), at(i + 1, j + 1, k + 1), at(i + 1, j + 1, k)});
        if (!solid(i, j - 1, k))
          faces.push_back({at(i, j, k), at(i + 1, j, k), at(i + 1, j, k + 1), at(i, j, k + 1)});
        if (!solid(i, j, k + 1))
          faces.push_back(
              {at(i, j, k + 1), at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)});
        if (!solid(i, j, k - 1))
          faces.push_back({at(i, j, k), at(i, j + 1, k), at(i + 1, j + 1, k), at(i + 1, j, k)});
      }
  PolygonMesh mesh = polygon_mesh(xyz, faces);
  for (int round = 0; round < 6; ++round) {
    std::vector<Vector3> sum(mesh.x.size());
    std::vector<double> count(mesh.x.size(), 0.0);
    for (std::size_t c = 0; c < mesh.corners.size(); ++c) {
      const std::uint32_t v = mesh.corners[c], w = mesh.corners[c % 4 == 3 ? c - 3 : c + 1];
      for (const auto& [a, b] : {std::pair{v, w}, std::pair{w, v}}) {
        sum[a] = sum[a] + Vector3{mesh.x[b], mesh.y[b], mesh.z[b]};
        count[a] += 1;
      }
    }
    for (std::size_t v = 0; v < count.size(); ++v) {
      mesh.x[v] = 0.5 * mesh.x[v] + 0.5 * sum[v].x / count[v];
      mesh.y[v] = 0.5 * mesh.y[v] + 0.5 * sum[v].y / count[v];
      mesh.z[v] = 0.5 * mesh.z[v] + 0.5 * sum[v].z / count[v];
    }
  }
  return mesh;
}

// Spacings 2 and 1/2, primary along the tangent part of a direction that depends on the place.
TensorField directed(const PreparedMesh& mesh, const std::function<Vector3(Vector3)>& direction) {
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  std::vector<TangentTensor> values(mesh.vertex_count());
  for (std::uint32_t v = 0; v < values.size(); ++v) {
    const Vector3 d = direction(mesh.center + mesh.unit * mesh.position(v));
    const double x = dot(d, frames[v].x), y = dot(d, frames[v].y), size = std::hypot(x, y);
    if (size > 1e-12) values[v] = tensor_of({std::log(2.0), -std::log(2.0), x / size, y / size});
  }
  return field_from_vertices(mesh, frames, values);
}

// log S linear in the plane: deviator (a, b) . (x - x0, y - y0). Index + 1/2 or - 1/2 at (x0, y0).
TensorField planar(const PreparedMesh& mesh,
                   const std::function<std::pair<double, double>(double, double)>& f) {
  const std::vector<TangentFrame> frames(mesh.vertex_count(), TangentFrame{});
  std::vector<TangentTensor> values(mesh.vertex_count());
  for (std::uint32_t v = 0; v < values.size(); ++v) {
    const Vector3 p = mesh.center + mesh.unit * mesh.position(v);
    const auto [a, b] = f(p.x, p.y);
    values[v] = {a, b, -a};
  }
  return field_from_vertices(mesh, frames, values);
}

TensorField random_field(const PreparedMesh& mesh, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  TensorField field;
  field.corner.resize(mesh.triangles.size());
  for (TangentTensor& t : field.corner) t = {normal(random), normal(random), normal(random)};
  return field;
}

void check_sums(const PreparedMesh& mesh, const TensorField& field) {
  const TensorIndices indices = tensor_indices(mesh, field);
  for (const Component& component : mesh.components) {
    REQUIRE(component.boundary_loops == 0);
    CHECK(index_sum(indices, component) == 2.0 - 2.0 * component.genus);
  }
  double listed = 0, wanted = 0;
  for (const Singularity& s : find_singularities(mesh, field, false)) listed += 0.5 * s.half_turns;
  for (const Component& component : mesh.components) wanted += 2.0 - 2.0 * component.genus;
  CHECK(listed == wanted);
}

std::int32_t total(const std::vector<Singularity>& list) {
  std::int32_t sum = 0;
  for (const Singularity& s : list) sum += s.half_turns;
  return sum;
}

// After opening the cuts (and the seams that topology needs), whether signs of e1 can be chosen triangle by
// triangle so that all uncut edges agree.
bool can_be_combed(const PreparedMesh& mesh, const TensorField& field,
                   const std::vector<std::uint32_t>& cuts) {
  std::vector<std::uint8_t> cut(mesh.triangles.size(), 0);
  for (const std::uint32_t h : cuts) cut[h] = cut[mesh.opposite[h]] = 1;
  std::vector<Vector3> e1(mesh.triangle_count());
  std::vector<std::uint8_t> seen(mesh.triangle_count(), 0);
  const TensorField mean = mean_on_triangles(field);
  for (std::uint32_t t = 0; t < e1.size(); ++t) {
    const TangentFrame frame = triangle_frame(mesh, t);
    const TensorAxes axes = tensor_axes(mean.corner[3 * t]);
    e1[t] = axes.x * frame.x + axes.y * frame.y;
  }
  for (std::uint32_t start = 0; start < e1.size(); ++start) {
    if (seen[start]) continue;
    seen[start] = 1;
    std::vector<std::uint32_t> queue = {start};
    while (!queue.empty()) {
      const std::uint32_t t = queue.back();
      queue.pop_back();
      const TangentFrame from = triangle_frame(mesh, t);
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const std::uint32_t o = mesh.opposite[h];
        if (o == no_index || cut[h]) continue;
        const TangentFrame to = triangle_frame(mesh, o / 3);
        const double agree = dot(transport(e1[t], from.normal, to.normal), e1[o / 3]);
        if (seen[o / 3]) {
          if (agree < -1e-9) return false;
          continue;
        }
        if (agree < 0) e1[o / 3] = -1.0 * e1[o / 3];
        seen[o / 3] = 1;
        queue.push_back(o / 3);
      }
    }
  }
  return true;
}

}  // namespace

TEST_CASE("tensor_indices: sum to the Euler characteristic on closed surfaces, whatever the field") {
  const PolygonMesh eight = double_torus(3);
  REQUIRE(prepare_mesh(eight).components.at(0).genus == 2);
  const PolygonMesh both = merged(icosphere(2), moved(torus(20, 10), 1, 5, 0, 0));
  for (const PolygonMesh& file :
       {tetrahedron(), cube(), icosphere(3), torus(40, 20), eight, both, two_sided_plate(6, 1e-3)}) {
    const PreparedMesh mesh = prepare_mesh(file);
    TensorParameters curvature;
    check_sums(mesh, make_tensor_field(file, mesh, curvature));
    check_sums(mesh, directed(mesh, [](Vector3 p) { return Vector3{-p.y, p.x, 0.2}; }));
    check_sums(mesh, directed(mesh, [](Vector3 p) { return Vector3{p.z * p.z - p.x, p.x * p.y, 1 - p.x}; }));
    check_sums(mesh, random_field(mesh, 1));
    check_sums(mesh, mean_on_triangles(random_field(mesh, 2)));
    TensorField none;
    none.corner.resize(mesh.triangles.size());
    check_sums(mesh, none);
    CHECK(find_singularities(mesh, none).empty());
  }
}

TEST_CASE("tensor_indices: zero-area triangles do not change the sum") {
  // A tetrahedron with a vertex in the middle of one edge for one of its sides only: a triangle of no area
  // fills the gap.
  const PolygonMesh file = polygon_mesh({1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1, 1, 0, 0},
                                        {{0, 4, 2}, {4, 1, 2}, {0, 3, 1}, {0, 1, 4}, {0, 2, 3}, {1, 3, 2}});
  const PreparedMesh mesh = prepare_mesh(file);
  REQUIRE(std::count(mesh.area.begin(), mesh.area.end(), 0.0) == 1);
  check_sums(mesh, directed(mesh, [](Vector3 p) { return Vector3{1, p.x, 0.3}; }));
  check_sums(mesh, make_tensor_field(file, mesh, {}));
}

TEST_CASE("find_singularities: a wedge and a trisector in the plane are found in place") {
  for (const int sign : {1, -1})
    for (const std::uint32_t n : {10u, 37u}) {
      const PreparedMesh mesh = prepare_mesh(grid_plane(n, n));
      const double x0 = 0.523, y0 = 0.341;
      const TensorField field = planar(mesh, [&](double x, double y) {
        return std::pair{x - x0, sign * (y - y0)};
      });
      const std::vector<Singularity> list = find_singularities(mesh, field, false);
      REQUIRE(list.size() == 1);
      CHECK(list[0].place == SingularityPlace::triangle);
      CHECK(list[0].half_turns == sign);
      const Vector3 at = mesh.center + mesh.unit * list[0].position;
      CHECK(at.x == Approx(x0));
      CHECK(at.y == Approx(y0));
    }
}

TEST_CASE("find_singularities: a center has index 1, a quadratic field index 1, a saddle index -1") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(31, 31));
  const auto about = [&](double x, double y) { return std::pair{x - 0.513, y - 0.487}; };
  const TensorField center = directed(mesh, [&](Vector3 p) {
    const auto [x, y] = about(p.x, p.y);
    return Vector3{-y, x, 0};
  });
  CHECK(total(find_singularities(mesh, center)) == 2);
  const TensorField saddle = directed(mesh, [&](Vector3 p) {
    const auto [x, y] = about(p.x, p.y);
    return Vector3{x, -y, 0};
  });
  CHECK(total(find_singularities(mesh, saddle)) == -2);
  const TensorField constant = directed(mesh, [](Vector3) { return Vector3{1, 2, 0}; });
  CHECK(find_singularities(mesh, constant, false).empty());
}

TEST_CASE("find_singularities: parallels of the sphere have two centers, the torus none") {
  const PreparedMesh sphere = prepare_mesh(moved(icosphere(4), 1, 0, 0, 0));
  const Vector3 pole = unit({0.3, 0.5, 0.8});
  const TensorField parallels = directed(sphere, [&](Vector3 p) { return cross(pole, p); });
  const std::vector<Singularity> list = find_singularities(sphere, parallels);
  CHECK(total(list) == 4);
  for (const Singularity& s : list) {
    CHECK(s.half_turns > 0);
    CHECK(std::abs(dot(unit(s.position), pole)) > 0.99);
  }
  const PolygonMesh file = torus(60, 30);
  const PreparedMesh ring = prepare_mesh(file);
  CHECK(find_singularities(ring, make_tensor_field(file, ring, {}), false).empty());
}

TEST_CASE("find_singularities: the four umbilics of an ellipsoid are wedges in place") {
  const double a = 1.5, b = 1.1, c = 0.7;
  PolygonMesh file = icosphere(5);
  for (std::size_t i = 0; i < file.x.size(); ++i) {
    file.x[i] *= a;
    file.y[i] *= b;
    file.z[i] *= c;
  }
  const PreparedMesh mesh = prepare_mesh(file);
  const std::vector<Singularity> list = find_singularities(mesh, make_tensor_field(file, mesh, {}));
  CHECK(total(list) == 4);
  // In the plane of the longest and shortest axes.
  const double x = a * std::sqrt((a * a - b * b) / (a * a - c * c));
  const double z = c * std::sqrt((b * b - c * c) / (a * a - c * c));
  for (const double sx : {-1.0, 1.0})
    for (const double sz : {-1.0, 1.0}) {
      std::int32_t near = 0;
      for (const Singularity& s : list)
        if (distance(mesh.center + mesh.unit * s.position, {sx * x, 0, sz * z}) < 0.1) near += s.half_turns;
      CHECK(near == 1);
    }
}

TEST_CASE("find_singularities: isotropic regions keep only the rotation of the surrounding field") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(40, 40));
  const auto field = [&](bool turning) {
    return planar(mesh, [&](double x, double y) {
      const double dx = x - 0.51, dy = y - 0.49;
      if (std::hypot(dx, dy) < 0.2)
        return std::pair{1e-3 * std::sin(90 * x), 1e-3 * std::cos(70 * y + 80 * x)};
      return turning ? std::pair{dx, dy} : std::pair{1.0, 0.3 + 0.1 * dx};
    });
  };
  CHECK(find_singularities(mesh, field(false), false).size() > 4);
  CHECK(find_singularities(mesh, field(false), true).empty());
  const std::vector<Singularity> list = find_singularities(mesh, field(true), true);
  CHECK(total(list) == 1);
  // Fields without any deviator inside are filled from the rim: one singularity alone.
  const TensorField hole = planar(mesh, [&](double x, double y) {
    const double dx = x - 0.51, dy = y - 0.49;
    return std::hypot(dx, dy) < 0.2 ? std::pair{0.0, 0.0} : std::pair{dx, dy};
  });
  REQUIRE(find_singularities(mesh, hole, true).size() == 1);
  CHECK(norm(mesh.center + mesh.unit * find_singularities(mesh, hole, true)[0].position -
             Vector3{0.51, 0.49, 0}) < 0.2);
}

TEST_CASE("connect_singularities: two wedges are joined, one is connected to the boundary") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(40, 40));
  // Deviators multiply like complex numbers: indices add.
  const auto pair = [&](double x, double y) {
    const double ax = x - 0.3, bx = x - 0.7, dy = y - 0.51;
    return std::pair{ax * bx - dy * dy, ax * dy + bx * dy};
  };
  const TensorField two = mean_on_triangles(planar(mesh, pair));
  const std::vector<Singularity> list = find_singularities(mesh, two, false);
  REQUIRE(list.size() == 2);
  CHECK(list[0].place == SingularityPlace::vertex);
  const std::vector<std::uint32_t> cuts = connect_singularities(mesh, two, list);
  CHECK(!can_be_combed(mesh, two, {}));
  CHECK(can_be_combed(mesh, two, cuts));
  double length = 0;
  for (const std::uint32_t h : cuts) length += mesh.unit * mesh.length_in_space(h);
  CHECK(length > 0.4 - 0.06);
  CHECK(length < 0.62);  // together, or each 0.3 to the boundary

  const TensorField one = mean_on_triangles(planar(mesh, [](double x, double y) {
    return std::pair{x - 0.21, y - 0.51};
  }));
  const std::vector<std::uint32_t> cut =
      connect_singularities(mesh, one, find_singularities(mesh, one, false), {0});
  length = 0;
  for (const std::uint32_t h : cut) length += mesh.unit * mesh.length_in_space(h);
  CHECK(length == Approx(0.21).margin(0.026));
  CHECK(can_be_combed(mesh, one, cut));
  CHECK(connect_singularities(mesh, one, {}).empty());
}

TEST_CASE("connect_singularities: closed surfaces can be combed after these cuts and those of topology") {
  int combed = 0;
  const PolygonMesh eight = double_torus(3);
  PolygonMesh egg = icosphere(3);
  for (double& x : egg.x) x *= 1.7;
  for (double& z : egg.z) z *= 0.6;
  for (const PolygonMesh& file : {egg, eight, cube(), icosphere(2)})
    for (const int kind : {0, 1}) {
      const PreparedMesh mesh = prepare_mesh(file);
      const TensorField field =
          mean_on_triangles(kind == 0 ? make_tensor_field(file, mesh, {}) : directed(mesh, [](Vector3 p) {
            return Vector3{p.y + 0.1, p.z - p.x, 0.3 + p.x};
          }));
      const std::vector<Singularity> list = find_singularities(mesh, field, false);
      for (const Singularity& s : list) CHECK(s.place == SingularityPlace::vertex);
      const std::vector<std::uint32_t> cuts = connect_singularities(mesh, field, list);
      // No cycle: edges = vertices - trees, and every set of cuts has a whole sum.
      std::vector<std::uint32_t> parent(mesh.vertex_count());
      for (std::uint32_t v = 0; v < parent.size(); ++v) parent[v] = v;
      const auto find = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
      };
      for (const std::uint32_t h : cuts) {
        const std::uint32_t a = find(mesh.triangles[h]), b = find(mesh.triangles[next_half_edge(h)]);
        CHECK(a != b);
        parent[a] = b;
      }
      CAPTURE(file.vertex_count(), kind, list.size(), cuts.size());
      std::vector<std::int32_t> sum(parent.size(), 0);
      for (const Singularity& s : list) sum[find(s.vertex)] += s.half_turns;
      for (const std::int32_t s : sum) CHECK(s % 2 == 0);
      // Triangles without a direction (of the cube) have no direction to comb.
      const bool directed_everywhere =
          std::all_of(field.corner.begin(), field.corner.end(),
                      [](TangentTensor t) { return std::hypot(t.xx - t.yy, t.xy) > 1e-9; });
      if (mesh.components[0].genus == 0 && directed_everywhere) {
        CHECK(can_be_combed(mesh, field, cuts));
        ++combed;
      }
    }
  CHECK(combed >= 3);
}
