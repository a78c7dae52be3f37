// Edge collapses of the remesher beside OpenMesh's.
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/remesh/edited_mesh.h"
#include "support/test_meshes.h"

namespace meander::bench {

namespace {

// Two apexes, 0 and 1, each with an edge to every one of the `rim` vertices between them.
PolygonMesh double_cone(std::uint32_t rim) {
  std::vector<double> xyz = {0, 0, 1, 0, 0, -1};
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < rim; ++i) {
    const double angle = 2 * std::numbers::pi * i / rim;
    xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), 0});
    const std::uint32_t here = 2 + i, next = 2 + (i + 1) % rim;
    faces.push_back({here, next, 0});
    faces.push_back({next, here, 1});
  }
  return test::polygon_mesh(std::move(xyz), std::move(faces));
}

// Every second vertex of the rim moves to the next one.
void collapse_rim(benchmark::State& state) {
  const auto rim = static_cast<std::uint32_t>(state.range(0));
  const PreparedMesh surface = prepare_mesh(double_cone(rim));
  std::size_t left = 0;
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    EditedMesh mesh = edited_component(surface, surface.components.front());
    std::uint32_t apex = 0;
    while (!mesh.has_more_outgoing(apex, 4)) ++apex;
    std::vector<std::uint32_t> around;
    mesh.for_neighbors(apex, [&](std::uint32_t v, std::uint32_t) { around.push_back(v); });
    state.ResumeTiming();
    for (std::uint32_t i = 0; i < rim; i += 2) {
      std::uint32_t edge = no_index;
      mesh.for_neighbors(around[i], [&](std::uint32_t w, std::uint32_t h) {
        if (w == around[i + 1]) edge = h;
      });
      mesh.collapse(edge, around[i]);
    }
    left = 0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) left += mesh.exists(t);
  }
  count_items(state, "collapse", rim / 2.0);
  check_sum(state, "own", std::vector<std::size_t>{left});
}
BENCHMARK(collapse_rim)->Arg(1000)->Arg(10000);

void collapse_rim_openmesh(benchmark::State& state) {
  using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
  const auto rim = static_cast<std::uint32_t>(state.range(0));
  const PolygonMesh cone = double_cone(rim);
  std::size_t left = 0;
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    Mesh mesh;
    mesh.request_vertex_status();
    mesh.request_edge_status();
    mesh.request_face_status();
    const auto vertex = [](std::uint32_t v) { return Mesh::VertexHandle(static_cast<int>(v)); };
    for (std::size_t v = 0; v < cone.vertex_count(); ++v) mesh.new_vertex();
    for (std::size_t c = 0; c < cone.corners.size(); c += 3)
      mesh.add_face(vertex(cone.corners[c]), vertex(cone.corners[c + 1]), vertex(cone.corners[c + 2]));
    state.ResumeTiming();
    for (std::uint32_t v = 2; v < 2 + rim; v += 2)
      mesh.collapse(mesh.find_halfedge(vertex(v), vertex(v + 1)));
    left = 0;
    for (const auto t : mesh.all_faces()) left += !mesh.status(t).deleted();
  }
  count_items(state, "collapse", rim / 2.0);
  check_sum(state, "OpenMesh", std::vector<std::size_t>{left});
}
BENCHMARK(collapse_rim_openmesh)->Arg(1000)->Arg(10000);

}  // namespace

}  // namespace meander::bench
