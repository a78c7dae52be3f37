#include "kernels/sample/point_frames.h"

#include <cmath>

#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("point frames: points convert from the store to the file and to working units, and back") {
  const PreparedMesh mesh = prepare_mesh(moved(cube(), 300, 5000, -7000, 11000));
  for (const NormalizeKind kind : {NormalizeKind::none, NormalizeKind::unit_box, NormalizeKind::unit_sphere,
                                   NormalizeKind::unit_diagonal}) {
    const OutputFrame frame = output_frame(mesh, kind);
    ItemReport report;
    report.loc = {frame.loc.x, frame.loc.y, frame.loc.z};
    report.scale = frame.scale;
    std::vector<double> working;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      const Vector3 p = mesh.position(v);
      working.insert(working.end(), {p.x, p.y, p.z});
      CHECK(distance(to_working(mesh, to_file(mesh, p)), p) < 1e-12);
    }
    const std::vector<float> stored = stored_points(working, mesh, frame);
    const std::vector<double> again = working_points(report, stored, mesh);
    REQUIRE(again.size() == working.size());
    // float32 coordinates of some 10^4 around a box of 600 without normalization.
    const double tolerance = kind == NormalizeKind::none ? 1e-5 : 2e-7;
    for (std::size_t i = 0; i < working.size(); ++i) CHECK(again[i] == Approx(working[i]).margin(tolerance));
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      CHECK(distance(file_point(report, stored, v), to_file(mesh, mesh.position(v))) < 2e-5 * mesh.diagonal);
  }
}

TEST_CASE("point frames: stored points have no negative zeros") {
  const PreparedMesh mesh = prepare_mesh(cube());
  const std::vector<double> working = {-0.0, -1e-60, 0.25};
  for (const float value : stored_points(working, mesh, output_frame(mesh, NormalizeKind::unit_box)))
    CHECK_FALSE(std::signbit(value));
}
