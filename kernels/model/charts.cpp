#include "kernels/model/charts.h"

#include <algorithm>
#include <utility>

#include "kernels/core/parallel.h"

namespace meander {

std::vector<CutChart> cut_components(const MeasuredMesh& surface, const CutParameters& parameters,
                                     const CancelToken& cancel) {
  const std::vector<Component>& components = surface.mesh().components;
  std::vector<CutChart> cuts(components.size());
  parallel_tasks(cuts.size(), [&](std::size_t c) {
    if (components[c].area > 0) cuts[c] = cut_to_disk(surface, components[c], parameters, cancel);
  });
  return cuts;
}

std::vector<FlatChart> flatten_components(const MeasuredMesh& surface, std::vector<CutChart> cuts,
                                          const FlattenParameters& parameters, const CancelToken& cancel) {
  std::vector<FlatChart> charts(cuts.size());
  parallel_tasks(charts.size(), [&](std::size_t c) {
    if (surface.mesh().components[c].area > 0)
      charts[c] = flatten_chart(surface, std::move(cuts[c]), parameters, cancel);
  });
  return charts;
}

void report_charts(std::span<const Component> components, std::span<const FlatChart> charts,
                   ItemReport& report) {
  const auto weakness = [](Method method) {
    return method == Method::anisotropic ? Method::conformal
           : method == Method::none      ? Method::direct
                                         : method;
  };
  Method weakest = Method::conformal;
  bool anisotropic = false;
  double weight = 0, overlap = 0, distortion = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const double area = components[c].area;
    if (!(area > 0)) continue;
    const ChartReport& chart = charts[c].report;
    if (const Method method = weakness(chart.method); method > weakest) {
      weakest = method;
      report.order_reason = chart.reason;
    } else if (method == weakest) {
      report.order_reason = std::max(report.order_reason, chart.reason);
    }
    anisotropic |= chart.method == Method::anisotropic;
    if (chart.method == Method::none) continue;
    report.flips += chart.flips;
    report.area_scale_range = std::max(report.area_scale_range, chart.area_scale_range);
    weight += area;
    overlap += area * chart.overlap;
    distortion += area * chart.mean_distortion;
  }
  report.method = weakest == Method::conformal && anisotropic ? Method::anisotropic : weakest;
  if (weight > 0) {
    report.overlap = overlap / weight;
    report.distortion = distortion / weight;
  }
}

}  // namespace meander
