// The measures of the Python module (jobs/python/measures.h).
#include <vector>

#include "jobs/python/measures.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/point_frames.h"

namespace meander {

double box_error(const PolygonMesh& mesh, std::span<const double> points, std::uint32_t boxes,
                 std::uint64_t seed, const CancelToken& cancel) {
  const PreparedMesh surface = prepare_mesh(mesh, cancel);
  BoxParameters parameters;
  parameters.boxes = boxes;
  parameters.seed = seed;
  const std::vector<RotatedBox> shapes =
      random_boxes(surface.x, surface.y, surface.z, surface.triangles, parameters);
  if (shapes.empty())
    throw ItemError(Status::zero_area, "hardly any box holds between 0.2 % and 60 % of the surface");
  std::vector<double> working;
  working.reserve(points.size());
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vector3 p = to_working(surface, {points[i], points[i + 1], points[i + 2]});
    working.insert(working.end(), {p.x, p.y, p.z});
  }
  return box_error_ratio(shapes, working);
}

}  // namespace meander
