// meander render strokes: models painted, from meshes and from stores.
#include <algorithm>
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

struct StrokeScene {
  StrokeScene() {
    fs::create_directories(scratch / "in");
    write_mesh(scratch / "in/a.off", torus(32, 16));
    write_mesh(scratch / "in/b.ply", icosphere(3));
  }
  std::string path(std::string_view name) const { return (scratch / name).string(); }
  // Small, and few strokes.
  ProcessResult strokes(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {program, "render", "strokes"};
    const auto given = [&](const char* option) {
      return std::find(more.begin(), more.end(), option) != more.end();
    };
    if (!given("--size")) words.insert(words.end(), {"--size", "96"});
    words.insert(words.end(), more.begin(), more.end());
    return run_process(words);
  }
  std::string picture(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {path("in/a.off"), "-o", path("p.png")};
    if (std::find(more.begin(), more.end(), "--strokes") == more.end())
      words.insert(words.end(), {"--strokes", "300"});
    words.insert(words.end(), more.begin(), more.end());
    const ProcessResult result = strokes(words);
    INFO(result.err);
    CHECK(result.exit_code == 0);
    CHECK(contains(result.out, "1 picture of 1 model"));
    return read_file(path("p.png"));
  }
  std::string refusal(const std::vector<std::string>& more) const {
    const ProcessResult result = strokes(more);
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    return result.err;
  }

  ScratchFolder scratch;
};

}  // namespace

TEST_CASE("render strokes: every option changes the picture, threads do not") {
  const StrokeScene place;
  std::vector<std::string> pictures;
  for (const std::vector<std::string>& look :
       std::vector<std::vector<std::string>>{{},
                                             {"--medium", "ink"},
                                             {"--medium", "ink", "--tones", "multi"},
                                             {"--palette", "slate"},
                                             {"--size", "120x80"},
                                             {"--up", "z"},
                                             {"--view", "1,0.2,-3"},
                                             {"--light", "1,0.5,0.5"},
                                             {"--margin", "0.2"},
                                             {"--seed", "7"},
                                             {"--strokes", "200"}}) {
    pictures.push_back(place.picture(look));
    CHECK(pictures.back().starts_with("\x89PNG"));
    for (std::size_t i = 0; i + 1 < pictures.size(); ++i) {
      INFO(i << " and " << pictures.size() - 1);
      CHECK((pictures[i] != pictures.back()));
    }
  }
  CHECK((place.picture({"-j", "1"}) == place.picture({"-j", "2"})));
}

TEST_CASE("render strokes: several models and media make a sheet that shows broken models") {
  const StrokeScene place;
  write_file(place.path("in/c.off"), "OFF\n7 8");
  write_file(place.path("in/d.off"), "OFF\n0 0 0\n");
  const ProcessResult sheet = place.strokes(
      {place.path("in"), "-o", place.path("s.png"), "--strokes", "200", "--medium", "pencil,oil"});
  INFO(sheet.err);
  CHECK(sheet.exit_code == 3);
  CHECK(contains(sheet.out, "8 pictures of 4 models, 2 failed"));
  CHECK(read_file(place.path("s.png")).size() > 5000);
  const ProcessResult json = place.strokes({place.path("in"), "-o", place.path("j.png"), "--strokes", "200",
                                            "--medium", "pencil,oil", "--json", "--allow-failures"});
  CHECK(json.exit_code == 0);
  CHECK(json.out == "{\"picture\":\"" + place.path("j.png") +
                        "\",\"pictures\":8,\"models\":4,\"without_surface\":0,\"failed\":2}\n");
  CHECK(read_file(place.path("j.png")) == read_file(place.path("s.png")));
  // Alone there is nothing to show.
  const ProcessResult alone = place.strokes({place.path("in/c.off"), "-o", place.path("n.png")});
  CHECK(alone.exit_code == 3);
  CHECK(contains(alone.err, "c.off: unreadable: "));
  CHECK(contains(alone.err, "no picture was written"));
  CHECK_FALSE(fs::exists(place.path("n.png")));
  const ProcessResult all = place.strokes(
      {place.path("in/a.off"), "-o", place.path("m.png"), "--strokes", "100", "--medium", "all"});
  CHECK(contains(all.out, "7 pictures of 1 model"));
}

TEST_CASE("render strokes: stores with directions, with and without their meshes") {
  const StrokeScene place;
  REQUIRE(run_process({program, "run", place.path("in"), "-o", place.path("s.h5"), "-n", "300", "--method",
                       "anisotropic"})
              .exit_code == 0);
  const ProcessResult with =
      place.strokes({place.path("s.h5"), place.path("in"), "--item", "a.off", "-o", place.path("with.png")});
  INFO(with.err);
  REQUIRE(with.exit_code == 0);
  CHECK(with.err.empty());
  const ProcessResult without =
      place.strokes({place.path("s.h5"), "--item", "a.off", "-o", place.path("without.png")});
  REQUIRE(without.exit_code == 0);
  CHECK(contains(without.out, "1 without a surface"));
  CHECK((read_file(place.path("with.png")) != read_file(place.path("without.png"))));
  // A changed mesh is not used.
  write_mesh(place.path("in/a.off"), torus(30, 16));
  const ProcessResult changed = place.strokes(
      {place.path("s.h5"), place.path("in"), "--item", "a.off", "-o", place.path("changed.png")});
  CHECK(contains(changed.out, "1 without a surface"));
  CHECK((read_file(place.path("changed.png")) == read_file(place.path("without.png"))));
  CHECK(contains(place.strokes({place.path("s.h5"), "-o", place.path("all.png")}).out,
                 "2 pictures of 2 models"));
  // Other stores have no directions.
  REQUIRE(
      run_process({program, "run", place.path("in"), "-o", place.path("plain.h5"), "-n", "64"}).exit_code ==
      0);
  CHECK(contains(place.refusal({place.path("plain.h5"), "-o", place.path("x.png")}), "--method anisotropic"));
}

TEST_CASE("render strokes: mistakes are usage errors, and nothing is written") {
  const StrokeScene place;
  const std::string mesh = place.path("in/a.off"), out = place.path("p.png");
  CHECK(contains(place.refusal({mesh, "-o", place.path("p.jpg")}), "should end in .png"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--medium", "oils"}), "oil"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--medium", "oil", "--tones", "multi"}),
                 "only ink and pencil"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--view", "0,1,0"}), "must not lie along the axis"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--light", "0,0,0"}), "--light"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--light", "1,2"}), "--light: `1,2` is not a direction"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--item", "a"}), "is not a store"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--memory", "1M"}), "need"));
  CHECK(contains(place.refusal({mesh, "-o", out, "--strokes", "0"}), "--strokes"));
  CHECK(contains(place.refusal({place.path("none.off"), "-o", out}), "none.off"));
  for (const char* size : {"10", "x96", "96x96x96"})
    CHECK(contains(run_process({program, "render", "strokes", mesh, "-o", out, "--size", size}).err,
                   "is not a size"));
  CHECK(contains(
      run_process({program, "render", "strokes", place.path("in"), "-o", out, "--size", "96x80"}).err,
      "need a square"));
  CHECK(contains(place.refusal({mesh, "-o", mesh}), "should end in .png"));
  CHECK_FALSE(fs::exists(out));
  // A mesh that needs more than is left of the memory.
  write_mesh(place.path("in/b.ply"), icosphere(6));
  const ProcessResult large =
      place.strokes({place.path("in/b.ply"), "-o", out, "--strokes", "100", "--memory", "30M"});
  CHECK(large.exit_code == 3);
  CHECK(contains(large.err, "too_large"));
}
