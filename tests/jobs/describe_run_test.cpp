// run --describe: descriptors in the same pass.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "kernels/describe/depth_views.h"
#include "kernels/describe/shape_dna.h"
#include "kernels/describe/shell_harmonics.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

ProcessResult run(const ScratchFolder& scratch, const std::string& store, std::vector<std::string> more) {
  std::vector<std::string> arguments = {program, "run", scratch / "in", "-o", store};
  if (std::find(more.begin(), more.end(), "-n") == more.end()) more.insert(more.end(), {"-n", "400"});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_process(arguments);
}

void sample_described(const ScratchFolder& scratch, const char* store, std::vector<std::string> more) {
  more.insert(more.end(), {"-n", "1024"});
  const ProcessResult result = run(scratch, scratch / store, more);
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
}

std::vector<float> descriptor_values(const StoreReader& store, const std::string& id, const char* name) {
  for (const DescriptorRow& row : store.read_row(*store.find(id)).descriptors)
    if (row.name == name) return row.values;
  return {};
}

double sum_of_differences(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(double{a[i]} - double{b[i]});
  return sum;
}

PolygonMesh stretched(PolygonMesh mesh, double factor) {
  for (double& x : mesh.x) x *= factor;
  return mesh;
}

enum class Kept { yes, no, unclear };

// That a descriptor is that of the surface: kept by motion, size, sense of faces, other triangles and other
// samples, another for another surface; `describe` gives the bits of `run`, and emd is refused for it.
template <class Compare>
void check_kept(const ScratchFolder& scratch, const std::string& name, bool needs_meshes,
                const PolygonMesh& reference, const PolygonMesh& remeshed, const PolygonMesh& other,
                const Compare& compare) {
  std::filesystem::create_directories(scratch / "in");
  write_mesh(scratch / "in/reference.off", reference);
  write_mesh(scratch / "in/moved.off", moved(reference, 7, 1, 2, 3));
  write_mesh(scratch / "in/turned.off", inside_out(reference));
  write_mesh(scratch / "in/remeshed.off", remeshed);
  write_mesh(scratch / "in/other.off", other);
  sample_described(scratch, "a.h5", {"--describe", "d2," + name});
  sample_described(scratch, "b.h5", {"--describe", name, "--seed", "2"});
  sample_described(scratch, "c.h5", {"--describe", "d2"});
  std::vector<std::string> describe = {program, "describe", scratch / "c.h5", "--descriptors", name};
  if (needs_meshes) describe.push_back(scratch / "in");
  const ProcessResult added = run_process(describe);
  INFO(added.err);
  REQUIRE(added.exit_code == 0);
  const StoreReader store(scratch / "a.h5"), seeded(scratch / "b.h5"), later(scratch / "c.h5");
  const auto values = [&](const StoreReader& of, const std::string& id) {
    return descriptor_values(of, id, name.c_str());
  };
  const std::vector<float> expected = values(store, "reference.off");
  const auto compared = [&](const std::vector<float>& found) {
    REQUIRE(found.size() == expected.size());
    return compare(expected, found);
  };
  for (const char* id : {"moved.off", "turned.off", "remeshed.off"}) {
    INFO(id);
    CHECK(compared(values(store, id)) == Kept::yes);
    CHECK(compared(values(seeded, id)) == Kept::yes);
  }
  CHECK(compared(values(store, "other.off")) == Kept::no);
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    CHECK(values(later, store.id(row)) == values(store, store.id(row)));
  const ProcessResult emd = run_process(
      {program, "retrieve", "query", scratch / "a.h5", "0", "--descriptor", name, "--distance", "emd"});
  CHECK(emd.exit_code == 2);
  CHECK(emd.err.find("emd measures along a line of bins") != std::string::npos);
}

}  // namespace

