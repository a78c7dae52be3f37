// The program without the laboratory: all commands that make and read stores work; the others say what is
// missing.
#include <filesystem>

#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

struct Place {
  Place() {
    fs::create_directories(scratch / "models/ball");
    fs::create_directories(scratch / "models/ring");
    write_mesh(scratch / "models/ball/a.off", icosphere(2));
    write_mesh(scratch / "models/ball/b.ply", moved(icosphere(1), 2, 1, 0, 0));
    write_mesh(scratch / "models/ring/a.obj", torus(12, 8));
    write_mesh(scratch / "models/ring/b.stl", torus(16, 6));
  }
  std::string path(std::string_view name) const { return scratch / name; }

  ProcessResult with(const std::string& program, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), program);
    return run_process(arguments);
  }
  void does(const std::vector<std::string>& arguments) const {
    const ProcessResult result = with(MEANDER_PROGRAM, arguments);
    INFO(Catch::StringMaker<std::vector<std::string>>::convert(arguments) << ": " << result.err);
    CHECK(result.exit_code == 0);
  }
  // A usage error that names the option or command and the reason; `file` is not created.
  void lacks(const std::vector<std::string>& arguments, const std::string& wish, const char* file) const {
    const ProcessResult result = with(MEANDER_PROGRAM, arguments);
    INFO(Catch::StringMaker<std::vector<std::string>>::convert(arguments) << ": " << result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    CHECK(result.err.find("`" + wish + "` needs the laboratory, and this meander was built without it") !=
          std::string::npos);
    CHECK_FALSE(fs::exists(scratch / file));
  }

  ScratchFolder scratch;
};

}  // namespace

TEST_CASE("without the laboratory: run, surface, describe, retrieve, verify, info and export work") {
  const Place place;
  const std::string store = place.path("s.h5");
  place.does({"run", place.path("models"), "-o", store, "-n", "64", "--label-from-folder"});
  place.does({"describe", store, "--descriptors", "d2,a3", "--bins", "8"});
  place.does({"remesh", place.path("models"), "-o", place.path("meshes"), "-n", "64"});
  place.does({"verify", store});
  place.does({"info", store, "--json"});
  place.does({"export", store, "-o", place.path("points")});
  place.does({"export", store, "-o", place.path("shards"), "--pointnet"});
  place.does({"retrieve", "query", store, "0"});
  place.does({"retrieve", "evaluate", store, "--csv", place.path("t.csv"), "--json"});
  place.does({"retrieve", "select", store});
  place.does({"surface", "torus", "-n", "64", "-o", place.path("t.h5")});
}

TEST_CASE("without the laboratory: commands that need it are usage errors that say so") {
  const Place place;
  const std::string store = place.path("s.h5");
  place.lacks({"run", place.path("models"), "-o", store, "--certify"}, "--certify", "s.h5");
  place.does(
      {"run", place.path("models"), "-o", store, "-n", "64", "--label-from-folder", "--describe", "d2"});
  place.lacks({"render", "sheet", store, "-o", place.path("p.png")}, "render", "p.png");
  place.lacks({"retrieve", "evaluate", store, "--picture", place.path("p.svg")}, "--picture", "p.svg");
  place.lacks({"retrieve", "evaluate", store, "--confusion", place.path("c.png")}, "--confusion", "c.png");
  place.lacks({"measure", "spacing", store, "--surface", "plane", "--csv", place.path("m.csv")}, "measure",
              "m.csv");
  place.lacks({"measure"}, "measure", "m.csv");
  place.lacks({"figures", "-o", place.path("f"), "--quick"}, "figures", "f");
  place.lacks({"figures", "--help"}, "figures", "f");
  const ProcessResult help = place.with(MEANDER_PROGRAM, {"--help"});
  CHECK(help.exit_code == 0);
  CHECK(help.out.find("describe") != std::string::npos);
  CHECK(help.out.find("figures") == std::string::npos);
}

TEST_CASE("without the laboratory: stores have the same bytes") {
  const Place place;
  for (const char* const method : {"auto", "conformal", "direct", "anisotropic"}) {
    const auto store_of = [&](const std::string& program) {
      const std::string store = place.path("s.h5");
      REQUIRE(place
                  .with(program, {"run", place.path("models"), "-o", store, "-n", "64", "--describe", "d2",
                                  "--method", method, "--fresh"})
                  .exit_code == 0);
      return read_file(store);
    };
    CHECK((store_of(MEANDER_PROGRAM) == store_of(MEANDER_BUILT_PROGRAM)));
  }
}
