#include "kernels/surface/surface_row.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

std::array<double, 6> bounding_box(const ParametricSurface& surface, const SurfaceSamples& samples,
                                   const ItemReport& report) {
  constexpr std::size_t side = 65;
  std::vector<double> u, v;
  for (std::size_t i = 0; i < side * side; ++i) {
    u.push_back(static_cast<double>(i % side) / (side - 1));
    v.push_back(static_cast<double>(i / side) / (side - 1));
  }
  std::vector<Vector3> grid(u.size());
  surface.positions(u, v, grid);
  std::array<double, 6> box = {grid[0].x, grid[0].y, grid[0].z, grid[0].x, grid[0].y, grid[0].z};
  const auto add = [&](std::array<double, 3> p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box[axis] = std::min(box[axis], p[axis]);
      box[axis + 3] = std::max(box[axis + 3], p[axis]);
    }
  };
  for (const Vector3& p : grid) add({p.x, p.y, p.z});
  for (std::size_t i = 0; i < samples.count(); ++i) {
    const Vector3 p = file_point(report, samples.points, i);
    add({p.x, p.y, p.z});
  }
  return box;
}

}  // namespace

Row surface_row(const ParametricSurface& surface, SurfaceSamples&& samples) {
  Row row;
  ItemReport& report = row.report;
  report.status = Status::ok;
  report.components = 1;
  report.area = samples.area;
  report.measure = samples.measure;
  report.repairs[Repair::coincident_points] = static_cast<std::uint32_t>(samples.coincident_points);
  report.notes = samples.notes.counts;
  report.note_text = text_of(samples.notes);
  report.loc = {samples.frame.loc.x, samples.frame.loc.y, samples.frame.loc.z};
  report.scale = samples.frame.scale;
  report.bbox = bounding_box(surface, samples, report);
  row.samples.points = std::move(samples.points);
  row.samples.normals = std::move(samples.normals);
  row.samples.uv.assign(samples.uv.begin(), samples.uv.end());
  row.samples.curve_rank = std::move(samples.curve_rank);
  row.samples.density = std::move(samples.density);
  return row;
}

}  // namespace meander
