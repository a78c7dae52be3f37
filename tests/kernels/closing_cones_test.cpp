#include "kernels/query/closing_cones.h"

#include <cmath>
#include <map>

#include "kernels/query/winding_number.h"
#include "support/catch.h"
#include "support/sided_mesh.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// The winding number of the surface as it is turned, and that of its cones.
std::pair<double, double> winding_with_cones(const SidedMesh& sided, const ClosingCones& cones, Vector3 at) {
  std::vector<std::uint32_t> turned = sided.mesh.triangles;
  for (std::size_t t = 0; t < sided.oriented.flipped.size(); ++t)
    if (sided.oriented.flipped[t] != 0) std::swap(turned[3 * t + 1], turned[3 * t + 2]);
  return {exact_winding_number(sided.mesh.x, sided.mesh.y, sided.mesh.z, turned, at),
          exact_winding_number(cones.x, cones.y, cones.z, cones.triangles, at)};
}

}  // namespace

TEST_CASE("closing_cones: with them the winding number of any surface is whole") {
  // Holes, several of them at once and with a common corner, a flat sheet, and an edge that two sheets leave
  // open in the same direction.
  const PolygonMesh fins = polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {{0, 1, 2}, {0, 1, 3}});
  for (const PolygonMesh& file : {with_holes(icosphere(4), 0.05, 2), with_holes(torus(60, 40), 0.1, 5, 0.1),
                                  inside_out(with_holes(icosphere(3), 0.3, 3)), grid_plane(3, 3), fins}) {
    const SidedMesh sided(file);
    const ClosingCones cones = closing_cones(sided.oriented.boundary);
    REQUIRE_FALSE(cones.triangles.empty());
    double most = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
      const std::vector<double> points = side_points(sided.mesh, 1, i + 1);
      const auto [surface, around] = winding_with_cones(sided, cones, {points[0], points[1], points[2]});
      const double closed = surface + around;
      CHECK(closed == Approx(std::round(closed)).margin(1e-9));
      most = std::max(most, std::abs(around));
    }
    CHECK(most > 0.01);
  }
  CHECK(closing_cones(SidedMesh(icosphere(2)).oriented.boundary).triangles.empty());
}

TEST_CASE("closing_cones: a hole has a tip in its middle, and holes that are apart have their own") {
  PolygonMesh box = cube();
  std::vector<std::uint8_t> removed(box.polygon_count(), 0);
  removed[0] = removed[1] = 1;  // opposite sides
  remove_polygons(box, removed);
  const SidedMesh sided(box);
  const ClosingCones cones = closing_cones(sided.oriented.boundary);
  CHECK(cones.triangles.size() == 24);
  std::map<std::uint32_t, int> triangles_of_tip;
  for (std::size_t t = 0; t < cones.triangles.size(); t += 3) ++triangles_of_tip[cones.triangles[t + 2]];
  CHECK(triangles_of_tip.size() == 2);
  for (const auto& [tip, count] : triangles_of_tip) {
    CHECK(count == 4);
    const Vector3 at = sided.mesh.unit * Vector3{cones.x[tip], cones.y[tip], cones.z[tip]};
    CHECK(norm(sided.mesh.center + at) == Approx(1).margin(1e-12));  // the middle of a side of the cube
  }
}
