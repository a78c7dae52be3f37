// The same bytes for any number of threads, with models above the size from which loops run in parallel.
#include <filesystem>
#include <span>
#include <string>

#include "io/digest.h"
#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "kernels/core/parallel.h"
#include "support/catch.h"
#include "support/fault_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// Two models of more triangles than parallel_threshold, one of many components, and small ones beside them.
void write_models(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const PolygonMesh ball = icosphere(5), ring = torus(160, 60);
  REQUIRE(ball.polygon_count() > parallel_threshold);
  REQUIRE(ring.polygon_count() > parallel_threshold);
  write_mesh(folder / "ball.off", ball);
  write_mesh(folder / "ring.ply", ring);
  PolygonMesh many = icosphere(2);
  for (int i = 1; i < 8; ++i) many = merged(many, moved(icosphere(i % 3), 1, 3.0 * i, 0, 0));
  write_mesh(folder / "many.obj", many);
  for (unsigned i = 0; i < 6; ++i)
    write_mesh(folder / ("small" + std::to_string(i) + ".off"), torus(9 + i, 6));
  write_file(folder / "broken.off", "OFF\n3 1 0\n0 0\n");
}

void check_threads(const std::vector<std::string>& options, const char* samples = "3000") {
  const ScratchFolder scratch;
  write_models(scratch / "in");
  std::string expected;
  for (const char* const threads : {"1", "2", "8"}) {
    if (sanitized && *threads != '2') continue;  // release builds compare
    const std::string store = scratch / (std::string("s") + threads + ".h5");
    std::vector<std::string> command = {fault_program, "run", (scratch / "in").string(),
                                        "-o",          store, "-n",
                                        samples,       "-j",  threads,
                                        "--timeout",   "0",   "--progress",
                                        "none"};
    command.insert(command.end(), options.begin(), options.end());
    const ProcessResult result = run_process(command);
    INFO("-j " << threads << "\n" << result.err);
    REQUIRE(result.exit_code == 3);  // the broken file
    const std::string bytes = read_file(store);
    if (expected.empty()) expected = bytes;
    const bool same = bytes == expected;
    CHECK(same);
  }
  CHECK(verify_store(scratch / "s2.h5").problems.empty());
}

}  // namespace

TEST_CASE("run: a file changed while it is read has a consistent digest and samples, or a status") {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "in");
  // 17 MiB of comments.
  const std::string line = "# " + std::string(126, '-') + "\n";
  std::string padding;
  while (padding.size() < std::size_t{17} << 20) padding += line;
  const std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
  write_file(scratch / "in" / "large.obj", faces + padding);
  write_file(scratch / "in" / "small.obj", faces);
  write_file(scratch / "in" / "wrong.obj", padding + "f 1 2 3\n");
  std::string expected;
  for (const char* const threads : {"1", "2"}) {
    const std::string store = scratch / (std::string("s") + threads + ".h5");
    const ProcessResult result =
        run_process({fault_program, "run", (scratch / "in").string(), "-o", store, "-n", "100", "-j", threads,
                     "--timeout", "0", "--progress", "none"});
    INFO(result.err);
    REQUIRE(result.exit_code == 3);
    const std::string bytes = read_file(store);
    if (expected.empty()) expected = bytes;
    const bool same = bytes == expected;
    CHECK(same);
    const StoreReader reader(store, StoreCheck::every_byte);
    REQUIRE(reader.rows() == 3);
    for (std::uint64_t row = 0; row < 3; ++row) {
      const Row content = reader.read_row(row);
      const std::string file = read_file(scratch / "in" / reader.id(row));
      CHECK(content.report.content_sha256 == sha256(std::as_bytes(std::span(file))));
      CHECK((content.report.status == Status::ok) == (reader.id(row) != "wrong.obj"));
    }
  }
}

TEST_CASE("run: the same bytes with 1, 2 and 8 threads, conformal, with certificate") {
  check_threads({"--method", "conformal", "--certify"});
}
TEST_CASE("run: the same bytes with 1, 2 and 8 threads, conformal, with a curvature density") {
  check_threads({"--method", "conformal", "--density", "mean"});
}
TEST_CASE("run: the same bytes with 1, 2 and 8 threads, auto") { check_threads({"--certify"}); }
TEST_CASE("run: the same bytes with 1, 2 and 8 threads, balanced order over charts") {
  check_threads({"--method", "conformal", "--curve", "balanced"});
}
TEST_CASE("run: the same bytes with 1, 2 and 8 threads, direct") { check_threads({"--method", "direct"}); }
TEST_CASE("run: the same bytes with 1, 2 and 8 threads, anisotropic") {
  check_threads({"--method", "anisotropic"});
}
TEST_CASE("run: the same bytes with 1, 2 and 8 threads, spaced samples in several blocks of a sweep") {
  // Blocks of 4,096: three, with sanitizers two.
  check_threads({"--sequence", "spaced"}, sanitized ? "4500" : "9000");
}
TEST_CASE("run: the same bytes with 1, 2 and 8 threads, all descriptors") {
  check_threads({"--method", "direct", "--describe",
                 "d2,a3,d1,d3,d4,geodesic,basics,pairs,pairs-unsigned,harmonics,views,shapedna"});
}
