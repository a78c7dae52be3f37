// What users expect of every command: summaries first, failures that can be allowed.
#include <filesystem>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

using Words = std::vector<std::string>;

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

// Two meshes, and a file without a face.
struct Folder {
  Folder() {
    fs::create_directory(scratch / "in");
    write_mesh(scratch / "in/ball.off", icosphere(2));
    write_mesh(scratch / "in/cube.off", cube());
    write_file(scratch / "in/bad.off", "OFF\n1 0 0\n0 0 0\n");
  }
  std::string path(const char* name) const { return scratch / name; }
  ProcessResult run(const Words& more = {}) const {
    return meander_with(joined({"run", path("in"), "-o", path("s.h5"), "-n", "64"}, more));
  }
  ScratchFolder scratch;
};

}  // namespace

TEST_CASE("failures: with --allow-failures a command that would end with 3 ends with 0, and does the same") {
  const Folder folder;
  const auto check = [](const Words& command) {
    INFO(Catch::StringMaker<Words>::convert(command));
    const ProcessResult failed = meander_with(command);
    INFO(failed.err);
    CHECK(failed.exit_code == 3);
    const ProcessResult allowed = meander_with(joined(command, {"--allow-failures"}));
    CHECK(allowed.exit_code == 0);
    CHECK(contains(allowed.out + allowed.err, "empty") == contains(failed.out + failed.err, "empty"));
  };
  check({"run", folder.path("in"), "-o", folder.path("s.h5"), "-n", "64", "--fresh", "--describe", "d2"});
  check({"remesh", folder.path("in"), "-o", folder.path("meshes"), "-n", "64", "--fresh"});
  check({"surface", "plane", "0*u, 0, 0", "-o", folder.path("plane.h5"), "-n", "64", "--fresh"});
  check({"retrieve", "query", folder.path("s.h5"), "--mesh", folder.path("in")});
  REQUIRE(
      meander_with({"plan", folder.path("in"), "-o", folder.path("array.h5"), "-n", "64", "--shards", "1"})
          .exit_code == 0);
  const Words task = {"run", folder.path("array.h5.run"), "--shard", "0/1"};
  CHECK(contains(meander_with(joined(task, {"--allow-failures"})).err,
                 "--allow-failures: a shard ends with 0"));
  REQUIRE(meander_with(task).exit_code == 0);
  check({"merge", folder.path("array.h5.run")});
  // Other exit codes stay.
  CHECK(folder.run({"--allow-failures", "--max-failures", "0", "--fresh"}).exit_code == 75);
  CHECK(folder.run({"--allow-failures", "--method", "none"}).exit_code == 2);
}

TEST_CASE("run --dry-run: the summary comes before the models") {
  const Folder folder;
  const ProcessResult dry = folder.run({"--dry-run"});
  CHECK(dry.exit_code == 0);
  CHECK(dry.out.starts_with("3 models, "));
  CHECK(dry.out.find("largest model needs about") < dry.out.find("ball.off\t"));
  CHECK(contains(dry.out, "cube.off\t\t"));
}
