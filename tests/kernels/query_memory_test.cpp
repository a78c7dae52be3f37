// What distances, sides and sharp edges take at their peak, measured, against the bounds beside their code.
#include <string>
#include <utility>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/sharp_edges.h"
#include "kernels/query/surface_sides.h"
#include "kernels/query/winding_number.h"
#include "kernels/sample/query_points.h"
#include "kernels/sample/sharp_samples.h"
#include "support/allocation_counter.h"
#include "support/catch.h"
#include "support/query_meshes.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

// Calls make, and compares the most that was held meanwhile with the bound.
template <class Make>
auto within(const std::string& what, double bound, const Make& make) {
  const std::int64_t before = allocated_bytes();
  reset_peak();
  auto made = on_threads(1, make);
  INFO(what << ": " << peak_allocated_bytes() - before << " of " << bound);
  constexpr double of_allocator = 1024;  // which rounds blocks up
  CHECK(static_cast<double>(peak_allocated_bytes() - before) <= bound + of_allocator);
  return made;
}

// Small tetrahedra all over a cube, and a large sphere around them: every one lies in its box.
PolygonMesh crowd() {
  PolygonMesh mesh = icosphere(4);
  const RandomKey key = make_random_key(2, {});
  for (int i = 0; i < 400; ++i) {
    const UnitPair a = random_pair(key, Stream::sequence, static_cast<std::uint64_t>(i));
    mesh = merged(mesh, moved(tetrahedron(), 0.01, a.first - 0.5, a.second - 0.5, 0.001 * i - 0.2));
  }
  return mesh;
}

// Every triangle by itself, half as large as it was.
PolygonMesh apart(const PolygonMesh& mesh) {
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  const std::vector<std::uint32_t> corners = triangles_of(mesh);
  for (std::uint32_t c = 0; c < corners.size(); ++c) {
    const std::uint32_t first = c / 3 * 3;
    for (const std::vector<double>* of : {&mesh.x, &mesh.y, &mesh.z})
      xyz.push_back(((*of)[corners[first]] + (*of)[corners[first + 1]] + (*of)[corners[first + 2]]) / 6 +
                    (*of)[corners[c]] / 2);
    if (c % 3 == 2) faces.push_back({first, first + 1, first + 2});
  }
  return polygon_mesh(xyz, faces);
}

// A row whose samples are placed: the frame, and what stands in for points on edges.
Row placed_row(const PreparedMesh& mesh) {
  Row row;
  row.report.loc = {mesh.center.x, mesh.center.y, mesh.center.z};
  row.report.scale = mesh.unit;
  row.samples.triangle = {0};
  row.samples.points = row.samples.normals = {0, 0, 1};
  return row;
}

// What both sets of points take beside the mesh and the samples, as the stages of a model make them.
void check_sets(const PolygonMesh& file) {
  const PreparedMesh mesh = prepare_mesh(file);
  const auto triangles = static_cast<double>(mesh.triangle_count()),
             vertices = static_cast<double>(file.vertex_count());
  constexpr std::uint32_t count = 20000;
  Notes notes;
  SharpParameters sharp;
  sharp.samples = count;
  sharp.corners = true;
  const Row placed = placed_row(mesh);
  within("add_sharp_samples", sharp_bytes(count, triangles), [&] {
    Row row = placed;
    add_sharp_samples(mesh, sharp_edges_of(file, mesh, sharp, notes), sharp, OrderKind::progressive, 0.25,
                      make_random_key(1, {}), {}, row);
    return row;
  });
  QueryParameters queries;
  REQUIRE(take_queries("near=8000@.01,.05 near-sharp=6000@.01 volume=6000@1.1", queries.terms).empty());
  queries.nearest = true;
  const SharpEdges edges = sharp_edges_of(file, mesh, sharp, notes);
  for (const SignChoice sign : {SignChoice::automatic, SignChoice::winding, SignChoice::shell}) {
    queries.sign = sign;
    within("add_query_points", query_bytes(count, triangles, vertices), [&] {
      Row row = placed;
      add_query_points(file, mesh, queries, edges, false, make_random_key(1, {}), {}, row);
      return row;
    });
  }
}

