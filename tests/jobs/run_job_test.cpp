// The program as a user runs it: kills, signals, second processes, full disks, other threads, shuffled input.
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/catch.h"
#include "support/collection.h"
#include "support/fault_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

std::vector<std::string> run_command(const std::filesystem::path& input, const std::filesystem::path& store,
                                     std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {fault_program, "run", input.string(), "-o", store.string(),
                                        "-n",          "64"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace

TEST_CASE("run: one row per file with the expected status, exit 3, a list of failures that can be rerun") {
  const ScratchFolder scratch;
  const auto expected = write_collection(scratch / "in");
  write_file(scratch / "in/notes.txt", "not a mesh");
  const auto store = scratch / "s.h5";
  const ProcessResult result = run_process(run_command(scratch / "in", store, {"--label-from-folder"}));
  INFO(result.err);
  REQUIRE(result.exit_code == 3);
  CHECK(result.out.find(".txt 1") != std::string::npos);
  const StoreReader reader(store);
  REQUIRE(reader.rows() == expected.size());
  std::uint64_t row = 0;
  for (const auto& [id, status] : expected) {
    INFO(id << ": " << reader.report(row).reason);
    CHECK(reader.id(row) == id);
    CHECK(reader.report(row).status == status);
    CHECK(reader.report(row).reason.empty() == (status == Status::ok));
    CHECK(reader.report(row).file_bytes == std::filesystem::file_size(scratch / "in" / id));
    CHECK(reader.label_names()[static_cast<std::size_t>(reader.label(row))] == id.substr(0, id.find('/')));
    if (status != Status::ok)
      CHECK(result.err.find(id + ": " + std::string(name_of(status)) + ": ") != std::string::npos);
    ++row;
  }
  CHECK(verify_store(store).problems.empty());
  const ProcessResult again = run_process({fault_program, "run", "@" + store.string() + ".failed.txt", "-o",
                                           (scratch / "f.h5").string(), "-n", "64"});
  CHECK(again.exit_code == 3);
  CHECK(StoreReader(scratch / "f.h5").rows() == 6);
  // Equal content gives equal rows whatever its name.
  const Row one = reader.read_row(*reader.find("odd/moebius.off")),
            copy = reader.read_row(*reader.find("odd/copy_of_moebius.off"));
  CHECK(one.samples.points == copy.samples.points);
}

TEST_CASE("run: the same bytes for other threads, memory, input order and after being stopped") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  REQUIRE(run_process(run_command(scratch / "in", scratch / "a.h5", {"-j", "1"})).exit_code == 3);
  REQUIRE(
      run_process(run_command(scratch / "in", scratch / "b.h5", {"-j", "2", "--memory", "64M"})).exit_code ==
      3);
  CHECK(same_bytes(scratch / "a.h5", scratch / "b.h5"));

  // A list in shuffled order with the same ids: paths relative to the folder.
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(scratch / "in"))
    if (entry.is_regular_file())
      files.push_back(std::filesystem::relative(entry.path(), scratch / "in").string());
  std::shuffle(files.begin(), files.end(), std::mt19937(7));
  std::string list;
  for (const std::string& file : files) list += file + "\n";
  ProcessOptions options;
  options.input = list;
  options.in_child = [&] { std::filesystem::current_path(scratch / "in"); };
  REQUIRE(run_process(run_command("-", scratch / "c.h5"), options).exit_code == 3);
  CHECK(same_bytes(scratch / "a.h5", scratch / "c.h5"));
}

TEST_CASE("run: killed at random moments and restarted, it ends with the bytes of an undisturbed run") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  REQUIRE(run_process(run_command(scratch / "in", scratch / "calm.h5")).exit_code == 3);
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "slow:25"}};
  // More threads would be done before the second kill.
  const ProcessResult result =
      run_killed(run_command(scratch / "in", scratch / "s.h5", {"-j", "2"}), options,
                 {3, 20, std::chrono::milliseconds(30), std::chrono::milliseconds(180)}, 3,
                 [&] { std::filesystem::remove(scratch / "s.h5"); });
  INFO(result.err);
  REQUIRE(result.exit_code == 3);
  CHECK(same_bytes(scratch / "calm.h5", scratch / "s.h5"));
  CHECK_FALSE(std::filesystem::exists(scratch / "s.h5.run"));
}

