#include "kernels/partition/element_source.h"

#include <utility>

#include "kernels/core/parallel.h"

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

ElementSource::ElementSource(const SurfaceContext& context, ElementOrder order)
    : ElementSource(context, order,
                    sheet_groups(context.surface.mesh(), context.charts.charts, context.hints.sheet)) {}

ElementSource::ElementSource(const SurfaceContext& context, ElementOrder order,
                             std::vector<std::uint32_t> sheet_group)
    : SurfaceContext(context), places(surface.mesh(), charts), group(std::move(sheet_group)) {
  if (order == ElementOrder::balanced && charts.empty()) normal = triangle_normals(surface.mesh());
}

}  // namespace meander
