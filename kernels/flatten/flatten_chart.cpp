#include "kernels/flatten/flatten_chart.h"

#include <utility>

#include "kernels/flatten/boundary_first.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/flatten/fit_square.h"

namespace meander {

FlatChart flatten_chart(const PreparedMesh& mesh, CutChart cut, const FlattenParameters& /*parameters*/,
                        const CancelToken& cancel) {
  FlatChart flat;
  flat.cut = std::move(cut);
  const ChartGeometry geometry = chart_geometry(mesh, flat.cut);
  IntrinsicDisk disk;
  disk.triangles = flat.cut.triangles;
  disk.opposite = flat.cut.opposite;
  disk.length = geometry.length;
  disk.vertex_count = static_cast<std::uint32_t>(flat.cut.vertex_count());
  mollify(disk.length);
  ConformalMap map = flatten_boundary_first(disk, cancel);
  if (!map.finite) return flat;
  fit_square(map.u, map.v);
  flat.u = std::move(map.u);
  flat.v = std::move(map.v);
  measure_chart(geometry, flat.cut, flat.u, flat.v, flat.report);
  if (flat.report.flips == 0 && branch_points(flat.cut, flat.u, flat.v) == 0)
    flat.report.method = Method::conformal;
  return flat;
}

}  // namespace meander