TEST_CASE("run: an item that crashes the process is identified among its neighbors and recorded") {
  for (const std::string kind : {"segv", "abort"}) {
    const ScratchFolder scratch;
    const auto expected = write_collection(scratch / "in");
    ProcessOptions options;
    options.environment = {{"MEANDER_TEST_FAULT", kind + ":torus/5"}};
    const ProcessResult died = run_process(run_command(scratch / "in", scratch / "s.h5"), options);
    REQUIRE(died.signal == (kind == "segv" ? SIGSEGV : SIGABRT));
    const ProcessResult second = run_process(run_command(scratch / "in", scratch / "s.h5"), options);
    INFO(second.err);
    REQUIRE(second.exit_code == 3);
    const StoreReader reader(scratch / "s.h5");
    for (std::uint64_t row = 0; row < reader.rows(); ++row) {
      const bool crashed = reader.id(row) == "torus/5.ply";
      CHECK(reader.report(row).status == (crashed ? Status::crashed : expected.at(reader.id(row))));
      if (crashed) CHECK(reader.report(row).reason.find("place_samples") != std::string::npos);
    }
    // Corrected: the row is processed again, and the store is that of a run that never crashed.
    REQUIRE(run_process(run_command(scratch / "in", scratch / "s.h5", {"--retry", "crashed"})).exit_code ==
            3);
    REQUIRE(run_process(run_command(scratch / "in", scratch / "calm.h5")).exit_code == 3);
    CHECK(same_bytes(scratch / "calm.h5", scratch / "s.h5"));
  }
}

TEST_CASE("run: a stopped run exits with 75, marks nothing, and the same command resumes") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  ProcessOptions options;
  options.environment = {{"MEANDER_TEST_FAULT", "stop:torus/3"}};
  const ProcessResult stopped = run_process(run_command(scratch / "in", scratch / "s.h5"), options);
  INFO(stopped.err);
  REQUIRE(stopped.exit_code == 75);
  CHECK(stopped.err.find("the same command continues") != std::string::npos);
  const ProcessResult rest = run_process(run_command(scratch / "in", scratch / "s.h5"));
  REQUIRE(rest.exit_code == 3);
  REQUIRE(run_process(run_command(scratch / "in", scratch / "calm.h5")).exit_code == 3);
  CHECK(same_bytes(scratch / "calm.h5", scratch / "s.h5"));
}

TEST_CASE("run: a second process on the same store exits with 75 and disturbs nothing") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  ProcessResult first;
  std::thread background([&] {
    ProcessOptions options;
    options.environment = {{"MEANDER_TEST_FAULT", "hold:" + (scratch / "go").string()}};
    first = run_process(run_command(scratch / "in", scratch / "s.h5"), options);
  });
  // Whoever has begun an item holds the lock.
  const auto begun = [&] {
    std::error_code none;
    const std::uintmax_t bytes = std::filesystem::file_size(scratch / "s.h5.run/begun.log", none);
    return !none && bytes > 0;
  };
  for (int i = 0; i < 30000 && !begun(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  const ProcessResult second = run_process(run_command(scratch / "in", scratch / "s.h5"));
  write_file(scratch / "go", "");
  background.join();
  CHECK(second.exit_code == 75);
  CHECK(first.exit_code == 3);
  CHECK(verify_store(scratch / "s.h5").problems.empty());
}

TEST_CASE("run: a full disk exits with 75, and the run resumes once there is room") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  ProcessOptions options;
  options.in_child = [] {  // a limit on file sizes, which fails writes as a quota does
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20000, 20000};
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  const ProcessResult full = run_process(run_command(scratch / "in", scratch / "s.h5"), options);
  INFO(full.err);
  REQUIRE(full.exit_code == 75);
  CHECK(full.err.ends_with("File too large; the same command continues\n"));
  const ProcessResult anew = run_process(run_command(scratch / "in", scratch / "s.h5", {"--fresh"}), options);
  CHECK(anew.exit_code == 75);
  CHECK(anew.err.ends_with("File too large; the same command without --fresh continues\n"));
  CHECK_FALSE(std::filesystem::exists(scratch / "s.h5"));
  REQUIRE(run_process(run_command(scratch / "in", scratch / "s.h5")).exit_code == 3);
  REQUIRE(run_process(run_command(scratch / "in", scratch / "calm.h5")).exit_code == 3);
  CHECK(same_bytes(scratch / "calm.h5", scratch / "s.h5"));
}

