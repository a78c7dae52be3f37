// A full disk stops a run; no row is lost, and once there is space it continues to the same bytes.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "store_support.h"
#include "support/catch.h"
#include "support/small_disk.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// Continues a run as far as possible. True when it finished, false when it was stopped.
bool advance(RunDirectory& run, const StoreHeader& header) {
  try {
    for (std::uint64_t row = 0; row < header.ids.size(); ++row) {
      if (run.done(row)) continue;
      run.begin_item(row);
      run.end_item(make_encoded(header, row));
    }
    run.finish();
    return true;
  } catch (const RunError& error) {
    if (error.kind() != RunError::Kind::stopped) throw;
    return false;
  }
}

bool advance_new(const fs::path& store, const StoreHeader& header) {
  try {
    RunDirectory run(store, header);
    return advance(run, header);
  } catch (const RunError& error) {
    if (error.kind() != RunError::Kind::stopped) throw;
    return false;
  }
}

// Runs body in a child; true when it returned true there.
bool in_child(const std::function<bool()>& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    bool good = false;
    try {
      good = body();
    } catch (...) {
    }
    ::_exit(good ? 0 : 1);
  }
  int state = 0;
  ::waitpid(child, &state, 0);
  return WIFEXITED(state) && WEXITSTATUS(state) == 0;
}

}  // namespace

TEST_CASE("disk full: stopped at every stage, a run continues in the same process and in the next") {
  for (const std::uint32_t samples : {100u, 1500u}) {
    const StoreHeader header = make_header(samples == 100 ? 300 : 30, samples);
    const std::string expected = store_bytes(header);
    const ScratchFolder folder;
    int stops = 0;
    for (const bool same_process : {true, false}) {
      SmallDisk disk(folder / "disk", 16);
      if (!disk.mounted()) {
        WARN("skipped: only root can mount a small disk");
        return;
      }
      const fs::path store = folder / "disk/s.h5";
      std::unique_ptr<RunDirectory> run;
      bool finished = false;
      for (std::uint64_t kilobytes = 16; !finished; kilobytes += 8 + kilobytes / 4) {
        REQUIRE(kilobytes < 65536);
        disk.resize(kilobytes);
        if (!same_process) {
          finished = advance_new(store, header);
        } else {
          try {
            if (!run) run = std::make_unique<RunDirectory>(store, header);
            finished = advance(*run, header);
          } catch (const RunError& error) {
            REQUIRE(error.kind() == RunError::Kind::stopped);
          }
        }
        if (!finished) {
          ++stops;
          CHECK_FALSE(fs::exists(store));
        }
      }
      CHECK((read_file(store) == expected));
      run.reset();
    }
    CHECK(stops > 10);
  }
}

TEST_CASE("disk full: a file size limit stops the run, which continues once it is lifted") {
  for (const std::uint32_t samples : {100u, 1500u}) {
    const StoreHeader header = make_header(samples == 100 ? 300 : 30, samples);
    const std::string expected = store_bytes(header);
    const ScratchFolder folder;
    const bool good = in_child([&] {
      ::signal(SIGXFSZ, SIG_IGN);
      int stops = 0;
      std::unique_ptr<RunDirectory> run;
      for (rlim_t bytes = 8192;; bytes += 8192 + bytes / 4) {
        struct rlimit limit {};
        ::getrlimit(RLIMIT_FSIZE, &limit);
        limit.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &limit);
        try {
          if (!run || stops % 3 == 0) {
            run.reset();
            run = std::make_unique<RunDirectory>(folder / "s.h5", header);
          }
          if (advance(*run, header)) return stops > 5;
        } catch (const RunError& error) {
          if (error.kind() != RunError::Kind::stopped) throw;
        }
        ++stops;
      }
    });
    CHECK(good);
    CHECK((read_file(folder / "s.h5") == expected));
  }
}
