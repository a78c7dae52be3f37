// --memory is the budget of the whole process: its peak as reported by the kernel stays below.
#include <sys/resource.h>

#include <filesystem>

#include "support/catch.h"
#include "support/collection.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/run_process.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

ProcessResult run_fresh(const fs::path& input, const std::string& store, const std::vector<std::string>& more,
                        const ProcessOptions& options = {}) {
  std::vector<std::string> arguments = {program,   "run",        input.string(), "-o",        store,
                                        "--fresh", "--progress", "none",         "--timeout", "0"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_process(arguments, options);
}

void check_peaks(const fs::path& input, const std::string& store, const std::vector<long>& budgets) {
  for (const long budget : budgets)
    for (const char* threads : {"1", "2"})
      for (const char* method : {"auto", "conformal", "direct"})
        for (const char* samples : {"512", "2048"}) {
          const ProcessResult result = run_fresh(
              input, store,
              {"-n", samples, "-j", threads, "--method", method, "--memory", std::to_string(budget) + "M"});
          INFO(budget << " MiB, " << threads << " threads, " << method << ", " << samples << " samples: peak "
                      << result.peak_kilobytes / 1024 << " MiB; " << result.err);
          REQUIRE((result.exit_code == 0 || result.exit_code == 3));
          CHECK(result.peak_kilobytes <= budget * 1024);
        }
}

// The number behind "give at least" in megabytes.
long least_budget(const std::string& message) {
  const std::string mark = "give at least ";
  const std::size_t at = message.find(mark);
  return at == std::string::npos ? 0 : std::stol(message.substr(at + mark.size()));
}

}  // namespace

TEST_CASE("run --memory: the peak of the process stays within the budget, over generated meshes") {
  if (sanitized) {
    WARN("skipped: sanitizers take memory of their own");
    return;
  }
  const ScratchFolder scratch;
  write_collection(scratch / "in");
  for (int i = 0; i < 12; ++i)
    write_mesh(scratch / ("in/ball" + std::to_string(i) + ".ply"),
               moved(icosphere(3 + i % 3), 1 + i, 0, 0, 0));
  check_peaks(scratch / "in", scratch / "s.h5", {64, 96, 160});
}

TEST_CASE("run --memory: the peak of the process stays within the budget, over the shared retrieval/",
          "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  const ScratchFolder scratch;
  check_peaks(shared_data("retrieval"), scratch / "s.h5", {64, 96, 128, 192, 256});
}

TEST_CASE("run --memory: a budget below the needs of the process is refused, and a sufficient one is named") {
  if (sanitized) {
    WARN("skipped: sanitizers take memory of their own");
    return;
  }
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  for (int i = 0; i < 4; ++i) write_mesh(scratch / ("in/ball" + std::to_string(i) + ".ply"), icosphere(3));
  const std::string store = scratch / "s.h5";
  for (const char* samples : {"64", "2048", "100000"})
    for (const char* threads : {"1", "2"}) {
      const std::vector<std::string> setting = {"-n", samples, "-j", threads, "--memory"};
      std::vector<std::string> refused = setting, accepted = setting;
      refused.push_back("16M");
      const ProcessResult small = run_fresh(scratch / "in", store, refused);
      INFO(small.err);
      CHECK(small.exit_code == 2);
      CHECK_FALSE(fs::exists(store));
      const long least = least_budget(small.err);
      REQUIRE(least > 16);
      accepted.push_back(std::to_string(least) + "M");
      const ProcessResult result = run_fresh(scratch / "in", store, accepted);
      INFO(samples << " samples, " << threads << " threads, " << least << " MiB: peak "
                   << result.peak_kilobytes / 1024 << " MiB; " << result.err);
      CHECK(result.exit_code == 0);
      CHECK(result.peak_kilobytes <= least * 1024);
      fs::remove(store);
      accepted.back() = std::to_string(least - 1) + "M";
      CHECK(run_fresh(scratch / "in", store, accepted).exit_code == 2);
    }
}

TEST_CASE("run: an address space too small for Embree is reported as lack of memory") {
  if (sanitized) {
    WARN("skipped: sanitizers take address space of their own");
    return;
  }
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  write_mesh(scratch / "in/ball.ply", icosphere(3));
  int failures = 0;
  for (rlim_t megabytes = 80; megabytes < 600; megabytes += 10) {
    ProcessOptions options;
    options.in_child = [megabytes] {
      const rlimit limit{megabytes << 20, megabytes << 20};
      setrlimit(RLIMIT_AS, &limit);
    };
    const ProcessResult result =
        run_fresh(scratch / "in", scratch / "s.h5", {"-j", "1", "--method", "conformal"}, options);
    INFO(megabytes << " MiB: exit " << result.exit_code << ", signal " << result.signal << ": "
                   << result.err);
    CHECK(result.err.find("a bug of meander") == std::string::npos);
    failures += result.err.find("Embree ran out of memory") != std::string::npos;
  }
  CHECK(failures > 0);
}
