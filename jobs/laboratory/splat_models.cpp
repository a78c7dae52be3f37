#include "jobs/laboratory/splat_models.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/sample/point_frames.h"

namespace meander {

std::vector<float> sample_areas(const Row& row, std::size_t count) {
  const Samples& samples = row.samples;
  const double scale = row.report.scale, all = static_cast<double>(samples.count()),
               n = static_cast<double>(std::max<std::size_t>(1, count));
  const double mean = row.report.area / (scale * scale) / n;
  std::vector<float> areas(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double own =
        samples.tensor_spacing.empty()
            ? row.report.measure / (scale * scale) / (n * double{samples.density[i]})
            : double{samples.tensor_spacing[2 * i]} * samples.tensor_spacing[2 * i + 1] * all / n;
    areas[i] = static_cast<float>(std::isfinite(own) && own > 0 ? std::min(own, 64 * mean) : mean);
  }
  return areas;
}

std::vector<float> splat_half_axes(const Row& row, std::span<const float> areas, const SplatSizes& sizes) {
  const std::vector<float>& spacing = row.samples.tensor_spacing;
  std::vector<float> half_axes(2 * areas.size());
  for (std::size_t i = 0; i < areas.size(); ++i) {
    double ratio = 1;
    if (!sizes.round && !spacing.empty()) ratio = double{spacing[2 * i]} / spacing[2 * i + 1];
    if (!std::isfinite(ratio) || ratio < 1) ratio = 1;
    const HalfAxes axes = ellipse_axes(sizes.cover * double{areas[i]}, std::min(ratio, 64.0));
    half_axes[2 * i] = static_cast<float>(axes.along);
    half_axes[2 * i + 1] = static_cast<float>(axes.across);
  }
  return half_axes;
}

void limit_overlap(std::span<float> half_axes, const SplatView& view) {
  double area = 0;
  for (std::size_t i = 0; i + 1 < half_axes.size(); i += 2) {
    const double own = std::numbers::pi * double{half_axes[i]} * half_axes[i + 1];
    if (std::isfinite(own)) area += own;
  }
  const double most = 500.0 * view.width * view.height / (view.scale * view.scale);
  if (!(area > most)) return;
  for (float& axis : half_axes) axis *= static_cast<float>(std::sqrt(most / area));
}

OrientedSplats splats_of(const Row& row, std::span<float> half_axes, std::span<const SrgbColor> colors,
                         const SplatView& view) {
  limit_overlap(half_axes, view);
  const Samples& samples = row.samples;
  const std::size_t values = half_axes.size() / 2 * 3;
  OrientedSplats splats{std::span(samples.points).first(values),
                        std::span(samples.normals).first(values),
                        {},
                        half_axes,
                        colors};
  if (!samples.tensor_direction.empty())
    splats.directions = std::span(samples.tensor_direction).first(values);
  return splats;
}

bool is_closed(const Row& row) {
  const Samples& samples = row.samples;
  if (samples.corners.empty() || row.report.boundaries > 0) return false;
  const std::vector<float> areas = sample_areas(row, samples.count());
  const auto vector = [](const std::vector<float>& of, std::size_t i) {
    return Vector3{of[3 * i], of[3 * i + 1], of[3 * i + 2]};
  };
  double volume = 0;
  for (std::size_t i = 0; i < areas.size(); ++i)
    volume += double{areas[i]} *
              dot(vector(samples.points, i) - vector(samples.points, 0), vector(samples.normals, i));
  return volume > 0;
}

std::vector<float> mesh_depth(const Row& row, const PreparedMesh& mesh, const SplatView& view) {
  const ItemReport& report = row.report;
  std::vector<double> positions(3 * mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 file = to_file(mesh, {mesh.x[v], mesh.y[v], mesh.z[v]});
    positions[3 * v] = (file.x - report.loc[0]) / report.scale;
    positions[3 * v + 1] = (file.y - report.loc[1]) / report.scale;
    positions[3 * v + 2] = (file.z - report.loc[2]) / report.scale;
  }
  return surface_depth(positions, mesh.triangles, view);
}

}  // namespace meander
