#include "jobs/remesh/remesh_stages.h"

#include <oneapi/tbb/task_arena.h>

#include <utility>
#include <vector>

#include "kernels/model/remesh_model.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

constexpr std::uint64_t bytes_per_triangle = 220;         // half-edges, vertices; the search for crossings
constexpr std::uint64_t bytes_per_fitted_triangle = 260;  // one and a half points of the surface to fit to
constexpr std::uint64_t bytes_per_sample = 560;  // two triangles each, positions, lists, what is written
// Carried values stand twice where they are made, and once where they are written.
constexpr std::uint64_t bytes_per_byte = 3, bytes_per_number = 12;
constexpr std::uint64_t bytes_per_carrying_triangle = 8;  // which corner a vertex has

// The file may be larger than its header says.
void check_memory(const GraphItem& item, const SampleParameters& parameters, bool fit,
                  const CarriedColumns& carried) {
  const PolygonMesh& file = item.model.file;
  MeshEstimate actual;
  actual.file_bytes = item.file_bytes;
  actual.vertices = file.vertex_count();
  const std::size_t corners = file.corners.size(), polygons = file.polygon_count();
  actual.triangles = corners > 2 * polygons ? corners - 2 * polygons : 0;
  const int threads = oneapi::tbb::this_task_arena::max_concurrency();
  const std::uint64_t needed =
      estimate_bytes(actual, parameters, threads) + remesh_bytes(actual, parameters.samples, fit, carried);
  if (needed > item.reserved_bytes) throw NeedsMoreMemory(needed);
}

}  // namespace

std::uint64_t remesh_bytes(const MeshEstimate& mesh, std::uint32_t samples, bool fit,
                           const CarriedColumns& carried) {
  std::uint64_t bytes_per_vertex = carried.colors ? 3 * bytes_per_byte : 0;
  std::uint64_t numbers = carried.texcoord ? 2 : 0;
  for (const AttributeColumn& column : carried.attributes) numbers += column.width;
  bytes_per_vertex += numbers * bytes_per_number;
  const bool carries = bytes_per_vertex > 0;
  return mesh.triangles * (bytes_per_triangle + (fit ? bytes_per_fitted_triangle : 0) +
                           (carries ? bytes_per_carrying_triangle : 0)) +
         std::uint64_t{samples} * (bytes_per_sample + bytes_per_vertex);
}

void add_remesh_stages(
    GraphStages& stages, const SampleParameters& parameters, const RemeshParameters& mesh,
    const CarriedColumns& carried,
    std::function<void(const PlanItem&, const RemeshedSurface&, const CarriedValues&)> made) {
  stages.front().body = [&parameters, fit = mesh.fit, carried,
                         read = std::move(stages.front().body)](GraphItem& item) {
    read(item);
    check_memory(item, parameters, fit, carried);
  };
  stages.push_back({"remesh_surface", [mesh, carried, made = std::move(made)](GraphItem& item) {
                      const RemeshedSurface model = remesh_model(item.model, mesh);
                      const CarriedValues values = carried_values(item.model, model, carried);
                      item.model.cancel.check();
                      made(*item.plan, model, values);
                    }});
}

}  // namespace meander