TEST_CASE("run: a finished store is unchanged, other parameters are refused, --fresh replaces it") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  const auto store = scratch / "s.h5";
  REQUIRE(run_process(run_command(scratch / "in", store)).exit_code == 3);
  const std::string before = read_file(store);
  CHECK(run_process(run_command(scratch / "in", store)).exit_code == 3);
  CHECK(read_file(store) == before);
  const ProcessResult other = run_process(run_command(scratch / "in", store, {"--seed", "2"}));
  CHECK(other.exit_code == 2);
  CHECK(other.err.find("other parameters") != std::string::npos);
  CHECK(read_file(store) == before);
  CHECK(run_process(run_command(scratch / "in", store, {"--seed", "2", "--fresh"})).exit_code == 3);
  CHECK(read_file(store) != before);
}

TEST_CASE("run: --reuse copies the rows of equal content, with the bytes of a run without it") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  REQUIRE(run_process(run_command(scratch / "in", scratch / "old.h5")).exit_code == 3);
  write_mesh(scratch / "in/sphere/new.off", moved(icosphere(3), 2, 1, 1, 1), MeshFile::off);
  const ProcessResult reused = run_process(run_command(
      scratch / "in", scratch / "new.h5", {"--reuse", (scratch / "old.h5").string(), "--progress", "json"}));
  INFO(reused.err);
  REQUIRE(reused.exit_code == 3);
  std::size_t count = 0;
  for (std::size_t at = 0; (at = reused.err.find("\"reused\":true", at)) != std::string::npos; ++at) ++count;
  CHECK(count >= 38);
  REQUIRE(run_process(run_command(scratch / "in", scratch / "calm.h5")).exit_code == 3);
  CHECK(same_bytes(scratch / "calm.h5", scratch / "new.h5"));
  CHECK(run_process(run_command(scratch / "in", scratch / "x.h5",
                                {"--reuse", (scratch / "old.h5").string(), "--seed", "9"}))
            .exit_code == 2);
}

TEST_CASE("run: --reuse copies no row of the same bytes read as another format") {
  const ScratchFolder scratch;
  for (const char* const folder : {"old", "new"}) std::filesystem::create_directory(scratch / folder);
  write_mesh(scratch / "old/t.off", torus(8, 6), MeshFile::off);
  std::filesystem::copy_file(scratch / "old/t.off", scratch / "new/t.stl");
  REQUIRE(run_process(run_command(scratch / "old", scratch / "old.h5")).exit_code == 0);
  CHECK(run_process(
            run_command(scratch / "new", scratch / "new.h5", {"--reuse", (scratch / "old.h5").string()}))
            .exit_code == 3);
  CHECK(run_process(run_command(scratch / "new", scratch / "calm.h5")).exit_code == 3);
  CHECK(same_bytes(scratch / "calm.h5", scratch / "new.h5"));
}

TEST_CASE("run: too_large is a row") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  write_mesh(scratch / "in/big.off", icosphere(6), MeshFile::off);
  REQUIRE(run_process(run_command(scratch / "in", scratch / "s.h5",
                                  {"--memory", "80M", "-j", "2", "--method", "conformal"}))
              .exit_code == 3);
  const StoreReader reader(scratch / "s.h5");
  CHECK(reader.report(*reader.find("big.off")).status == Status::too_large);
}

TEST_CASE("run: --max-failures stops early") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  // Many more failures than models in flight: a run whose last models are on their way has nothing to stop.
  for (int i = 0; i < 200; ++i) write_file(scratch / ("in/broken" + std::to_string(i) + ".off"), "OFF\n1 0");
  CHECK(run_process(run_command(scratch / "in", scratch / "m.h5", {"--max-failures", "2", "-j", "2"}))
            .exit_code == 75);
}

