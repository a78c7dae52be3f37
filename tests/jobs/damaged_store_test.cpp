// Every command that reads a store refuses a damaged one: a sentence and exit code 2, no crash, no output.
#include <algorithm>
#include <filesystem>

#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

using Words = std::vector<std::string>;

// A store of six models with descriptors and labels, and what was sampled.
struct Sampled {
  ScratchFolder scratch;
  std::string in = scratch / "in", store = scratch / "s.h5", out = scratch / "out";

  Sampled() {
    for (const char* const folder : {"in/ball", "in/ring"}) fs::create_directories(scratch / folder);
    for (unsigned i = 0; i < 3; ++i) {
      write_mesh(scratch / ("in/ball/" + std::to_string(i) + ".off"), icosphere(i));
      write_mesh(scratch / ("in/ring/" + std::to_string(i) + ".off"), torus(8 + i, 5));
    }
    const ProcessResult made = run_process(run_words(store));
    INFO(made.err);
    REQUIRE(made.exit_code == 0);
  }

  Words run_words(const std::string& output) const {
    return {program,      "run",    in,           "-o",    output,   "-n", "40",
            "--method",   "direct", "--describe", "d2,a3", "--bins", "8",  "--label-from-folder",
            "--progress", "none"};
  }

  // Every way to read the store `damaged`. Files are written to `out` if at all.
  std::vector<Words> commands(const std::string& damaged) const {
    fs::create_directories(out);
    std::vector<Words> all = {
        {"info", damaged},
        {"info", damaged, "0", "--json"},
        {"info", damaged, "--failed"},
        {"export", damaged, "-o", out + "/points"},
        {"export", damaged, "0", "-o", out + "/one", "--format", "xyz"},
        {"render", "sheet", damaged, "-o", out + "/sheet.png"},
        {"export", damaged, "--pointnet", "-o", out + "/pointnet"},
        {"export", damaged, "--html", out + "/page.html", "--fresh"},
        {"export", damaged, "--descriptors", "d2", "--format", "csv", "-o", out + "/d2.csv"},
        {"retrieve", "query", damaged, "0", "--csv", out + "/query.csv"},
        {"retrieve", "evaluate", damaged, "--csv", out + "/scores.csv", "--matrix", out + "/matrix"},
        {"retrieve", "select", damaged, "--csv", out + "/select.csv"},
        {"describe", damaged, "--descriptors", "d1", "-o", out + "/described.h5"},
        {"describe", damaged, "--descriptors", "d1"},
        {"measure", "spacing", damaged, "--surface", in, "--csv", out + "/spacing.csv"},
        {"measure", "spacing", damaged + "::0", "--surface", in}};
    for (Words& words : all) words.insert(words.begin(), program);
    all.push_back(run_words(damaged));  // the store is finished: it is summarized
    all.push_back(run_words(out + "/reused.h5"));
    all.back().insert(all.back().end(), {"--reuse", damaged});
    return all;
  }
};

std::string joined(const Words& words) {
  std::string text;
  for (const std::string& word : words) text += word + " ";
  return text;
}

// The file is refused by every command and stays as it is.
void check_refused(const Sampled& sampled, const std::string& damaged) {
  const std::string before = read_file(damaged);
  for (const Words& command : sampled.commands(damaged)) {
    const ProcessResult result = run_process(command);
    INFO(joined(command) << "\nexit " << result.exit_code << " signal " << result.signal << "\n"
                         << result.out.substr(0, 300) << result.err.substr(0, 300));
    CHECK(result.signal == 0);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, damaged));
    CHECK(contains(result.err, "--trust"));
    CHECK(result.out.empty());
    CHECK(fs::is_empty(sampled.out));
    const bool unchanged = read_file(damaged) == before;
    CHECK(unchanged);
    CHECK_FALSE(fs::exists(damaged + ".run"));
    if (!fs::is_empty(sampled.out)) {
      fs::remove_all(sampled.out);
      fs::create_directories(sampled.out);
    }
  }
  const ProcessResult verified = run_process({program, "verify", damaged});
  CHECK(verified.exit_code == 3);
  CHECK(contains(verified.out, "1 problem"));
}

}  // namespace

TEST_CASE("damaged store: every command that reads one ends with a message, exit 2 and no output") {
  const Sampled sampled;
  const std::string good = read_file(sampled.store);
  const std::string damaged = sampled.scratch / "damaged.h5";
  // The tables of HDF5 come first, filtered chunks after them. The first block is damaged too.
  for (const std::size_t at :
       thinned<std::size_t>(4, {14, 3000, good.size() / 2, good.size() - 1, 512, 900, good.size() / 3})) {
    INFO("byte " << at << " of " << good.size());
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 4);
    write_file(damaged, bytes);
    check_refused(sampled, damaged);
  }
}

TEST_CASE(
    "damaged store: the same commands read an undamaged one, and --trust reads one with a wrong first "
    "block") {
  const Sampled sampled;
  std::string bytes = read_file(sampled.store);
  bytes[20] = static_cast<char>(bytes[20] ^ 1);  // of the text in the first block, which HDF5 does not read
  const std::string touched = sampled.scratch / "touched.h5";
  write_file(touched, bytes);
  for (const bool trusted : {false, true})
    for (Words command : sampled.commands(trusted ? touched : sampled.store)) {
      if (command[1] == "describe" && command.back() == "d1") continue;  // would change the store
      if (trusted) command.push_back("--trust");
      const ProcessResult result = run_process(command);
      INFO(joined(command) << "\n" << result.out.substr(0, 300) << result.err.substr(0, 300));
      CHECK(result.exit_code == 0);
      fs::remove_all(sampled.out);
      fs::create_directories(sampled.out);
    }
}

TEST_CASE("damaged store: the shared reproducers are refused by every command") {
  MEANDER_NEEDS_SHARED_DATA();
  const fs::path repro = fs::path(MEANDER_SHARED_DATA) / "../repro";
  const Sampled sampled;
  for (const char* const name : {"store_bitflip_scale.h5", "store_metadata_segfault.h5"}) {
    if (!fs::exists(repro / name)) {
      WARN("skipped: " << name << " is not beside this clone");
      continue;
    }
    const std::string copy = sampled.scratch / name;
    write_file(copy, read_file(repro / name));
    check_refused(sampled, copy);
  }
}
