#include "kernels/analyse/certify_samples.h"

#include <limits>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/box_limit.h"
#include "kernels/analyse/spacing.h"
#include "kernels/sample/point_frames.h"

namespace meander {

std::vector<std::string> certificate_problems(const SampleParameters& parameters) {
  std::vector<std::string> problems;
  if (method_of(parameters).follows_tensor)
    problems.push_back("certify compares samples with area: the method anisotropic does not follow it");
  if (parameters.density.kind != DensityKind::uniform)
    problems.push_back("certify compares samples with area: it needs the uniform density");
  return problems;
}

void certify_samples(Row& row, const PreparedMesh& mesh, const CancelToken& cancel) {
  const std::vector<double> points = working_points(row.report, row.samples.points, mesh);
  constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
  const std::vector<RotatedBox> boxes = random_boxes(mesh.x, mesh.y, mesh.z, mesh.triangles, BoxParameters{});
  cancel.check();
  float box_error = unknown, limit = unknown;
  if (!boxes.empty()) {
    box_error = static_cast<float>(box_error_ratio(boxes, points));
    cancel.check();
    const double boundary = relative_boundary(mesh.x, mesh.y, mesh.z, mesh.triangles, boxes);
    if (boundary > 0) limit = static_cast<float>(box_error_limit(boundary, points.size() / 3));
  }
  const float rho = points.size() < 6
                        ? unknown
                        : static_cast<float>(spacing_of(nearest_distances(points), mesh.total_area).rho);
  row.descriptors.push_back({certificate_box_error, {box_error}});
  row.descriptors.push_back({certificate_box_limit, {limit}});
  row.descriptors.push_back({certificate_over_limit, {box_error / limit}});
  row.descriptors.push_back({certificate_rho, {rho}});
}

}  // namespace meander
