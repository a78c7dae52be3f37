#include "kernels/cut/cut_to_disk.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <cmath>
#include <set>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// An independent half-edge structure agrees that the chart is one manifold disk.
void check_disk_with_openmesh(const PreparedMesh& mesh, const CutChart& chart) {
  using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
  Mesh open_mesh;
  std::vector<Mesh::VertexHandle> handles;
  for (const std::uint32_t w : chart.source_vertex) {
    const Vector3 p = mesh.position(w);
    handles.push_back(
        open_mesh.add_vertex({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}));
  }
  for (std::size_t t = 0; t < chart.triangle_count(); ++t)
    REQUIRE(open_mesh
                .add_face(handles[chart.triangles[3 * t]], handles[chart.triangles[3 * t + 1]],
                          handles[chart.triangles[3 * t + 2]])
                .is_valid());
  const auto chi = static_cast<int>(open_mesh.n_vertices()) - static_cast<int>(open_mesh.n_edges()) +
                   static_cast<int>(open_mesh.n_faces());
  CHECK(chi == 1);
  for (const auto vertex : open_mesh.vertices()) REQUIRE(open_mesh.is_manifold(vertex));
  std::set<int> seen;
  int loops = 0, boundary = 0;
  for (const auto half_edge : open_mesh.halfedges()) {
    if (!open_mesh.is_boundary(half_edge)) continue;
    ++boundary;
    if (seen.count(half_edge.idx()) > 0) continue;
    ++loops;
    auto at = Mesh::HalfedgeHandle(half_edge);
    while (seen.insert(at.idx()).second) at = open_mesh.next_halfedge_handle(at);
  }
  CHECK(loops == 1);
  CHECK(boundary == static_cast<int>(chart.boundary_edges));
  CHECK(boundary >= 3);
}

// The chart is the component: same triangles, same corners, adjacency lost on seams only.
void check_chart_of(const PreparedMesh& mesh, const Component& component, const CutChart& chart) {
  REQUIRE(chart.triangle_begin == component.triangle_begin);
  REQUIRE(chart.triangle_count() == component.triangle_end - component.triangle_begin);
  const std::uint32_t begin = 3 * component.triangle_begin;
  for (std::uint32_t h = 0; h < chart.triangles.size(); ++h) {
    REQUIRE(chart.triangles[h] < chart.vertex_count());
    REQUIRE(chart.source_vertex[chart.triangles[h]] == mesh.triangles[begin + h]);
    const std::uint32_t other = mesh.opposite[begin + h];
    if (chart.opposite[h] == no_index) {
      REQUIRE((chart.seam[h] == 1) == (other != no_index));
    } else {
      REQUIRE(chart.seam[h] == 0);
      REQUIRE(chart.opposite[h] + begin == other);
      REQUIRE(chart.triangles[chart.opposite[h]] == chart.triangles[next_half_edge(h)]);
    }
  }
}

std::vector<CutChart> check_cut(const PolygonMesh& polygons, std::uint32_t seams = 4) {
  const PreparedMesh mesh = prepare_mesh(polygons);
  std::vector<CutChart> charts;
  CutParameters parameters;
  parameters.extremity_seams = seams;
  for (const Component& component : mesh.components) {
    charts.push_back(cut_to_disk(mesh, component, parameters));
    check_chart_of(mesh, component, charts.back());
    check_disk_with_openmesh(mesh, charts.back());
  }
  return charts;
}

PolygonMesh annulus(std::uint32_t around) {
  PolygonMesh mesh;
  mesh.polygon_begin.push_back(0);
  for (std::uint32_t i = 0; i < around; ++i)
    for (const double r : {1.0, 1.5, 2.0}) {
      mesh.x.push_back(r * std::cos(2 * M_PI * i / around));
      mesh.y.push_back(r * std::sin(2 * M_PI * i / around));
      mesh.z.push_back(0);
    }
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < 2; ++j) {
      const std::uint32_t a = 3 * i + j, b = 3 * ((i + 1) % around) + j;
      for (const std::uint32_t corner : {a, a + 1, b + 1, b}) mesh.corners.push_back(corner);
      mesh.polygon_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
    }
  return mesh;
}

}  // namespace

TEST_CASE("cut_to_disk: closed spheres become one disk") {
  check_cut(tetrahedron());
  check_cut(cube());
  check_cut(icosphere(0));
  check_cut(icosphere(3));
  check_cut(two_sided_plate(6, 1e-6));
}

TEST_CASE("cut_to_disk: without extremity seams only topology is cut") {
  // A closed sphere needs one path; a path of k edges gives 2 k boundary edges.
  CHECK(check_cut(icosphere(2), 0)[0].boundary_edges >= 4);
  CHECK(check_cut(grid_plane(4, 3), 0)[0].boundary_edges == 14);
  check_cut(torus(12, 8), 0);
}

TEST_CASE("cut_to_disk: handles are opened") {
  check_cut(torus(24, 12));
  check_cut(torus(3, 3));
  for (const std::uint32_t genus : {1u, 2u, 5u}) {
    const PolygonMesh slab = slab_with_tunnels(genus);
    REQUIRE(prepare_mesh(slab).components.at(0).genus == genus);
    check_cut(slab);
    check_cut(slab, 0);
  }
}

