#include "kernels/query/boundary_field.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/query/segment_crossings.h"
#include "kernels/query/winding_number.h"
#include "support/catch.h"
#include "support/sided_mesh.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// Open surfaces: with a few large holes, many small ones, sheets, and all triangles apart.
std::vector<PolygonMesh> open_surfaces() {
  return {with_holes(icosphere(4), 0.04, 3), grid_plane(6, 4), moebius_strip(30),
          merged(with_holes(torus(40, 30), 0.1, 5), moved(grid_plane(3, 3), 0.4, 0.2, 0.1, 0.3))};
}

double exact_in(const SidedMesh& sided, Vector3 at) {
  std::vector<std::uint32_t> turned = sided.mesh.triangles;
  for (std::size_t t = 0; t < sided.oriented.flipped.size(); ++t)
    if (sided.oriented.flipped[t] != 0) std::swap(turned[3 * t + 1], turned[3 * t + 2]);
  return exact_winding_number(sided.mesh.x, sided.mesh.y, sided.mesh.z, turned, at);
}

Vector3 point_of(const std::vector<double>& points, std::size_t i) {
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}

}  // namespace

TEST_CASE("winding_change: the gradient is that of winding numbers") {
  for (const PolygonMesh& file : open_surfaces()) {
    const SidedMesh sided(file);
    const BoundaryField field = build_boundary_field(sided.oriented.boundary);
    const std::vector<double> points = side_points(sided.mesh, 60, 3);
    for (std::size_t i = 0; i < points.size() / 3; ++i) {
      const Vector3 at = point_of(points, i);
      // Of a bound of 1e-9 the radius is that within which nothing but the gradient matters.
      const WindingChange change = winding_change(field, at, 1e-9);
      const double step = std::min(1e-6, change.radius);
      for (const Vector3 along : {Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, 0, 1}}) {
        const Vector3 before = at - step * along, after = at + step * along;
        const SegmentCrossings crossed = segment_crossings(sided.tree, sided.oriented.flipped, before, after);
        if (!crossed.sure) continue;
        const double slope =
            (exact_in(sided, after) - exact_in(sided, before) + crossed.outward) / (2 * step);
        CHECK(dot(change.gradient, along) == Approx(slope).margin(0.02 * (1 + norm(change.gradient))));
      }
    }
  }
}

TEST_CASE("winding_change: within its radius winding numbers change as it says, crossings apart") {
  for (const PolygonMesh& file : open_surfaces()) {
    const SidedMesh sided(file);
    const BoundaryField field = build_boundary_field(sided.oriented.boundary);
    const std::vector<double> points = side_points(sided.mesh, 40, 4), ways = side_points(sided.mesh, 40, 5);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < points.size() / 3; ++i)
      for (const double tolerance : {0.02, 0.2}) {
        const Vector3 at = point_of(points, i), direction = point_of(ways, i);
        const WindingChange change = winding_change(field, at, tolerance),
                            by_pairs = winding_change(field, at, tolerance, InstructionSet::scalar);
        CHECK(by_pairs.radius == change.radius);
        CHECK(distance(by_pairs.gradient, change.gradient) == 0);
        REQUIRE(change.radius > 0);
        const Vector3 to = at + (0.999 * change.radius / norm(direction)) * direction;
        const SegmentCrossings crossed = segment_crossings(sided.tree, sided.oriented.flipped, at, to);
        if (!crossed.sure) continue;
        const double expected = exact_in(sided, at) - crossed.outward + dot(change.gradient, to - at);
        CHECK(std::abs(exact_in(sided, to) - expected) <= tolerance);
        ++compared;
      }
    CHECK(compared > 60);
  }
}

TEST_CASE("winding_change: nothing changes around closed surfaces, and little far away") {
  const SidedMesh closed(icosphere(2));
  CHECK(closed.oriented.boundary.empty());
  const WindingChange none = winding_change(build_boundary_field({}), {0.1, 0.2, 0.3}, 0.1);
  CHECK(norm(none.gradient) == 0);
  CHECK(none.radius > 1e9);
  const SidedMesh sheet(grid_plane(4, 4));
  const BoundaryField field = build_boundary_field(sheet.oriented.boundary);
  CHECK(norm(winding_change(field, {0, 0, 1e4}, 0.1).gradient) < 1e-9);
  // On an edge itself nothing is known.
  const double* const edge = sheet.oriented.boundary.data();
  const Vector3 on{0.5 * (edge[0] + edge[3]), 0.5 * (edge[1] + edge[4]), 0.5 * (edge[2] + edge[5])};
  CHECK(winding_change(field, on, 0.1).radius < 1e-5);
}
