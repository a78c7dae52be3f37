#include "kernels/partition/chart_places.h"

#include <algorithm>

#include "kernels/flatten/chart_geometry.h"

namespace meander {

ChartPlaces::ChartPlaces(const PreparedMesh& mesh, const ChartSet& charts)
    : mesh_(mesh), charts_(charts.charts), coarse_(charts.empty() ? nullptr : charts.coarse) {
  if (charts.empty()) return;
  if (coarse_ != nullptr) {
    map_planes();
    return;
  }
  chart_of_.assign(mesh.triangle_count(), no_index);
  for (std::size_t c = 0; c < charts_.size(); ++c)
    if (charts_[c].report.method != Method::none)
      std::fill(chart_of_.begin() + mesh.components[c].triangle_begin,
                chart_of_.begin() + mesh.components[c].triangle_end, static_cast<std::uint32_t>(c));
}

void ChartPlaces::map_planes() {
  planes_.resize(coarse_->mesh.triangle_count());
  for (std::size_t c = 0; c < charts_.size(); ++c) {
    if (charts_[c].report.method == Method::none) continue;
    const Component& component = coarse_->mesh.components[c];
    for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) {
      const UvTriangle corners = uv_triangle(charts_[c], t - component.triangle_begin);
      const PlaneWeights weights = plane_weights(coarse_->mesh, t);
      PlaneMap& map = planes_[t];
      map.has_chart = true;
      map.du = (corners.u[1] - corners.u[0]) * weights.first + (corners.u[2] - corners.u[0]) * weights.second;
      map.dv = (corners.v[1] - corners.v[0]) * weights.first + (corners.v[2] - corners.v[0]) * weights.second;
      map.u0 = corners.u[0] - dot(map.du, weights.origin);
      map.v0 = corners.v[0] - dot(map.dv, weights.origin);
    }
  }
}

bool ChartPlaces::find(std::size_t triangle, std::array<double, 3>& u, std::array<double, 3>& v) const {
  if (coarse_ != nullptr) {
    const PlaneMap& map = planes_[coarse_->triangle[triangle]];
    if (!map.has_chart) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 p = mesh_.position(mesh_.triangles[3 * triangle + k]);
      u[k] = std::clamp(map.u0 + dot(map.du, p), 0.0, 1.0);
      v[k] = std::clamp(map.v0 + dot(map.dv, p), 0.0, 1.0);
    }
    return true;
  }
  if (chart_of_.empty() || chart_of_[triangle] == no_index) return false;
  const FlatChart& chart = charts_[chart_of_[triangle]];
  const std::size_t local = 3 * (triangle - mesh_.components[chart_of_[triangle]].triangle_begin);
  for (std::size_t k = 0; k < 3; ++k) {
    u[k] = chart.u[chart.cut.triangles[local + k]];
    v[k] = chart.v[chart.cut.triangles[local + k]];
  }
  return true;
}

std::vector<std::uint32_t> sheet_groups(const PreparedMesh& mesh, std::span<const FlatChart> charts,
                                        std::span<const std::uint8_t> sheet) {
  std::vector<std::uint32_t> group(charts.empty() ? 0 : mesh.triangle_count());
  if (group.empty()) return group;
  for (std::size_t c = 0; c < mesh.components.size(); ++c)
    for (std::size_t t = mesh.components[c].triangle_begin; t < mesh.components[c].triangle_end; ++t)
      group[t] = static_cast<std::uint32_t>(c) * 16 + (sheet.empty() ? 0u : sheet[t]);
  return group;
}

}  // namespace meander
