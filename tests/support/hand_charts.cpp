#include "support/hand_charts.h"

#include <random>

#include "support/test_meshes.h"

namespace meander::test {

FlatChart hand_chart(const PreparedMesh& mesh, const Component& component, const ChartMap& map) {
  FlatChart chart;
  const std::uint32_t first = 3 * component.triangle_begin, last = 3 * component.triangle_end;
  for (std::uint32_t h = first; h < last; ++h) {
    chart.cut.triangles.push_back(mesh.triangles[h] - component.vertex_begin);
    chart.cut.opposite.push_back(mesh.opposite[h] == no_index ? no_index : mesh.opposite[h] - first);
    chart.cut.boundary_edges += mesh.opposite[h] == no_index;
  }
  chart.cut.seam.assign(chart.cut.triangles.size(), 0);
  for (std::uint32_t w = component.vertex_begin; w < component.vertex_end; ++w) {
    chart.cut.source_vertex.push_back(w);
    const auto [u, v] = map(mesh.center + mesh.unit * mesh.position(w));
    chart.u.push_back(u);
    chart.v.push_back(v);
  }
  chart.report.method = Method::mean_value;
  chart.report.triangles = static_cast<std::uint32_t>(chart.cut.triangle_count());
  chart.report.area = component.area;
  return chart;
}

PolygonMesh wavy_grid(std::uint32_t nx, std::uint32_t ny, double jitter,
                      const std::function<double(double, double)>& height) {
  PolygonMesh mesh = grid_plane(nx, ny);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> move(-jitter, jitter);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const double x = mesh.x[i], y = mesh.y[i];
    if (x > 0 && x < 1) mesh.x[i] += move(random) / nx;
    if (y > 0 && y < 1) mesh.y[i] += move(random) / ny;
    mesh.z[i] = height(mesh.x[i], mesh.y[i]);
  }
  return mesh;
}

}  // namespace meander::test