TEST_CASE("run: mistakes on the command line exit with 2 and a suggestion") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  const auto says = [&](const std::vector<std::string>& more, const std::string& text) {
    const ProcessResult result = run_process(run_command(scratch / "in", scratch / "s.h5", more));
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(result.err.find(text) != std::string::npos);
  };
  says({"--densty", "mean"}, "--density");
  says({"--density", "mena"}, "not one of uniform");
  says({"--sequence", "shiftd"}, "did you mean `shifted`");
  says({"--spacing", "best"}, "applies to the sequence spaced only");
  says({"--sequence", "spaced", "--spacing", "bset"}, "fast|default|best");
  says({"--sequence", "spaced", "--place", "vertex"}, "place at elements");
  says({"--finish", "relax", "--place", "vertex"}, "place at elements");
  says({"--finish", "relax", "--method", "anisotropic"}, "choose another method or no finish");
  says({"--finish", "relax", "--topology", "none"}, "needs the topology of the surface");
  says({"--method", "direct", "--locate", "elements"}, "leave --locate out");
  says({"--locate", "elements"}, "name a method with charts");
  says({"--curve", "hilbert"}, "name a method to choose the curve");
  says({"--method", "direct", "--curve", "peano"}, "hilbert and balanced");
  says({"--method", "conformal", "--locate", "first-hit", "--curve", "balanced"}, "no balanced order");
  says({"--memory", "12Q"}, "--memory takes a size such as 4G or 512M");
  says({"-n", "2,5k"}, "-n takes a whole number from 1 to 2147483648, such as 2048 or 10k, not `2,5k`\n");
  says({"--retry", "broken"}, "`broken` is neither a status of a failed item");
  says({"--method", "conformal", "--locate", "first-hit", "--place", "element"}, "curve vertices");
  CHECK(run_process({fault_program, "rum"}).exit_code == 2);
  CHECK(run_process({fault_program, "run", "nowhere", "-o", "x.h5"}).exit_code == 2);
  CHECK(run_process({fault_program, "--help"}).exit_code == 0);
  CHECK_FALSE(std::filesystem::exists(scratch / "s.h5"));
}

TEST_CASE("run: every option has its line in --help, and --dry-run writes nothing") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  const ProcessResult help = run_process({fault_program, "run", "--help-all"});
  for (const char* option : {"--samples",
                             "--method",
                             "--density",
                             "--locate",
                             "--place",
                             "--sequence",
                             "--spacing",
                             "--order",
                             "--curve",
                             "--seed",
                             "--normalize",
                             "--describe",
                             "--label-from-folder",
                             "--threads",
                             "--memory",
                             "--allow-oversize",
                             "--timeout",
                             "--max-failures",
                             "--retry",
                             "--reuse",
                             "--compress",
                             "--fresh",
                             "--dry-run",
                             "--progress",
                             "--json",
                             "--stats"})
    CHECK(help.out.find(option) != std::string::npos);
  CHECK(run_process(run_command(scratch / "in", scratch / "s.h5", {"--dry-run", "--json"})).exit_code == 2);
  const ProcessResult dry = run_process(run_command(scratch / "in", scratch / "s.h5", {"--dry-run"}));
  CHECK(dry.exit_code == 0);
  CHECK(dry.out.find("sphere/0.off") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(scratch / "s.h5"));
  CHECK_FALSE(std::filesystem::exists(scratch / "s.h5.run"));
}