void check_bounds(const std::string& name, PolygonMesh file) {
  INFO(name);
  on_threads(1, [] { return 0; });  // starts oneTBB
  check_sets(file);
  const double polygons = static_cast<double>(file.polygon_count()),
               corners = static_cast<double>(file.corners.size()),
               vertices = static_cast<double>(file.vertex_count());
  within("drop_doubled_faces", drop_doubled_faces_bytes(polygons, corners, vertices),
         [&] { return drop_doubled_faces(file); });
  const PreparedMesh mesh = prepare_mesh(file);
  const auto triangles = static_cast<double>(mesh.triangle_count());
  const TriangleTree tree = within("build_triangle_tree", triangle_tree_bytes(triangles), [&] {
    return build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
  });
  const OrientedSurface oriented =
      within("orient_outward", orient_outward_bytes(triangles), [&] { return orient_outward(mesh); });
  const WindingTree winding = within("build_winding_tree", winding_tree_bytes(triangles),
                                     [&] { return build_winding_tree(tree, {}, 0.1); });
  within("find_sharp_edges", sharp_edges_bytes(triangles),
         [&] { return find_sharp_edges(mesh, {.borders = true}); });
  const SharpEdges edges = find_sharp_edges(mesh, {.borders = true});
  within("sharp_corners", sharp_edges_bytes(triangles), [&] { return sharp_corners(mesh, edges, 30); });
  const RandomKey key = make_random_key(1, {});
  std::vector<double> points, shares;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i), v = random_pair(key, Stream::sequence, i, 1);
    points.insert(points.end(), {2 * u.first - 1, 2 * u.second - 1, 2 * v.first - 1});
    shares.push_back(v.second);
  }
  if (edges.count() > 0)
    within("points_on_edges", edge_points_bytes(20000, static_cast<double>(edges.count())),
           [&] { return points_on_edges(mesh, edges, shares); });
  const CurvePoints along = within("along_curve", 20000 * std::max(curve_order_bytes, curve_points_bytes),
                                   [&] { return along_curve(points); });
  within("winding_numbers", winding_numbers_bytes(20000), [&] { return winding_numbers(winding, points); });
  const NearestTriangles nearest = within("nearest_triangles", nearest_triangles_bytes(20000),
                                          [&] { return nearest_triangles(tree, along.points); });
  for (const SignRule rule : {SignRule::none, SignRule::shell, SignRule::winding, SignRule::closed})
    if (rule != SignRule::closed || oriented.all_closed())
      within("point_sides", point_sides_bytes(triangles, 20000),
             [&] { return point_sides(tree, oriented, rule, along.points, nearest); });
  within("label_points", label_points_bytes(triangles, 20000),
         [&] { return label_points(tree, oriented, SignRule::winding, points); });
}

}  // namespace

TEST_CASE("queries: nothing takes more than its bound") {
  if (!counts_allocations()) {
    WARN("skipped: this build does not count allocations");
    return;
  }
  for (auto& [name, mesh] : std::vector<std::pair<std::string, PolygonMesh>>{
           {"tetrahedron", tetrahedron()},
           {"cube", cube()},
           {"sphere", icosphere(5)},
           {"two spheres", merged(icosphere(5), inside_out(moved(icosphere(5), 0.5, 0, 0, 0)))},
           {"triangles apart", apart(icosphere(5))},
           {"triangles around each other", apart(merged(icosphere(4), moved(icosphere(4), 0.01, 0, 0, 0)))},
           {"crowd", crowd()},
           {"plane", grid_plane(60, 60)}})
    check_bounds(name, std::move(mesh));
}

TEST_CASE("queries: nothing takes more than its bound on real models") {
  MEANDER_NEEDS_SHARED_DATA();
  if (!counts_allocations()) {
    WARN("skipped: this build does not count allocations");
    return;
  }
  for (const std::string& name : query_models()) check_bounds(name, model_of(name));
}
