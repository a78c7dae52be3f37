// What users expect of every command: summaries first, failures that can be allowed, a store that need not be
// named.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/pseudo_terminal.h"
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
  // The program with this folder as its working folder.
  ProcessResult inside(const char* folder, const Words& words) const {
    ProcessOptions options;
    options.in_child = [place = path(folder)] {
      if (::chdir(place.c_str()) != 0) ::_exit(126);
    };
    return meander_with(words, options);
  }
  ScratchFolder scratch;
};

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

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
  // Other exit codes stay. Many more models fail than are in flight, so that there is something to stop.
  for (int i = 0; i < 200; ++i)
    write_file(folder.path("in/") + "broken" + std::to_string(i) + ".off", "OFF\n1");
  CHECK(folder.run({"--allow-failures", "--max-failures", "2", "--fresh", "-j", "2"}).exit_code == 75);
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

TEST_CASE("run: a list in which most paths are wrong is named before the first model is sampled") {
  const Folder folder;
  const auto listed = [&](const std::string& paths, const Words& more = {}) {
    write_file(folder.path("list.txt"), paths);
    return meander_with(joined({"run", "@" + folder.path("list.txt"), "--root", folder.path(""), "-o",
                                folder.path("s.h5"), "-n", "64", "--fresh"},
                               more));
  };
  const std::string good = folder.path("in/ball.off") + "\n",
                    bad = folder.path("no/") + "a.off\n" + folder.path("no/") + "b.off\n";
  const std::string warning = "meander: 2 of 3 inputs do not exist or cannot be opened, such as `no/a.off`; ";
  const ProcessResult most = listed(good + bad);
  CHECK(most.exit_code == 3);
  CHECK(first_line(most.err).starts_with(warning));
  CHECK(contains(listed(good + bad, {"--dry-run"}).err, warning));
  CHECK_FALSE(contains(listed(good + folder.path("in/cube.off\n") + bad).err, "do not exist"));
}

TEST_CASE("info: without a name it takes the only store of the working folder, and says which") {
  const Folder folder;
  fs::create_directory(folder.path("work"));
  const ProcessResult none = folder.inside("work", {"info"});
  CHECK(none.exit_code == 2);
  CHECK(none.err == "meander: STORE is required: there is no store in this folder\n");
  REQUIRE(folder.run().exit_code == 3);
  fs::copy(folder.path("s.h5"), folder.path("work/one.h5"));
  write_file(folder.path("work/notes.txt"), "no store");
  const ProcessResult one = folder.inside("work", {"info", "--json"});
  CHECK(one.exit_code == 0);
  CHECK(one.err == "meander: the store of this folder is `one.h5`\n");
  CHECK(one.out == folder.inside("work", {"info", "one.h5", "--json"}).out);
  // A pack belongs to its index.
  fs::copy(folder.path("s.h5"), folder.path("work/one.pack-00000.h5"));
  CHECK(folder.inside("work", {"info"}).exit_code == 0);
  fs::copy(folder.path("s.h5"), folder.path("work/two.h5"));
  const ProcessResult two = folder.inside("work", {"info"});
  CHECK(two.exit_code == 2);
  CHECK(two.err == "meander: STORE is required: there are 2 stores in this folder, such as `one.h5`\n");
}

TEST_CASE("info: the parameters are one line of JSON, and fit the terminal where there is one") {
  const Folder folder;
  REQUIRE(folder.run({"--density", "formula:1 + max(x, y)"}).exit_code == 3);
  const auto parameters = [](const std::string& out) {
    const std::size_t begin = out.find("parameters {"), end = out.find("}", begin);
    REQUIRE(end != std::string::npos);
    return out.substr(begin, end + 1 - begin);
  };
  const std::string whole = parameters(meander_with({"info", folder.path("s.h5")}).out);
  CHECK_FALSE(contains(whole, "\n"));
  for (const int width : {60, 80}) {
    std::string shown =
        parameters(run_in_terminal({program, "info", folder.path("s.h5")}, width, STDOUT_FILENO).out);
    CAPTURE(shown);
    std::size_t longest = 0, lines = 0;
    for (std::size_t begin = 0; begin < shown.size(); ++lines) {
      const std::size_t end = std::min(shown.find("\r\n", begin), shown.size());
      longest = std::max(longest, end - begin);
      begin = end + 2;
    }
    CHECK(lines > 5);
    CHECK(longest <= static_cast<std::size_t>(width));
    for (std::size_t at; (at = shown.find("\r\n  ")) != std::string::npos;) shown.erase(at, 4);
    CHECK(shown == whole);
  }
}