TEST_CASE("cut_to_disk: boundary loops are joined") {
  const std::vector<CutChart> ring = check_cut(annulus(16), 0);
  // 16 edges outside, 16 inside and the two edges across, twice.
  CHECK(ring[0].boundary_edges == 36);
  check_cut(annulus(3));
  check_cut(moebius_strip(12));
  check_cut(grid_plane(8, 8));
  PolygonMesh holed = torus(12, 12);  // a torus with three holes
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t t = 0; t < holed.polygon_count(); ++t)
    if (t != 5 && t != 100 && t != 203)
      faces.push_back({holed.corners[3 * t], holed.corners[3 * t + 1], holed.corners[3 * t + 2]});
  std::vector<double> xyz;
  for (std::size_t i = 0; i < holed.x.size(); ++i)
    xyz.insert(xyz.end(), {holed.x[i], holed.y[i], holed.z[i]});
  check_cut(polygon_mesh(std::move(xyz), std::move(faces)));
}

TEST_CASE("cut_to_disk: the smallest components") {
  check_cut(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}}));
  check_cut(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1}, {{0, 1, 2}, {1, 3, 2}}));
  check_cut(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}));
}

namespace {

// Two triangles glued along all three edges: a closed surface that no file can hold as a manifold.
PreparedMesh pillow() {
  PreparedMesh mesh;
  mesh.x = {0, 1, 0};
  mesh.y = {0, 0, 1};
  mesh.z = {0, 0, 0};
  mesh.triangles = {0, 1, 2, 0, 2, 1};
  mesh.opposite = {5, 4, 3, 2, 1, 0};
  mesh.polygon = {0, 1};
  mesh.area = {0.5, 0.5};
  mesh.components = {{0, 2, 0, 3, 0, 0, 1.0}};
  mesh.total_area = 1;
  return mesh;
}

}  // namespace

TEST_CASE("cut_to_disk: a pillow of two triangles opens along two edges") {
  const PreparedMesh mesh = pillow();
  const CutChart chart = cut_to_disk(mesh, mesh.components[0], {});
  CHECK(chart.boundary_edges == 4);
  check_disk_with_openmesh(mesh, chart);
}

TEST_CASE("cut_to_disk: a slit of two edges is lengthened") {
  // A tetrahedron with one edge opened: the boundary has two edges until a seam is added.
  PreparedMesh mesh = prepare_mesh(tetrahedron());
  const std::uint32_t other = mesh.opposite[0];
  mesh.opposite[0] = mesh.opposite[other] = no_index;
  mesh.components[0].boundary_loops = 1;
  for (const std::uint32_t seams : {0u, 4u}) {
    const CutChart chart = cut_to_disk(mesh, mesh.components[0], {seams});
    check_disk_with_openmesh(mesh, chart);
  }
}

TEST_CASE("cut_to_disk: coincident positions and edges without length") {
  PreparedMesh mesh = prepare_mesh(icosphere(1));
  for (std::size_t i = 0; i < mesh.x.size(); ++i) mesh.x[i] = mesh.y[i] = mesh.z[i] = 0.25;
  mesh.components[0].area = 0;
  check_disk_with_openmesh(mesh, cut_to_disk(mesh, mesh.components[0], {}));
  PreparedMesh ring = prepare_mesh(torus(6, 5));
  for (std::size_t i = 0; i < ring.x.size(); i += 2) ring.x[i] = ring.y[i] = ring.z[i] = 0.25;
  check_disk_with_openmesh(ring, cut_to_disk(ring, ring.components[0], {}));
}

TEST_CASE("cut_to_disk: more seams never shorten the boundary and the result is repeatable") {
  const PreparedMesh mesh = prepare_mesh(torus(40, 20));
  std::uint32_t before = 0;
  for (const std::uint32_t seams : {0u, 1u, 2u, 4u, 8u, 16u}) {
    const CutChart a = cut_to_disk(mesh, mesh.components[0], {seams});
    const CutChart b = cut_to_disk(mesh, mesh.components[0], {seams});
    CHECK(a.boundary_edges >= before);
    CHECK(a.triangles == b.triangles);
    CHECK(a.opposite == b.opposite);
    before = a.boundary_edges;
  }
}

TEST_CASE("cut_to_disk: an expired deadline ends the item") {
  const PreparedMesh mesh = prepare_mesh(icosphere(2));
  CancelToken token;
  token.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  try {
    cut_to_disk(mesh, mesh.components[0], {}, token);
    FAIL("no timeout");
  } catch (const ItemError& error) {
    CHECK(error.status() == Status::timeout);
  }
}

TEST_CASE("add_seam: keeps a disk until no interior vertex is left") {
  for (const PolygonMesh& polygons : {icosphere(1), torus(8, 6), grid_plane(5, 5)}) {
    const PreparedMesh mesh = prepare_mesh(polygons);
    CutChart chart = cut_to_disk(mesh, mesh.components[0], {0});
    for (std::uint32_t round = 0; round < 8; ++round) {
      const auto vertex =
          static_cast<std::uint32_t>(philox4x32({round, 0, 0, 0}, {7, 0})[0] % chart.vertex_count());
      const std::uint32_t before = chart.boundary_edges;
      const bool added = add_seam(mesh, chart, vertex);
      CHECK(added == (chart.boundary_edges > before));
      check_chart_of(mesh, mesh.components[0], chart);
      check_disk_with_openmesh(mesh, chart);
    }
    for (std::uint32_t vertex = 0; vertex < chart.vertex_count(); ++vertex) add_seam(mesh, chart, vertex);
    check_disk_with_openmesh(mesh, chart);
    CHECK(chart.vertex_count() == chart.boundary_edges);  // nothing is left inside
  }
}
