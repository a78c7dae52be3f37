// meander run --topology none: triangles as they are.
#include <filesystem>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

ProcessResult sample_folder(const ScratchFolder& scratch, const std::string& store, const Arguments& more) {
  Arguments arguments = {program, "run", scratch / "in", "-o", store, "-n", "300", "--progress", "none"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_process(arguments);
}

void write_inputs(const ScratchFolder& scratch) {
  fs::create_directories(scratch / "in");
  write_mesh(scratch / "in/ball.off", icosphere(2));
  write_mesh(scratch / "in/ring.off", torus(20, 12));
}

}  // namespace

TEST_CASE("run --topology none: the points of full, no counts, recorded in the store") {
  const ScratchFolder scratch;
  write_inputs(scratch);
  const std::string full = scratch / "full.h5", none = scratch / "none.h5", two = scratch / "two.h5";
  REQUIRE(sample_folder(scratch, full, {}).exit_code == 0);
  REQUIRE(sample_folder(scratch, none, {"--topology", "none", "-j", "1"}).exit_code == 0);
  REQUIRE(sample_folder(scratch, two, {"--topology", "none", "-j", "2"}).exit_code == 0);
  CHECK((read_file(none) == read_file(two)));
  CHECK(verify_store(none).problems.empty());
  const StoreReader with(full), without(none);
  CHECK(with.parameters_json().find("topology") == std::string::npos);
  CHECK(without.parameters_json().find("\"topology\":\"none\"") != std::string::npos);
  for (std::uint64_t row = 0; row < 2; ++row) {
    const Row a = with.read_row(row), b = without.read_row(row);
    CHECK(a.samples.points == b.samples.points);
    CHECK(a.report.components == 1);
    CHECK(b.report.components == 0);
  }
  CHECK(run_process({program, "info", none, "ring.off"}).out.find("not computed") != std::string::npos);
  CHECK(run_process({program, "info", full, "ring.off"}).out.find("genus 1") != std::string::npos);
  // Another choice is another store.
  CHECK(sample_folder(scratch, none, {}).exit_code == 2);
}

TEST_CASE("run --topology none: descriptors that need topology can be added later, and queries compute it") {
  const ScratchFolder scratch;
  write_inputs(scratch);
  const std::string full = scratch / "full.h5", none = scratch / "none.h5";
  REQUIRE(sample_folder(scratch, full, {"--describe", "geodesic,basics,d2"}).exit_code == 0);
  REQUIRE(sample_folder(scratch, none, {"--topology", "none", "--describe", "d2"}).exit_code == 0);
  REQUIRE(run_process({program, "describe", none, scratch / "in", "--descriptors", "geodesic,basics"})
              .exit_code == 0);
  const StoreReader with(full), without(none);
  for (std::uint64_t row = 0; row < 2; ++row) {
    const Row a = with.read_row(row), b = without.read_row(row);
    for (const DescriptorRow& wanted : a.descriptors)
      for (const DescriptorRow& made : b.descriptors)
        if (made.name == wanted.name) CHECK(made.values == wanted.values);
  }
  const ProcessResult query = run_process({program, "retrieve", "query", none, "--mesh",
                                           scratch / "in/ring.off", "--descriptor", "geodesic", "-k", "1"});
  INFO(query.err);
  CHECK(query.exit_code == 0);
  CHECK(query.out.find("ring.off") != std::string::npos);
}

TEST_CASE("run --topology none: options that need topology are usage errors") {
  const ScratchFolder scratch;
  write_inputs(scratch);
  for (const Arguments& more : {Arguments{"--method", "conformal"}, Arguments{"--density", "mean"},
                                Arguments{"--curved"}, Arguments{"--describe", "geodesic"}}) {
    Arguments all = {"--topology", "none"};
    all.insert(all.end(), more.begin(), more.end());
    const ProcessResult refused = sample_folder(scratch, scratch / "s.h5", all);
    INFO(refused.err);
    CHECK(refused.exit_code == 2);
    CHECK(refused.err.find("needs the topology") != std::string::npos);
    CHECK(!fs::exists(scratch / "s.h5"));
  }
  CHECK(sample_folder(scratch, scratch / "s.h5", {"--topology", "nothing"}).exit_code == 2);
}