TEST_CASE("run --describe: every ok row has histograms that sum to 1, with the same bytes for any threads") {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "in");
  write_mesh(scratch / "in/ball.off", icosphere(3));
  write_mesh(scratch / "in/ring.off", torus(24, 12));
  write_mesh(scratch / "in/cube.off", cube());  // squares: polygons of two triangles
  write_mesh(scratch / "in/two.off", merged(icosphere(2), moved(icosphere(2), 1, 5, 0, 0)));
  write_file(scratch / "in/broken.off", "OFF\n3 1 0\n0 0\n");
  const std::string a = scratch / "a.h5", b = scratch / "b.h5";
  const std::vector<std::string> describe = {"--describe", "d2,a3,d1,d3,d4,geodesic", "--bins", "16"};
  auto with = [&](const char* threads) {
    std::vector<std::string> more = describe;
    more.insert(more.end(), {"-j", threads});
    return more;
  };
  const ProcessResult result = run(scratch, a, with("1"));
  INFO(result.err);
  REQUIRE(result.exit_code == 3);
  REQUIRE(run(scratch, b, with("2")).exit_code == 3);
  CHECK(read_file(a) == read_file(b));
  CHECK(verify_store(a).problems.empty());
  const StoreReader reader(a);
  REQUIRE(reader.descriptors().size() == 7);
  for (std::uint64_t row = 0; row < reader.rows(); ++row) {
    const Row content = reader.read_row(row);
    if (content.report.status != Status::ok) continue;
    REQUIRE(content.descriptors.size() == 7);
    for (const DescriptorRow& descriptor : content.descriptors) {
      if (descriptor.name == "geodesic_disconnected") continue;
      INFO(reader.id(row) << " " << descriptor.name);
      CHECK(std::accumulate(descriptor.values.begin(), descriptor.values.end(), 0.0) ==
            Approx(1).epsilon(1e-5));
    }
  }
  // On a sphere chords have a density that grows linearly to the diameter, 3/2 of their mean.
  const std::vector<float> chords = reader.read_row(*reader.find("ball.off")).descriptors[0].values;
  for (std::size_t bin = 0; bin < 8; ++bin)
    CHECK(chords[bin] == Approx((2.0 * static_cast<double>(bin) + 1) / 64).margin(0.004));
  // Two spheres have geodesics within each only: those of one sphere.
  const auto one = reader.read_row(*reader.find("ball.off")).descriptors[5].values,
             two = reader.read_row(*reader.find("two.off")).descriptors[5].values;
  // Half of the pairs of two equal parts, but for the sample itself.
  const Row apart = reader.read_row(*reader.find("two.off"));
  CHECK(apart.descriptors[6].name == "geodesic_disconnected");
  CHECK(apart.descriptors[6].values.at(0) == Approx(0.5).margin(0.02));
  CHECK(reader.read_row(*reader.find("ball.off")).descriptors[6].values.at(0) == 0);
  double difference = 0;
  for (std::size_t bin = 0; bin < one.size(); ++bin) difference += std::abs(one[bin] - two[bin]);
  CHECK(difference < 0.2);
}

TEST_CASE("run --describe: mistakes are usage errors") {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "in");
  write_mesh(scratch / "in/ball.off", icosphere(1));
  const auto error_of = [&](const std::vector<std::string>& more) {
    const ProcessResult result = run(scratch, scratch / "s.h5", more);
    CHECK(result.exit_code == 2);
    return result.err;
  };
  CHECK(error_of({"--describe", "d2,geodsic"}).find("did you mean `geodesic`?") != std::string::npos);
  CHECK(error_of({"--bins", "64"}).find("--bins applies to d2") != std::string::npos);
  CHECK(error_of({"--describe", "d2", "--bins", "4"})
            .find("--bins takes a whole number from 8 to 1024, not `4`") != std::string::npos);
  const ProcessResult few =
      run_process({program, "run", scratch / "in", "-o", scratch / "s.h5", "-n", "3", "--describe", "d2"});
  CHECK(few.exit_code == 2);
  CHECK(few.err.find("at least 4 samples") != std::string::npos);
  CHECK(error_of({"--density-floor", "0.1"}).find("curvature") != std::string::npos);
}

TEST_CASE("harmonics: invariant to motion and face orientation, stable under other triangles and samples") {
  const ScratchFolder scratch;
  check_kept(scratch, "harmonics", false, two_sided_plate(2, 0.5), two_sided_plate(7, 0.5),
             two_sided_plate(2, 0.2), [](const std::vector<float>& a, const std::vector<float>& b) {
               REQUIRE(a.size() == shell_harmonic_values);
               const double difference = sum_of_differences(a, b);
               return difference < 0.6 ? Kept::yes : difference > 2 ? Kept::no : Kept::unclear;
             });
  const ProcessResult bins = run(scratch, scratch / "d.h5", {"--describe", "harmonics", "--bins", "64"});
  CHECK(bins.exit_code == 2);
  CHECK(bins.err.find("--bins applies to d2, a3, d1, d3, d4 and geodesic only") != std::string::npos);
}

TEST_CASE("shapedna: invariant to motion and face orientation, stable under other triangles and samples") {
  const ScratchFolder scratch;
  check_kept(scratch, "shapedna", true, torus(40, 24), torus(64, 30), two_sided_plate(2, 0.2),
             [](const std::vector<float>& a, const std::vector<float>& b) {
               REQUIRE(a.size() == shape_dna_values);
               double largest = 0;
               for (std::size_t i = 0; i < a.size(); ++i)
                 largest = std::max(largest, std::abs(double{b[i]} / double{a[i]} - 1));
               return largest < 0.02 ? Kept::yes : largest > 0.1 ? Kept::no : Kept::unclear;
             });
}

TEST_CASE("views: invariant to motion and face orientation, stable under other triangles and samples") {
  const ScratchFolder scratch;
  check_kept(scratch, "views", true, stretched(two_sided_plate(2, 0.5), 2),
             stretched(two_sided_plate(7, 0.5), 2), stretched(two_sided_plate(2, 0.2), 2),
             [](const std::vector<float>& a, const std::vector<float>& b) {
               REQUIRE(a.size() == depth_view_values);
               const double difference = sum_of_differences(a, b);
               return difference < 0.5 ? Kept::yes : difference > 2 ? Kept::no : Kept::unclear;
             });
}
