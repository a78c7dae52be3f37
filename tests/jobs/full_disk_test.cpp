// Outputs on a full disk: an error that names the file, the old files stay, no partial file remains.
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <functional>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/small_disk.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// A store of three models with a class, samples and descriptors, and the commands that write files from it.
struct Exports {
  ScratchFolder scratch;
  std::string store = scratch / "s.h5";

  Exports() {
    fs::create_directories(scratch / "in");
    write_mesh(scratch / "in/ball.off", icosphere(2));
    write_mesh(scratch / "in/cube.off", cube());
    write_mesh(scratch / "in/ring.off", torus(24, 12));
    const ProcessResult result =
        meander_with({"run", scratch / "in", "-o", store, "-n", "300", "--describe", "d2", "--bins", "1024",
                      "--label-from-folder", "--progress", "none"});
    INFO(result.err);
    REQUIRE(result.exit_code == 0);
  }

  // Whose files are longer than 2,048 bytes.
  std::vector<std::vector<std::string>> commands(const fs::path& folder) const {
    const std::string out = folder / "x";
    const auto descriptors = [&](const char* format) {
      return std::vector<std::string>{"export", store, "--descriptors", "d2",     "--format",
                                      format,   "-o",  out + "/d",      "--fresh"};
    };
    return {{"export", store, "ball.off", "--format", "ply", "-o", out, "--fresh"},
            {"export", store, "ball.off", "--format", "xyz", "-o", out, "--fresh"},
            {"export", store, "--pointnet", "-o", out, "--fresh"},
            {"export", store, "--html", out + "/page.html", "--fresh"},
            {"render", "sheet", store, "-o", out + "/p.png"},
            descriptors("csv"),
            descriptors("fbin"),
            descriptors("npy"),
            descriptors("ann-hdf5")};
  }
  std::vector<std::vector<std::string>> commands_of_short_files(const fs::path& folder) const {
    const std::string out = folder / "x";
    return {
        {"measure", "boxes", store, "--surface", scratch / "in", "--shapes", "1000", "--csv", out + "/b.csv"},
        {"retrieve", "evaluate", store, "--csv", out + "/e.csv"}};
  }
};

// Runs the command twice, the second time without free space, which `take_room` uses up.
void check_without_room(const std::vector<std::string>& command, const fs::path& folder, const char* reason,
                        const std::function<ProcessOptions()>& take_room) {
  fs::create_directory(folder / "x");
  const ProcessResult first = meander_with(command);
  INFO(command[0] << " " << command[1] << " ... " << command.back() << ": " << first.err);
  REQUIRE(first.exit_code == 0);
  const ProcessOptions options = take_room();
  const auto before = content_of(folder);
  const ProcessResult result = meander_with(command, options);
  INFO(result.err);
  CHECK(result.signal == 0);
  // An export into a folder that had room to begin goes on later: by the same command, with or without
  // --fresh.
  const fs::path description = folder / "x/meander-export.json";
  const bool begun = fs::exists(description);
  CHECK(result.exit_code == (begun ? 75 : 2));
  CHECK(contains(result.err, reason));
  CHECK(result.err.ends_with("the same command without --fresh continues\n") == begun);
  CHECK(contains(result.err, (folder / "x").string()));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  if (!begun) {
    CHECK((content_of(folder) == before));
    return;
  }
  const std::string text = read_file(description);
  fs::remove(description);
  CHECK((content_of(folder) == before));
  write_file(description, text);
  CHECK(meander_with({command.begin(), command.end() - 1}).exit_code == 0);
  CHECK((content_of(folder) == before));
}

}  // namespace

TEST_CASE("outputs: a file size limit is reported, the old files stay and no partial file is left") {
  const Exports exports;
  for (const std::vector<std::string>& command : exports.commands(exports.scratch.path())) {
    check_without_room(command, exports.scratch.path(), "File too large", [] {
      ProcessOptions options;
      options.in_child = [] {
        const rlimit limit{2048, 2048};  // standard error is a file too
        setrlimit(RLIMIT_FSIZE, &limit);
      };
      return options;
    });
    fs::remove_all(exports.scratch / "x");
  }
}

TEST_CASE("outputs: a full disk is reported, the old files stay and no partial file is left") {
  const Exports exports;
  const SmallDisk disk(exports.scratch / "disk", 4096);
  if (!disk.mounted()) {
    WARN("skipped: only root can mount a small disk");
    return;
  }
  auto commands = exports.commands(exports.scratch / "disk");
  for (auto& command : exports.commands_of_short_files(exports.scratch / "disk"))
    commands.push_back(std::move(command));
  for (const std::vector<std::string>& command : commands) {
    check_without_room(command, exports.scratch / "disk", "No space left on device", [&] {
      std::ofstream filler(exports.scratch / "disk/filler", std::ios::binary);
      while (filler << std::string(4096, 'x') << std::flush) {
      }
      return ProcessOptions();
    });
    fs::remove_all(exports.scratch / "disk/x");
    fs::remove(exports.scratch / "disk/filler");
  }
}
