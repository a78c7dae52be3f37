#include "kernels/analyse/self_intersections.h"

#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

std::uint64_t count_of(const PolygonMesh& mesh) {
  const std::vector<std::uint32_t> triangles = triangles_of(mesh);
  return self_intersections({mesh.x, mesh.y, mesh.z, triangles});
}

}  // namespace

TEST_CASE("self-intersections: none on embedded surfaces, one for each pair that crosses") {
  CHECK(count_of(icosphere(4)) == 0);
  CHECK(count_of(torus(40, 20)) == 0);
  CHECK(count_of(folded_sheet(6, 8, 1e-3)) == 0);
  const PolygonMesh crossing =
      polygon_mesh({-1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 1, 0, 5, 0}, {{0, 1, 2}, {3, 4, 5}});
  CHECK(count_of(crossing) == 1);
  // A tetrahedron whose corner reaches through a wide triangle: its three faces there.
  const PolygonMesh wall = polygon_mesh({0.9, -9, -9, 0.9, 9, -9, 0.9, 0, 15}, {{0, 1, 2}});
  CHECK(count_of(merged(tetrahedron(), wall)) >= 3);
}
