// Gathers at every vertex from the triangles around it, so that no two threads add to one number.
#include "kernels/density/curvature.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/mesh/vertex_corners.h"

namespace meander {

namespace {

constexpr std::size_t vertex_block = 2048;
constexpr double least_area_share = 1e-6;
constexpr int fill_rounds = 64;

// Contribution of one triangle to the vertex at its corner.
struct CornerShare {
  double angle = 0;
  Vector3 area_gradient;
};

CornerShare corner_share(Vector3 p, Vector3 q, Vector3 r, double area) {
  const Vector3 to_q = q - p, to_r = r - p;
  const Vector3 normal = cross(to_q, to_r);
  const double twice_area = norm(normal);
  CornerShare share;
  share.angle = portable::atan2(twice_area, dot(to_q, to_r));
  if (area > 0 && twice_area > 0) share.area_gradient = (0.5 / twice_area) * cross(normal, r - q);
  return share;
}

// Mean over the neighbors that had a value before this round.
void fill_unknown(const PreparedMesh& mesh, const VertexCorners& around, std::vector<std::uint8_t>& known,
                  VertexCurvature& curvature) {
  std::vector<std::uint32_t> unknown;
  for (std::uint32_t v = 0; v < known.size(); ++v)
    if (known[v] == 0) unknown.push_back(v);
  struct Value {
    double mean = 0, gaussian = 0, count = 0;
  };
  std::vector<Value> value(unknown.size());
  for (int round = 0; round < fill_rounds && !unknown.empty(); ++round) {
    parallel_blocks(unknown.size(), vertex_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        value[i] = {};
        const std::uint32_t v = unknown[i];
        for (const std::uint32_t h : around.of(v)) {
          for (const std::uint32_t other : {next_half_edge(h), previous_half_edge(h)}) {
            const std::uint32_t w = mesh.triangles[other];
            if (known[w] == 0) continue;
            value[i].mean += curvature.mean[w];
            value[i].gaussian += curvature.gaussian[w];
            value[i].count += 1;
          }
        }
      }
    });
    std::size_t left = 0;
    for (std::size_t i = 0; i < unknown.size(); ++i) {
      const std::uint32_t v = unknown[i];
      if (value[i].count == 0) {
        unknown[left++] = v;
        continue;
      }
      curvature.mean[v] = value[i].mean / value[i].count;
      curvature.gaussian[v] = value[i].gaussian / value[i].count;
      known[v] = 1;
    }
    if (left == unknown.size()) break;
    unknown.resize(left);
  }
}

}  // namespace

double mixed_area_share(Vector3 p, Vector3 q, Vector3 r, double area) {
  if (!(area > 0)) return 0;
  const Vector3 to_q = q - p, to_r = r - p, across = r - q;
  const double at_p = dot(to_q, to_r), at_q = -dot(to_q, across), at_r = dot(to_r, across);
  if (at_p < 0) return area / 2;
  if (at_q < 0 || at_r < 0) return area / 4;
  // Voronoi area: (cot r |pq|^2 + cot q |pr|^2) / 8, with cot = dot / (2 area)
  return (dot(to_q, to_q) * at_r + dot(to_r, to_r) * at_q) / (16 * area);
}

VertexCurvature vertex_curvature(const PreparedMesh& mesh, const CancelToken& cancel) {
  const std::size_t vertices = mesh.vertex_count();
  const VertexCorners around(mesh);
  cancel.check();
  VertexCurvature result;
  result.mixed_area.assign(vertices, 0.0);
  result.mean.assign(vertices, 0.0);
  result.gaussian.assign(vertices, 0.0);
  std::vector<std::uint8_t> known(vertices, 0);

  const double least_area = least_area_share * mesh.total_area / std::max(1.0, static_cast<double>(vertices));
  const double rounding = 0x1p-24 * (1 + norm(center_in_units(mesh)));
  parallel_blocks(vertices, vertex_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      double angles = 0, area = 0;
      Vector3 gradient;
      bool boundary = false;
      for (const std::uint32_t h : around.of(v)) {
        const std::uint32_t previous = previous_half_edge(h);
        boundary = boundary || mesh.opposite[h] == no_index || mesh.opposite[previous] == no_index;
        const Vector3 p = mesh.position(mesh.triangles[h]);
        const Vector3 q = mesh.position(mesh.triangles[next_half_edge(h)]);
        const Vector3 r = mesh.position(mesh.triangles[previous]);
        const CornerShare share = corner_share(p, q, r, mesh.area[h / 3]);
        angles += share.angle;
        area += mixed_area_share(p, q, r, mesh.area[h / 3]);
        gradient = gradient + share.area_gradient;
      }
      result.mixed_area[v] = area;
      if (boundary || area <= 0) continue;
      known[v] = 1;
      const double own = std::max(area, least_area), slope = norm(gradient);
      if (slope > 8 * rounding) result.mean[v] = slope / (2 * own);
      const double defect = 2 * std::numbers::pi - angles;
      if (std::abs(defect) > 8 * rounding * (rounding + slope) / own + 0x1p-46)
        result.gaussian[v] = defect / own;
    }
  });
  cancel.check();
  fill_unknown(mesh, around, known, result);
  return result;
}

}  // namespace meander
