// Models remeshed for tests, and what every result must be.
#pragma once

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/remesh/remesh_surface.h"
#include "kernels/sample/point_frames.h"
#include "support/catch.h"
#include "support/test_meshes.h"

namespace meander::test {

struct Remeshed {
  Model model;
  std::vector<double> places;  // of the samples, working units
  RemeshedSurface mesh;
};

inline Remeshed remeshed(PolygonMesh file, std::uint32_t samples, const RemeshParameters& wanted = {},
                         SequenceKind sequence = SequenceKind::shifted, std::uint64_t seed = 7) {
  Remeshed result;
  Model& model = result.model;
  model.file = std::move(file);
  model.key = make_random_key(seed, {});
  SampleParameters parameters;
  parameters.sequence = sequence;
  parameters.samples = samples;
  run_stages(stages_of(parameters, nullptr), model);
  const Samples& s = model.row.samples;
  result.places = working_points(model.row.report, s.points, model.surface);
  result.mesh = remesh_surface(model.surface, {s.triangle, s.barycentric, result.places, s.curve_rank},
                               model.measure.masses, wanted);
  return result;
}

inline PolygonMesh as_file(const RemeshedSurface& mesh) {
  PolygonMesh file;
  file.x = mesh.x;
  file.y = mesh.y;
  file.z = mesh.z;
  file.corners = mesh.triangles;
  for (std::size_t k = 0; k <= mesh.triangles.size(); k += 3)
    file.polygon_begin.push_back(static_cast<std::uint32_t>(k));
  return file;
}

// Genus and boundary loops of the components, ascending.
inline std::vector<std::pair<std::uint32_t, std::uint32_t>> topology_of(const PreparedMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
  for (const Component& c : mesh.components) found.emplace_back(c.genus, c.boundary_loops);
  std::sort(found.begin(), found.end());
  return found;
}

// What a reader of the file finds who knows vertex numbers only.
inline void check_topology_by_numbers(const RemeshedSurface& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed, edges;
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h) {
    const std::uint32_t v = mesh.triangles[h], w = mesh.triangles[h % 3 == 2 ? h - 2 : h + 1];
    ++directed[{v, w}];
    ++edges[std::minmax(v, w)];
  }
  std::map<std::uint32_t, std::uint32_t> after;  // along the boundary
  bool manifold = true;
  for (const auto& [edge, count] : directed) {
    manifold = manifold && count == 1;
    if (!directed.contains({edge.second, edge.first}))
      manifold = manifold && after.emplace(edge.second, edge.first).second;
  }
  CHECK(manifold);
  CHECK(mesh.report.euler == static_cast<std::int64_t>(mesh.report.vertices + mesh.report.faces) -
                                 static_cast<std::int64_t>(edges.size()));
  std::uint32_t loops = 0;
  for (; !after.empty(); ++loops)
    for (auto at = after.begin(); at != after.end();) {
      const std::uint32_t next = at->second;
      after.erase(at);
      at = after.find(next);
    }
  CHECK(loops == mesh.report.boundary_loops);
}

// What every result must be. The oracle is the preparation of meshes: it has nothing to repair.
inline void check_result(const Remeshed& result, bool moved = false) {
  const RemeshedSurface& mesh = result.mesh;
  const std::size_t n = result.places.size() / 3;
  REQUIRE(mesh.x.size() >= n);
  REQUIRE(mesh.origin.size() == mesh.x.size() - n);
  for (std::size_t i = 0; i < n && !moved; ++i) {
    REQUIRE(mesh.x[i] == result.places[3 * i]);
    REQUIRE(mesh.y[i] == result.places[3 * i + 1]);
    REQUIRE(mesh.z[i] == result.places[3 * i + 2]);
  }
  std::vector<std::uint8_t> used(mesh.x.size(), 0);
  for (const std::uint32_t v : mesh.triangles) {
    REQUIRE(v < mesh.x.size());
    used[v] = 1;
  }
  CHECK(std::accumulate(used.begin(), used.end(), std::size_t{0}) == used.size());
  const PreparedMesh again = prepare_mesh(as_file(mesh));
  CHECK(again.repairs[Repair::split_edges] == 0);
  CHECK(again.repairs[Repair::split_vertices] == 0);
  CHECK(again.repairs[Repair::flipped_faces] == 0);
  CHECK(again.repairs[Repair::repeated_corners] == 0);
  const RemeshReport& report = mesh.report;
  CHECK(report.vertices == mesh.x.size());
  CHECK(report.faces == mesh.triangles.size() / 3);
  CHECK(report.line_vertices + report.kept_vertices == mesh.origin.size());
  check_topology_by_numbers(mesh);
  CHECK(report.components + report.dropped_components == result.model.surface.components.size());
  if (report.dropped_components == 0) {
    CHECK(topology_of(again) == topology_of(result.model.surface));
    CHECK(report.dropped_share == 0);
  }
}

}  // namespace meander::test