TEST_CASE("run: every method, locator, curve, sequence, order, density and frame gives a valid store") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  // With sanitizers without the last, whose code other cases run.
  const auto variants = thinned<std::vector<std::string>>(
      22, {{"--method", "direct"},
           {"--method", "direct", "--curve", "balanced"},
           {"--method", "direct", "--place", "vertex"},
           {"--method", "conformal", "--curve", "balanced"},
           {"--method", "conformal", "--curve", "balanced", "--locate", "elements", "--place", "vertex"},
           {"--method", "conformal", "--locate", "elements"},
           {"--method", "conformal", "--locate", "first-hit"},
           {"--method", "conformal", "--place", "vertex"},
           {"--method", "conformal", "--curve", "peano"},
           {"--method", "conformal", "--curve", "peano-meander"},
           {"--sequence", "owen"},
           {"--sequence", "regular"},
           {"--sequence", "spaced"},
           {"--sequence", "spaced", "--spacing", "fast", "--order", "curve"},
           {"--sequence", "spaced", "--spacing", "best", "--method", "direct"},
           {"--sequence", "spaced", "--method", "conformal", "--density", "mean"},
           {"--sequence", "spaced", "--method", "anisotropic"},
           {"--finish", "relax"},
           {"--finish", "relax", "--sequence", "spaced", "--density", "mean"},
           {"--order", "curve"},
           {"--density", "mean"},
           {"--compress", "none"},
           {"--method", "auto"},
           {"--place", "vertex"},
           {"--sequence", "stratified"},
           {"--sequence", "random"},
           {"--normalize", "unit-sphere"},
           {"--normalize", "unit-box"},
           {"--density", "gaussian"},
           {"--density", "max"}});
  for (const auto& variant : variants) {
    const ProcessResult result = run_process(run_command(scratch / "in", scratch / "s.h5", [&] {
      auto more = variant;
      more.push_back("--fresh");
      return more;
    }()));
    std::string words;
    for (const std::string& word : variant) words += word + " ";
    INFO(words << "\n" << result.err);
    CHECK(result.exit_code == 3);
    const VerifyResult verified = verify_store(scratch / "s.h5");
    CHECK(verified.problems.empty());
    CHECK(verified.ok_rows == 38);
  }
}

TEST_CASE("run: a store records how its samples were spaced, and another effort is another run") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  const auto run = [&](const std::vector<std::string>& more) {
    return run_process(run_command(scratch / "in", scratch / "s.h5", more)).exit_code;
  };
  REQUIRE(run({"--sequence", "spaced", "--spacing", "fast"}) == 3);
  CHECK(StoreReader(scratch / "s.h5").header().parameters_json.find("\"spacing\":\"fast\"") !=
        std::string::npos);
  CHECK(run({"--sequence", "spaced"}) == 2);
  REQUIRE(run({"--fresh"}) == 3);
  CHECK(StoreReader(scratch / "s.h5").header().parameters_json.find("spacing") == std::string::npos);
}

TEST_CASE("info, verify and export: read and unpack a store") {
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  const std::string store = (scratch / "s.h5").string();
  REQUIRE(run_process(run_command(scratch / "in", store, {"--label-from-folder"})).exit_code == 3);
  CHECK(run_process({fault_program, "verify", store}).exit_code == 0);
  const ProcessResult info = run_process({fault_program, "info", store});
  CHECK(info.out.find("44 models x 64 points") != std::string::npos);
  CHECK(run_process({fault_program, "info", store, "torus/3.ply"}).out.find("genus 1") != std::string::npos);
  CHECK(run_process({fault_program, "info", store, "--failed"}).out.find("broken/nan.off: non_finite: ") !=
        std::string::npos);
  CHECK(run_process({fault_program, "info", store, "torus/none"}).exit_code == 2);
  for (const std::string format : {"ply", "off", "xyz"}) {
    REQUIRE(run_process({fault_program, "export", store, "torus/3.ply", "--format", format, "-o",
                         (scratch / "out").string()})
                .exit_code == 0);
    CHECK(std::filesystem::file_size(scratch / ("out/torus/3.ply." + format)) > 500);
  }
  REQUIRE(run_process({fault_program, "export", store, "--pointnet", "-o", (scratch / "pn").string()})
              .exit_code == 0);
  CHECK(std::filesystem::exists(scratch / "pn/ply_data_train0.h5"));
  REQUIRE(
      run_process({fault_program, "render", "sheet", store, "-o", (scratch / "p.png").string()}).exit_code ==
      0);
  CHECK(std::filesystem::file_size(scratch / "p.png") > 10000);
  std::string bytes = read_file(store);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  write_file(store, bytes);
  CHECK(run_process({fault_program, "verify", store}).exit_code == 3);
  REQUIRE(::mkfifo((scratch / "pipe").c_str(), 0600) == 0);  // reading it would never end
  for (const std::filesystem::path& none : {scratch / "none.h5", scratch / "in", scratch / "pipe"})
    CHECK(run_process({fault_program, "verify", none}).exit_code == 2);
}
