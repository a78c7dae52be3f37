#include "kernels/flatten/boundary_first.h"

#include <cmath>
#include <numbers>

#include "kernels/core/portable_angles.h"
#include "kernels/solve/cotan_laplacian.h"

namespace meander {

namespace {

// Lays out the polygon with the given turning angles whose lengths are closest to `length` (weights 1 /
// length).
void lay_out_boundary(const IntrinsicDisk& disk, std::span<const std::uint32_t> loop,
                      std::span<const double> turning, ConformalMap& map) {
  const std::size_t count = loop.size();
  std::vector<double> cosine(count), sine(count);
  double xx = 0, xy = 0, yy = 0, x = 0, y = 0, direction = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) direction += turning[disk.triangles[loop[i]]];
    const double l = disk.length[loop[i]];
    const Direction along = direction_of(direction);
    cosine[i] = along.cosine;
    sine[i] = along.sine;
    xx += l * cosine[i] * cosine[i];
    xy += l * cosine[i] * sine[i];
    yy += l * sine[i] * sine[i];
    x += l * cosine[i];
    y += l * sine[i];
  }
  const double determinant = xx * yy - xy * xy;
  const double px = (yy * x - xy * y) / determinant, py = (xx * y - xy * x) / determinant;
  double u = 0, v = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t vertex = disk.triangles[loop[i]];
    map.u[vertex] = u;
    map.v[vertex] = v;
    const double l = disk.length[loop[i]] * (1 - (px * cosine[i] + py * sine[i]));
    u += l * cosine[i];
    v += l * sine[i];
  }
}

}  // namespace

ConformalMap flatten_boundary_first(const IntrinsicDisk& disk, const CancelToken& cancel,
                                    WorkBudget* budget) {
  ConformalMap map;
  const std::uint32_t count = disk.vertex_count;
  map.u.assign(count, 0);
  map.v.assign(count, 0);
  map.log_scale.assign(count, 0);
  const std::vector<std::uint32_t> loop = boundary_half_edges(disk.triangles, disk.opposite, count);
  std::vector<std::uint8_t> on_boundary(count, 0);
  for (const std::uint32_t h : loop) on_boundary[disk.triangles[h]] = 1;

  std::vector<double> curvature(count);  // angle defects; turning angles at the boundary
  for (std::uint32_t v = 0; v < count; ++v) curvature[v] = (on_boundary[v] ? 1 : 2) * std::numbers::pi;
  CornerGeometry corners = corner_geometry(disk.length);
  for (std::size_t h = 0; h < corners.angle.size(); ++h) curvature[disk.triangles[h]] -= corners.angle[h];
  corners.angle = std::vector<double>();
  const DirichletLaplacian laplacian(disk, std::move(corners.half_cotangent), on_boundary, cancel, budget);
  if (!laplacian.factorized()) return map;
  map.elimination = laplacian.elimination();

  std::vector<double> right(count);
  for (std::uint32_t v = 0; v < count; ++v) right[v] = -curvature[v];
  laplacian.solve(right, map.log_scale);
  cancel.check();

  const std::vector<double> flux = laplacian.apply_at_boundary(map.log_scale);
  for (const std::uint32_t h : loop) {
    double& k = curvature[disk.triangles[h]];
    k += flux[disk.triangles[h]];
    map.turning += k;
  }
  lay_out_boundary(disk, loop, curvature, map);
  laplacian.extend_harmonically(map.u, map.v);
  cancel.check();
  map.finite = true;
  for (std::uint32_t v = 0; v < count; ++v)
    map.finite = map.finite && std::isfinite(map.u[v]) && std::isfinite(map.v[v]);
  return map;
}

}  // namespace meander
