#include "kernels/rays/ray_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_functions.h"
#include "kernels/flatten/chart_geometry.h"

namespace meander {

namespace {

// In Hilbert levels.
int least_depth(double mass, const RayPlan& plan) {
  const double leaves = plan.leaf_mass > 0 ? mass / plan.leaf_mass : 0;
  const int wanted = leaves > 1 ? static_cast<int>(std::floor(portable::log2(leaves) / 2)) - 1 : 0;
  return std::max(3, wanted);
}

// One chart's tree from the masses and areas of its triangles.
CurveTree build_chart_tree(const FlatChart& chart, std::span<const double> masses, double mass,
                           const RayPlan& plan, const CurveParameters& parameters,
                           const CancelToken& cancel) {
  const std::size_t triangles = masses.size();
  std::vector<double> u(triangles), v(triangles), area(triangles);
  parallel_blocks(triangles, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const UvTriangle corners = uv_triangle(chart, t);
      u[t] = (corners.u[0] + corners.u[1] + corners.u[2]) / 3;
      v[t] = (corners.v[0] + corners.v[1] + corners.v[2]) / 3;
      area[t] = uv_area(corners);
    }
  });
  return build_curve_tree(u, v, masses, area, plan.leaf_mass, least_depth(mass, plan), parameters, cancel);
}

}  // namespace

RayPlan plan_rays(const PreparedMesh& mesh, std::span<const FlatChart> charts, std::span<const double> masses,
                  const LocateParameters& parameters) {
  const auto fail = [](const std::string& what, std::size_t found, std::size_t expected) {
    throw ItemError(Status::internal, "the locator was given " + std::to_string(found) + " " + what +
                                          ", not " + std::to_string(expected));
  };
  if (charts.size() != mesh.components.size()) fail("charts", charts.size(), mesh.components.size());
  if (masses.size() != mesh.triangle_count()) fail("masses", masses.size(), mesh.triangle_count());
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const Component& component = mesh.components[c];
    const std::size_t expected = component.triangle_end - component.triangle_begin;
    if (charts[c].report.method != Method::none && charts[c].cut.triangle_count() != expected)
      fail("triangles in chart " + std::to_string(c), charts[c].cut.triangle_count(), expected);
  }
  RayPlan plan;
  plan.total = blocked_sum(masses);
  plan.leaf_mass = plan.total / (parameters.curve.leaves_per_sample *
                                 static_cast<double>(std::max<std::uint64_t>(1, parameters.samples)));
  return plan;
}

double component_mass(const Component& component, std::span<const double> masses) {
  return blocked_sum(
      masses.subspan(component.triangle_begin, component.triangle_end - component.triangle_begin));
}

DepthRange depth_range(double mass, const RayPlan& plan, const CurveParameters& parameters) {
  DepthRange range;
  range.most = curve_depth(parameters.kind, parameters.max_depth);
  range.least = std::min(range.most, curve_depth(parameters.kind, least_depth(mass, plan)));
  return range;
}

std::vector<CurveTree> build_curves(const PreparedMesh& mesh, std::span<const FlatChart> charts,
                                    std::span<const double> masses, const LocateParameters& parameters,
                                    const CancelToken& cancel) {
  const RayPlan plan = plan_rays(mesh, charts, masses, parameters);
  std::vector<CurveTree> trees(charts.size());
  if (!(plan.total > 0)) return trees;
  parallel_tasks(charts.size(), [&](std::size_t c) {
    trees[c].kind = parameters.curve.kind;
    if (charts[c].report.method == Method::none) return;
    const Component& component = mesh.components[c];
    const double mass = component_mass(component, masses);
    const double expected = static_cast<double>(parameters.samples) * (mass / plan.total);
    if (!(mass > 0) || expected < parameters.min_component_samples) return;
    trees[c] = build_chart_tree(
        charts[c],
        masses.subspan(component.triangle_begin, component.triangle_end - component.triangle_begin), mass,
        plan, parameters.curve, cancel);
  });
  return trees;
}

}  // namespace meander
