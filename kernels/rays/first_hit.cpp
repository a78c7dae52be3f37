// The survey's locator: curve vertices at the leaf centers, local areas by Meyer et al. at the mesh vertices.
//
// The area of a leaf is its UV area times the area factor at its curve vertex. The factor of a mesh vertex is
// its mixed area (Meyer et al. 2003) on the surface over that on the chart, and is linear over triangles in
// between. That is defined wherever a triangle is hit, however the spacing of curve vertices compares with
// that of mesh vertices (sharing out each vertex's mixed area among the curve vertices nearest to it is not:
// a mesh vertex without one loses its area, and leaves of unequal size get equal shares). It is exact where
// the chart is a similarity, and near where it is conformal, since angles decide how a triangle is shared
// out.
#include "kernels/rays/first_hit.h"

#include <algorithm>
#include <array>
#include <string>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/density/curvature.h"
#include "kernels/density/pieces.h"
#include "kernels/flatten/chart_geometry.h"
#include "kernels/rays/chart_scene.h"
#include "kernels/rays/ray_plan.h"
#include "kernels/rays/refine_by_rays.h"

namespace meander {

namespace {

// What one curve vertex owns.
struct CurveVertices {
  std::vector<std::uint32_t> triangle;  // of the mesh
  std::vector<double> mass;
  std::vector<float> b1, b2;

  void push(std::uint32_t t, double m, double w1, double w2) {
    triangle.push_back(t);
    mass.push_back(m);
    b1.push_back(static_cast<float>(w1));
    b2.push_back(static_cast<float>(w2));
  }
};

// Mixed area on the surface over mixed area on the chart, per chart vertex; 0 where the chart has none.
std::vector<double> area_factors(const PreparedMesh& mesh, const Component& component,
                                 const FlatChart& chart) {
  std::vector<double> mixed(chart.cut.vertex_count(), 0.0), flat(chart.cut.vertex_count(), 0.0);
  for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) {
    const std::size_t local = t - component.triangle_begin;
    const UvTriangle map = uv_triangle(chart, local);
    const double flat_area = uv_area(map);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3, last = (k + 2) % 3;
      const std::uint32_t vertex = chart.cut.triangles[3 * local + k];
      const auto at = [&](std::size_t corner) { return mesh.position(mesh.triangles[3 * t + corner]); };
      const auto flat_at = [&](std::size_t corner) { return Vector3{map.u[corner], map.v[corner], 0}; };
      mixed[vertex] += mixed_area_share(at(k), at(next), at(last), mesh.area[t]);
      flat[vertex] += mixed_area_share(flat_at(k), flat_at(next), flat_at(last), flat_area);
    }
  }
  for (std::size_t v = 0; v < mixed.size(); ++v) mixed[v] = flat[v] > 0 ? mixed[v] / flat[v] : 0.0;
  return mixed;
}

double density_at(const PreparedMesh& mesh, const Density& density, std::uint32_t triangle,
                  const std::array<double, 3>& weight) {
  if (density.uniform()) return 1.0;
  if (density.in_pieces()) return source_of(mesh, density, triangle).density_at(weight[1], weight[2]);
  const double* corner = density.corner.data() + 3 * std::size_t{triangle};
  return weight[0] * corner[0] + weight[1] * corner[1] + weight[2] * corner[2];
}

// Area factors are linear over triangles: where a chart shrinks a part to almost nothing, the factor of that
// part spreads over large triangles beside it, and leaves there weigh more than the whole surface. This is
// what memory is reserved for.
std::uint64_t leaf_limit(const Component& component, double mass, const RayPlan& plan, CurveKind kind) {
  const double expected = plan.leaf_mass > 0 ? mass / plan.leaf_mass : 0;
  return static_cast<std::uint64_t>(max_leaves_per_mass(kind) * expected) + component.triangle_end -
         component.triangle_begin + 1024;
}

