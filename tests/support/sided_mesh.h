// Meshes with all that sides are told by, points around them, and damage.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/surface_sides.h"
#include "support/catch.h"
#include "support/test_meshes.h"

namespace meander::test {

// A mesh with all that sides are told by.
struct SidedMesh {
  PreparedMesh mesh;
  TriangleTree tree;
  OrientedSurface oriented;
  SignRule rule = SignRule::none;

  explicit SidedMesh(PolygonMesh file) {
    drop_doubled_faces(file);
    mesh = prepare_mesh(file);
    tree = build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
    oriented = orient_outward(mesh);
    rule = sign_rule(mesh, tree, oriented);
  }
  PointSides sides(std::span<const double> points) const {
    return label_points(tree, oriented, rule, points).sides;
  }
  // In file coordinates.
  std::vector<double> working(std::span<const double> points) const {
    std::vector<double> out(points.begin(), points.end());
    const double center[3] = {mesh.center.x, mesh.center.y, mesh.center.z};
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = (out[i] - center[i % 3]) / mesh.unit;
    return out;
  }
  double winding_at(Vector3 file) const {
    const PointSides found = sides(working(std::vector<double>{file.x, file.y, file.z}));
    CHECK(found.certain[0] == 1);
    CHECK(found.inside[0] == (std::abs(found.winding[0]) >= 0.5));
    return found.winding[0];
  }
};

// Near the surface and in the box around it, in the coordinates of `of`.
inline std::vector<double> side_points(const PreparedMesh& of, std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<double> points;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i), v = random_pair(key, Stream::sequence, i, 1);
    const Vector3 in_box{2 * u.first - 1, 2 * u.second - 1, 2 * v.first - 1};
    const auto t = static_cast<std::size_t>(v.second * static_cast<double>(of.triangle_count()));
    const Vector3 p = i % 3 == 0 ? in_box : of.centroid(t) + (i % 3 == 1 ? 0.02 : 0.1) * in_box;
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  return points;
}

inline PolygonMesh sphere(double radius, double x = 0) { return moved(icosphere(2), radius, x, 0, 0); }

inline void remove_polygons(PolygonMesh& mesh, const std::vector<std::uint8_t>& removed) {
  std::vector<std::uint32_t> begin{0}, corners;
  for (std::uint32_t p = 0; p < mesh.polygon_count(); ++p) {
    if (removed[p] == 0)
      corners.insert(corners.end(), mesh.corners.begin() + mesh.polygon_begin[p],
                     mesh.corners.begin() + mesh.polygon_begin[p + 1]);
    begin.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  mesh.polygon_begin = begin;
  mesh.corners = corners;
  mesh.corner_normals.clear();
  mesh.coordinates.corner.clear();
}

// Without balls of triangles around some of them, until that share of the area is gone. size: their radius,
// over that of a side of a cube of the same area. Numbers of triangles stay.
inline PolygonMesh with_holes(const PolygonMesh& file, double share, std::uint64_t seed, double size = 0.17) {
  const PreparedMesh mesh = prepare_mesh(file);
  PolygonMesh out;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 p = mesh.center + mesh.unit * mesh.position(v);
    out.x.push_back(p.x);
    out.y.push_back(p.y);
    out.z.push_back(p.z);
  }
  out.corners = mesh.triangles;
  for (std::uint32_t t = 0; t <= mesh.triangle_count(); ++t) out.polygon_begin.push_back(3 * t);
  std::vector<std::uint8_t> removed(mesh.triangle_count(), 0);
  const RandomKey key = make_random_key(seed, {});
  double gone = 0;
  for (std::uint64_t hole = 0; hole < 200 && gone < share * mesh.total_area; ++hole) {
    const double u = random_pair(key, Stream::sequence, hole).first;
    const Vector3 middle =
        mesh.centroid(static_cast<std::size_t>(u * static_cast<double>(mesh.triangle_count())));
    const double radius = size * std::sqrt(mesh.total_area / 24);
    for (std::size_t t = 0; t < removed.size() && gone < share * mesh.total_area; ++t) {
      if (removed[t] != 0 || distance(mesh.centroid(t), middle) > radius) continue;
      removed[t] = 1;
      gone += mesh.area[t];
    }
  }
  remove_polygons(out, removed);
  return out;
}

struct Disagreement {
  double certain_wrong = 0, uncertain = 0;  // shares of the points
};

// Against the sides that the undamaged model has.
inline Disagreement compare(const SidedMesh& damaged, const SidedMesh& whole, std::size_t count) {
  const std::vector<double> in_whole = side_points(whole.mesh, count, 31);
  std::vector<double> file(in_whole.size());
  const double center[3] = {whole.mesh.center.x, whole.mesh.center.y, whole.mesh.center.z};
  for (std::size_t i = 0; i < file.size(); ++i) file[i] = center[i % 3] + whole.mesh.unit * in_whole[i];
  const PointSides truth = whole.sides(in_whole), found = damaged.sides(damaged.working(file));
  Disagreement result;
  for (std::size_t i = 0; i < count; ++i) {
    result.uncertain += found.certain[i] == 0;
    result.certain_wrong += found.certain[i] != 0 && found.inside[i] != truth.inside[i];
  }
  result.uncertain /= static_cast<double>(count);
  result.certain_wrong /= static_cast<double>(count);
  return result;
}

}  // namespace meander::test
