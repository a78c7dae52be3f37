// Sets that are made and written block by block: the same stores whatever way a row comes to them.
#include <filesystem>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;

// One more than are kept in memory.
constexpr std::uint32_t large_set = (1 << 18) + 1;

ProcessResult run_large(const fs::path& input, const fs::path& store,
                        const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"run",        input.string(), "-o", store.string(),
                                        "--progress", "none",         "-n", std::to_string(large_set)};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments, {});
}

void put_two_models(const fs::path& folder) {
  fs::create_directories(folder);
  write_mesh(folder / "a.off", torus(24, 12));
  write_mesh(folder / "c.off", moved(torus(24, 12), 2, 1, 0, 0));
}

}  // namespace

TEST_CASE("run: large sets are the same for one thread and three, kept, reused, merged and described",
          "[release]") {
  const ScratchFolder scratch;
  put_two_models(scratch / "in");
  REQUIRE(run_large(scratch / "in", scratch / "first.h5", {"-j", "1"}).exit_code == 0);
  REQUIRE(run_large(scratch / "in", scratch / "s.h5", {"-j", "3"}).exit_code == 0);
  CHECK((read_file(scratch / "s.h5") == read_file(scratch / "first.h5")));
  CHECK(verify_store(scratch / "s.h5").problems.empty());

  // A third model: the rows of the first two are kept by the one, found by the other run.
  write_mesh(scratch / "in/b.off", cube());
  REQUIRE(run_large(scratch / "in", scratch / "fresh.h5").exit_code == 0);
  const std::string expected = read_file(scratch / "fresh.h5");
  REQUIRE(run_large(scratch / "in", scratch / "s.h5").exit_code == 0);
  CHECK((read_file(scratch / "s.h5") == expected));
  REQUIRE(
      run_large(scratch / "in", scratch / "r.h5", {"--reuse", (scratch / "first.h5").string()}).exit_code ==
      0);
  CHECK((read_file(scratch / "r.h5") == expected));

  REQUIRE(meander_with({"plan", scratch / "in", "-o", scratch / "m.h5", "--shards", "2", "-n",
                        std::to_string(large_set)},
                       {})
              .exit_code == 0);
  for (const char* shard : {"0/2", "1/2"})
    REQUIRE(
        meander_with({"run", scratch / "m.h5.run", "--shard", shard, "--progress", "none"}, {}).exit_code ==
        0);
  REQUIRE(meander_with({"merge", scratch / "m.h5.run"}, {}).exit_code == 0);
  CHECK((read_file(scratch / "m.h5") == expected));

  if (sanitized) return;  // for the time that whole sets take; release builds go on
  // With a descriptor the set is kept in memory; its samples are the same.
  REQUIRE(run_large(scratch / "in", scratch / "d.h5", {"--describe", "basics"}).exit_code == 0);
  const StoreReader plain(scratch / "fresh.h5"), described(scratch / "d.h5");
  for (std::uint64_t row = 0; row < plain.rows(); ++row) {
    const Row one = plain.read_row(row), other = described.read_row(row);
    CHECK((one.samples.points == other.samples.points));
    CHECK((one.samples.curve_rank == other.samples.curve_rank));
    CHECK((one.samples.barycentric == other.samples.barycentric));
  }
}

TEST_CASE("run: a large set that takes too long is a row with status timeout") {
  const ScratchFolder scratch;
  put_two_models(scratch / "in");
  const ProcessResult result = run_large(scratch / "in", scratch / "s.h5", {"--timeout", "30ms"});
  INFO(result.err);
  CHECK(result.exit_code == 3);
  const StoreReader store(scratch / "s.h5");
  for (std::uint64_t row = 0; row < store.rows(); ++row) CHECK(store.report(row).status == Status::timeout);
  CHECK(verify_store(scratch / "s.h5").problems.empty());
}
