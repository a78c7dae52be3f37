#include "kernels/locate/element_cells.h"

#include <bit>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/locate/chart_places.h"
#include "kernels/locate/placed_pieces.h"

namespace meander {

namespace {

// Unit normals in space, (0, 0, 0) for triangles of no area.
std::vector<float> triangle_normals(const PreparedMesh& mesh) {
  std::vector<float> normal(3 * mesh.triangle_count());
  parallel_blocks(mesh.triangle_count(), sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Vector3 a = mesh.position(mesh.triangles[3 * t]);
      const Vector3 n =
          cross(mesh.position(mesh.triangles[3 * t + 1]) - a, mesh.position(mesh.triangles[3 * t + 2]) - a);
      const double length = norm(n), scale = length > 0 ? 1 / length : 0;
      normal[3 * t] = static_cast<float>(scale * n.x);
      normal[3 * t + 1] = static_cast<float>(scale * n.y);
      normal[3 * t + 2] = static_cast<float>(scale * n.z);
    }
  });
  return normal;
}

}  // namespace

std::uint32_t ElementCells::path_of(const CellEntry& entry) const {
  const int bisections = std::bit_width(entry.part()) - 1;
  return path[entry.element()] << bisections | (entry.part() - (1u << bisections));
}

ElementCells build_cells(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                         const TriangleHints& hints, RandomKey key, const ElementParameters& parameters,
                         const CancelToken& cancel) {
  const double limit = element_limit(measure, parameters);
  const PreparedMesh& mesh = surface.mesh();
  const ChartPlaces places(mesh, charts);
  const std::vector<std::uint32_t> group = sheet_groups(mesh, charts.charts, hints.sheet);
  const bool is_split = hints.hits.empty() && splits_pieces(parameters, charts.empty() && surface.in_space(),
                                                            measure.density.uniform());
  PlacedPieces pieces = cut_all(
      surface, measure.density, hints.hits, is_split ? limit * split_parts : limit,
      [&] { return PlacedPieces(places, key, parameters.keep_vertices, is_split ? limit : 0); }, cancel);
  check_count(pieces.point.size(), most_balanced_elements);
  cancel.check();
  const std::vector<float> normal = charts.empty() ? triangle_normals(mesh) : std::vector<float>();
  ElementCells result;
  result.cells = balanced_order(pieces.point, static_cast<std::uint32_t>(parameters.samples),
                                {pieces.triangle, pieces.split, normal, group}, cancel);
  result.triangle = std::move(pieces.triangle);
  result.path = std::move(pieces.path);
  result.vertex = std::move(pieces.vertex);
  return result;
}

}  // namespace meander