CurveVertices chart_vertices(const EmbreeDevice& device, const PreparedMesh& mesh, const Density& density,
                             const Component& component, const FlatChart& chart, CurveTree& tree,
                             DepthRange depths, std::uint64_t most_leaves, double leaf_mass,
                             const CancelToken& cancel) {
  const ChartScene scene(device, chart.u, chart.v, chart.cut.triangles);
  const std::vector<double> factor = area_factors(mesh, component, chart);
  CurveVertices found;
  std::vector<KeyIndex> order, scratch;
  const auto center = [](const CurveTree& nodes, std::size_t i) {
    return std::pair(nodes.u[i] + nodes.side[i] / 2, nodes.v[i] + nodes.side[i] / 2);
  };
  const auto visit = [&](const CurveTree& nodes, std::size_t i, double, double,
                         std::span<const std::uint32_t> hits, bool may_split) {
    if (hits.empty()) return false;
    const std::uint32_t local = hits.front();  // all lie in one plane: the lowest number is the first
    const std::uint32_t t = component.triangle_begin + local;
    const auto [u, v] = center(nodes, i);
    const std::array<double, 3> weight = clamped_barycentric(uv_triangle(chart, local), u, v);
    double area = 0;
    for (std::size_t k = 0; k < 3; ++k) area += weight[k] * factor[chart.cut.triangles[3 * local + k]];
    const double mass = nodes.side[i] * nodes.side[i] * area * density_at(mesh, density, t, weight);
    if (may_split && mass > leaf_mass) return true;
    if (!(mass > 0)) return false;
    order.push_back({nodes.key[i], static_cast<std::uint32_t>(found.mass.size())});
    found.push(t, mass, weight[1], weight[2]);
    return false;
  };
  refine_by_rays(tree, scene, depths, most_leaves, cancel, center, visit);
  radix_sort(order, scratch);  // from level by level to along the curve
  CurveVertices sorted;
  for (const KeyIndex entry : order)
    sorted.push(found.triangle[entry.index], found.mass[entry.index], found.b1[entry.index],
                found.b2[entry.index]);
  return sorted;
}

// Components without a curve, or whose rays met nothing: whole triangles along the 3-D Hilbert curve, each
// with its exact mass at its centroid, so that no component is lost.
CurveVertices whole_triangles(const PreparedMesh& mesh, const Component& component,
                              std::span<const double> masses) {
  std::vector<KeyIndex> order, scratch;
  for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t) {
    if (!(masses[t] > 0)) continue;
    const std::uint32_t* corner = mesh.triangles.data() + 3 * std::size_t{t};
    const Vector3 sum = mesh.position(corner[0]) + mesh.position(corner[1]) + mesh.position(corner[2]);
    order.push_back({hilbert_key_3d((1.0 / 3) * sum), t});
  }
  radix_sort(order, scratch);
  CurveVertices vertices;
  for (const KeyIndex entry : order) vertices.push(entry.index, masses[entry.index], 1.0 / 3, 1.0 / 3);
  return vertices;
}

}  // namespace

CurveElements locate_first_hit(const EmbreeDevice& device, const PreparedMesh& mesh,
                               const MeshMeasure& measure, std::span<const FlatChart> charts,
                               std::vector<CurveTree>& trees, const LocateParameters& parameters,
                               const CancelToken& cancel) {
  const Density& density = measure.density;
  const std::vector<double>& masses = measure.masses;
  const RayPlan plan = plan_rays(mesh, charts, masses, parameters);
  if (!(plan.total > 0))
    throw ItemError(Status::zero_density, "the density is zero everywhere on the surface");
  if (trees.size() != charts.size())
    throw ItemError(Status::internal, "the locator was given " + std::to_string(trees.size()) +
                                          " trees for " + std::to_string(charts.size()) + " charts");
  std::vector<CurveVertices> parts(charts.size());
  parallel_tasks(charts.size(), [&](std::size_t c) {
    const Component& component = mesh.components[c];
    if (trees[c].leaf_count() > 0) {
      const double mass = component_mass(component, masses);
      parts[c] = chart_vertices(
          device, mesh, density, component, charts[c], trees[c], depth_range(mass, plan, parameters.curve),
          leaf_limit(component, mass, plan, parameters.curve.kind), plan.leaf_mass, cancel);
    }
    if (parts[c].mass.empty()) parts[c] = whole_triangles(mesh, component, masses);
  });
  CurveElements result;
  result.cumulative.push_back(0);
  for (const CurveVertices& part : parts)
    for (std::size_t i = 0; i < part.mass.size(); ++i) {
      result.triangle.push_back(part.triangle[i]);
      result.vertex.push_back(part.b1[i]);
      result.vertex.push_back(part.b2[i]);
      result.cumulative.push_back(result.cumulative.back() + part.mass[i]);
    }
  result.path.assign(result.triangle.size(), 1);
  return result;
}

}  // namespace meander
