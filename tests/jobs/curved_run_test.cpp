// meander run --curved: points on the smooth surface that the vertex normals describe.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "kernels/sample/point_frames.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

ProcessResult run_curved(const fs::path& input, const std::string& store,
                         const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {program, "run", input, "-o", store, "--progress", "none"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_process(arguments);
}

Row only_row(const std::string& store) { return StoreReader(store).read_row(0); }

Vector3 point_of(const Row& row, std::size_t i) { return file_point(row.report, row.samples.points, i); }

double farthest_from_sphere(const Row& row, Vector3 center, double radius) {
  double most = 0;
  for (std::size_t i = 0; i < row.samples.count(); ++i)
    most = std::max(most, std::abs(distance(point_of(row, i), center) / radius - 1));
  return most;
}

// How far --curved moves the points of a mesh, over the diagonal of its box.
std::vector<double> moves(const fs::path& mesh, const ScratchFolder& scratch) {
  const std::string flat = scratch / "flat.h5", curved = scratch / "curved.h5";
  REQUIRE(run_curved(mesh, flat, {"-n", "2000", "--method", "direct"}).exit_code == 0);
  REQUIRE(run_curved(mesh, curved, {"-n", "2000", "--method", "direct", "--curved"}).exit_code == 0);
  const Row a = only_row(flat), b = only_row(curved);
  CHECK(a.samples.face == b.samples.face);
  CHECK(a.samples.barycentric == b.samples.barycentric);
  const std::array<double, 6>& box = a.report.bbox;
  const double diagonal = distance({box[0], box[1], box[2]}, {box[3], box[4], box[5]});
  std::vector<double> result;
  for (std::size_t i = 0; i < a.samples.count(); ++i)
    result.push_back(distance(point_of(a, i), point_of(b, i)) / diagonal);
  return result;
}

}  // namespace

TEST_CASE("run --curved: points on coarse spheres are fourth-order accurate, flat ones second-order") {
  const ScratchFolder scratch;
  for (const char* method : {"auto", "conformal", "direct"}) {
    double flat[2], curved[2];
    for (const int level : {0, 1}) {
      const fs::path mesh = scratch / "ball.off";
      write_mesh(mesh, icosphere(level + 1));
      const std::string store = scratch / "s.h5";
      REQUIRE(run_curved(mesh, store, {"-n", "1000", "--method", method, "--fresh"}).exit_code == 0);
      flat[level] = farthest_from_sphere(only_row(store), {}, 1);
      REQUIRE(run_curved(mesh, store, {"-n", "1000", "--method", method, "--curved", "--fresh"}).exit_code ==
              0);
      curved[level] = farthest_from_sphere(only_row(store), {}, 1);
    }
    INFO(method << ": flat " << flat[0] << " " << flat[1] << ", curved " << curved[0] << " " << curved[1]);
    CHECK(flat[0] > 0.04);
    CHECK(flat[0] / flat[1] == Approx(4).epsilon(0.15));
    CHECK(curved[0] < 0.1 * flat[0]);
    CHECK(curved[0] / curved[1] > 11);
  }
}

TEST_CASE("run --curved: flat faces between creases do not move") {
  const ScratchFolder scratch;
  write_mesh(scratch / "cube.off", cube());
  const std::vector<double> of_cube = moves(scratch / "cube.off", scratch);
  CHECK(*std::max_element(of_cube.begin(), of_cube.end()) < 1e-7);
}

TEST_CASE("run --curved: on a part with planes and fillets only the fillets move") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  const std::vector<double> of_part = moves(shared_data("paper/fandisk.off"), scratch);
  const auto still = std::count_if(of_part.begin(), of_part.end(), [](double d) { return d < 1e-6; });
  INFO(still << " of " << of_part.size());
  CHECK(still > 500);
  CHECK(still < 1900);
  CHECK(*std::max_element(of_part.begin(), of_part.end()) < 0.002);
}

TEST_CASE("run --curved: the same bytes for any threads, with normalized coordinates and descriptors") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_mesh(scratch / "in/ball.off", moved(icosphere(1), 50, 1000, -2000, 3000));
  const std::vector<std::string> points = {"-n", "500", "--normalize", "unit-sphere"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), points.begin(), points.end());
    return more;
  };
  const std::string one = scratch / "one.h5", two = scratch / "two.h5", flat = scratch / "flat.h5",
                    later = scratch / "later.h5";
  REQUIRE(
      run_curved(scratch / "in", one, with({"--curved", "--describe", "d2,geodesic", "-j", "1"})).exit_code ==
      0);
  REQUIRE(
      run_curved(scratch / "in", two, with({"--curved", "--describe", "d2,geodesic", "-j", "2"})).exit_code ==
      0);
  REQUIRE(run_curved(scratch / "in", flat, with({"--describe", "d2,geodesic"})).exit_code == 0);
  REQUIRE(run_curved(scratch / "in", later, with({"--curved"})).exit_code == 0);
  CHECK((read_file(one) == read_file(two)));
  CHECK(verify_store(one).problems.empty());
  const Row row = only_row(one), plain = only_row(flat);
  CHECK(farthest_from_sphere(row, {1000, -2000, 3000}, 50) < 0.005);
  CHECK(farthest_from_sphere(plain, {1000, -2000, 3000}, 50) > 0.04);
  // Geodesics start and end on the mesh; chords are those of the points.
  CHECK(row.descriptors[1].values == plain.descriptors[1].values);
  CHECK(row.descriptors[0].values != plain.descriptors[0].values);
  REQUIRE(run_process({program, "describe", later, scratch / "in", "--descriptors", "geodesic"}).exit_code ==
          0);
  REQUIRE(run_process({program, "describe", later, "--descriptors", "d2"}).exit_code == 0);
  const Row described = only_row(later);
  CHECK(described.descriptors[0].values == row.descriptors[1].values);
  CHECK(described.descriptors[2].values == row.descriptors[0].values);
}
