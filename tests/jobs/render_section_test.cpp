// meander render section: planes through surfaces, of meshes and of stores.
#include <filesystem>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

struct SectionPlace {
  SectionPlace() {
    fs::create_directories(scratch / "in");
    write_mesh(scratch / "in/a.off", torus(32, 16));
    write_mesh(scratch / "in/b.ply", icosphere(3));
    write_mesh(scratch / "sheet.off", grid_plane(6, 6));
  }
  std::string path(std::string_view name) const { return (scratch / name).string(); }
  ProcessResult section(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {program, "render", "section", "--size", "96", "-o", path("p.png")};
    words.insert(words.end(), more.begin(), more.end());
    fs::remove(path("p.png"));
    return run_process(words);
  }
  std::string picture(const std::vector<std::string>& more) const {
    const ProcessResult result = section(more);
    INFO(result.err);
    CHECK(result.exit_code == 0);
    return read_file(path("p.png"));
  }
  std::string refusal(const std::vector<std::string>& more) const {
    const ProcessResult result = section(more);
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    CHECK_FALSE(fs::exists(path("p.png")));
    return result.err;
  }

  ScratchFolder scratch;
};

}  // namespace

TEST_CASE("render section: axis, place and sign change the picture, threads do not") {
  const SectionPlace place;
  const std::string mesh = place.path("in/a.off"), first = place.picture({mesh});
  CHECK(place.picture({mesh, "--axis", "z", "--at", "0", "-j", "1"}) == first);
  CHECK(place.picture({mesh, "--axis", "x"}) != first);
  CHECK(place.picture({mesh, "--at", "-0.1"}) != first);
  CHECK(place.picture({mesh, "--sign", "none"}) != first);
  CHECK(contains(place.section({mesh, "--sign", "shell"}).out, "sign shell"));
}

TEST_CASE("render section: several models, and what is said of each") {
  const SectionPlace place;
  const ProcessResult result = place.section({place.path("in"), place.path("sheet.off"), "--axis", "y"});
  CHECK(result.exit_code == 0);
  CHECK(contains(result.out, "p.png: 3 models\n"));
  CHECK(contains(result.out, "a.off: y = 0; sign closed, 0.0 % uncertain\n"));
  CHECK(contains(result.out, "sheet.off: y = "));
  CHECK(contains(result.out, "sign shell"));
  const ProcessResult json = place.section({place.path("in/b.ply"), "--json"});
  CHECK(contains(json.out, "\"sign\":\"closed\""));
  CHECK(contains(json.out, "\"uncertain\":0"));
}

TEST_CASE("render section: a model that cannot be drawn says why") {
  const SectionPlace place;
  const ProcessResult some =
      place.section({place.path("sheet.off"), place.path("in/a.off"), "--sign", "closed"});
  CHECK(some.exit_code == 3);
  CHECK(contains(some.out, "the surface is not closed: it has 24 open edges"));
  CHECK(fs::exists(place.path("p.png")));
  const ProcessResult none = place.section({place.path("sheet.off"), "--sign", "closed"});
  CHECK(none.exit_code == 3);
  CHECK(contains(none.err, "no picture was written"));
  CHECK_FALSE(fs::exists(place.path("p.png")));
}

TEST_CASE("render section: rows of a store with the inputs of its run") {
  const SectionPlace place;
  REQUIRE(run_process({program, "run", place.path("in"), "-o", place.path("s.h5"), "-n", "64"}).exit_code ==
          0);
  const std::string store = place.path("s.h5");
  const ProcessResult both = place.section({store, place.path("in")});
  CHECK(both.exit_code == 0);
  CHECK(contains(both.out, "2 models"));
  CHECK(place.picture({store, place.path("in"), "--item", "0"}) == place.picture({place.path("in/a.off")}));
  write_mesh(place.scratch / "in/a.off", torus(33, 16));
  const ProcessResult changed = place.section({store, place.path("in")});
  CHECK(changed.exit_code == 3);
  CHECK(contains(changed.out, "the mesh has changed"));
  CHECK(contains(place.refusal({store}), "give the INPUT of its run as well"));
}

TEST_CASE("render section: mistakes are usage errors, and nothing is written") {
  const SectionPlace place;
  const std::string mesh = place.path("in/a.off");
  CHECK(contains(place.refusal({mesh, "--axis", "w"}), "--axis"));
  CHECK(contains(place.refusal({mesh, "--item", "0"}), "is not a store"));
  CHECK(contains(place.refusal({mesh, "--at", "1e300"}), "--at"));
  CHECK(contains(place.refusal({mesh, "--size", "8"}), "--size"));
  CHECK(contains(place.refusal({mesh, "--memory", "10K"}), "--memory"));
  const ProcessResult other = run_process({program, "render", "section", mesh, "-o", place.path("p.jpg")});
  CHECK(other.exit_code == 2);
  CHECK(contains(other.err, ".png"));
}
