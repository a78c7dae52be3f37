// What a job may replace: by content, by identity, before anything changes.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "io/file/atomic_file.h"
#include "io/store/run_directory.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/working_process.h"
#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

void make_store(const fs::path& path) {
  StoreHeader header;
  header.samples = 4;
  RunDirectory(path, header).finish();
}

// The message of the UsageError, empty when there is none.
template <class Body>
std::string refusal(const Body& body) {
  try {
    body();
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

std::string check(const fs::path& path, FileKind kind, const std::vector<fs::path>& inputs = {},
                  Existing existing = Existing::replace) {
  return refusal([&] {
    OutputGuard guard;
    guard.protect(inputs);
    guard.check(path, {kind}, "--csv", existing);
  });
}

std::string check_run(const fs::path& store, const std::vector<fs::path>& inputs = {}, bool fresh = true) {
  return refusal([&] { check_run_outputs(store, fresh, inputs); });
}

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

}  // namespace

TEST_CASE("output guard: a file is replaced only by its own kind") {
  const ScratchFolder scratch;
  write_file(scratch / "a.csv", "id,value\na,1\n");
  write_file(scratch / "named.csv", mesh_bytes(grid_plane(2, 2), MeshFile::off));
  write_file(scratch / "empty", "");
  make_store(scratch / "s.h5");
  CHECK(check(scratch / "a.csv", FileKind::csv).empty());
  CHECK(check(scratch / "empty", FileKind::csv).empty());
  CHECK(check(scratch / "new.csv", FileKind::csv).empty());
  CHECK(check("", FileKind::csv).empty());
  CHECK(says(check(scratch / "named.csv", FileKind::csv),
             "is an OFF mesh: this command replaces only a CSV table"));
  CHECK(says(check(scratch / "s.h5", FileKind::csv), "is a Meander store"));
  CHECK(says(check(scratch / "s.h5", FileKind::hdf5), "is a Meander store"));
  CHECK(says(check(scratch / "a.csv", FileKind::csv, {}, Existing::keep), "exists (--fresh replaces it)"));
}

TEST_CASE("output guard: an input is never replaced, whatever its name") {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "in");
  write_file(scratch / "in/points.csv", "x,y,z\n1,2,3\n");
  fs::create_symlink(scratch / "in/points.csv", scratch / "link.csv");
  fs::create_hard_link(scratch / "in/points.csv", scratch / "hard.csv");
  const std::vector<fs::path> inputs = {scratch / "gone.csv", scratch / "in/points.csv"};
  for (const char* name : {"in/points.csv", "in/../in/./points.csv", "link.csv", "hard.csv"}) {
    const std::string text = check(scratch / name, FileKind::csv, inputs);
    INFO(name << ": " << text);
    CHECK(says(text, "is an input of this command"));
  }
  CHECK(says(check(scratch / "hard.csv", FileKind::csv, inputs), "in/points.csv`)"));
  // And when the input is the one that is named through a link.
  CHECK(says(check(scratch / "in/points.csv", FileKind::csv, {scratch / "link.csv"}), "is an input"));
}

TEST_CASE("output guard: unwritable paths are named before anything is created") {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "folder");
  write_file(scratch / "file", "text");
  fs::create_symlink(scratch / "nowhere", scratch / "dangling");
  CHECK(says(check(scratch / "folder", FileKind::csv), "is a folder, not a file"));
  CHECK(says(check("/dev/null", FileKind::csv), "is a device"));
  CHECK(says(check(scratch / "no/such/a.csv", FileKind::csv), "does not exist: create it first"));
  CHECK(says(check(scratch / "file/a.csv", FileKind::csv), "cannot access"));
  CHECK(says(check(scratch / "dangling", FileKind::csv), "a symbolic link to a missing file"));
  const auto folder = [&](const char* name) {
    return refusal([&] { OutputGuard().check_folder(scratch / name, "-o"); });
  };
  CHECK(folder("folder").empty());
  CHECK(folder("folder/").empty());
  CHECK(folder("folder/to/be/made/").empty());
  CHECK(says(folder("file"), "is not a folder"));
  CHECK(says(folder("file/below"), "is not a folder"));
  CHECK(says(folder("dangling"), "a missing file"));
  fs::permissions(scratch / "folder", fs::perms::owner_read | fs::perms::owner_exec);
  if (::geteuid() != 0) {  // root may write everywhere
    CHECK(says(check(scratch / "folder/a.csv", FileKind::csv), "cannot write to the folder"));
    CHECK(says(folder("folder/new"), "cannot write to the folder"));
  }
  fs::permissions(scratch / "folder", fs::perms::owner_all);
}

TEST_CASE("output guard: two outputs of one command are two files") {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "a");
  const std::string text = refusal([&] {
    OutputGuard guard;
    guard.check(scratch / "a/x", {FileKind::csv}, "--csv");
    guard.check(scratch / "a/../a/x", {FileKind::png}, "--picture");
  });
  CHECK(says(text, "--csv and --picture would write the same file"));
}

TEST_CASE("output guard: a store replaces a store, and never an input of the run") {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "v");
  write_file(scratch / "v/m.off", mesh_bytes(grid_plane(2, 2), MeshFile::off));
  make_store(scratch / "s.h5");
  const std::vector<fs::path> inputs = {scratch / "v/m.off"};
  CHECK(check_run(scratch / "s.h5", inputs).empty());
  CHECK(check_run(scratch / "new.h5", inputs).empty());
  CHECK(says(check_run(scratch / "v/m.off", inputs), "is an input of this command"));
  CHECK(says(check_run(scratch / "v/m.off"), "is an OFF mesh: this command replaces only a Meander store"));
  write_file(scratch / "h5py.h5", "\x89HDF\r\n\x1a\n and more");
  CHECK(says(check_run(scratch / "h5py.h5"), "is an HDF5 file"));
  write_file(scratch / "empty.h5", "");
  CHECK(check_run(scratch / "empty.h5").empty());
  CHECK(says(check_run(scratch / "empty.h5", {}, false), "is an empty file (--fresh replaces it)"));
  // A store that is cut short is one nevertheless.
  fs::resize_file(scratch / "s.h5", 600);
  CHECK(check_run(scratch / "s.h5").empty());
}

TEST_CASE("output guard: files that a run leaves beside its store are guarded too") {
  const ScratchFolder scratch;
  const auto store = scratch / "s.h5";
  write_file(scratch / "s.h5.failed.txt", "# a.off: empty: no face\na.off\n");
  write_file(scratch / "s.h5.run.json", "{\"store\":\"s.h5\"}\n");
  CHECK(check_run(store).empty());
  const std::vector<std::string> arguments = {"@" + (scratch / "s.h5.failed.txt").string(), "-"};
  CHECK(says(check_run(store, input_files(arguments, {})), "s.h5.failed.txt` is an input"));
  write_file(scratch / "s.h5.run.json", "my notes\n");
  CHECK(says(check_run(store), "s.h5.run.json` is a text file"));
  fs::remove(scratch / "s.h5.run.json");
  fs::create_directory(scratch / "s.h5.run");
  CHECK(check_run(store).empty());
  write_file(scratch / "s.h5.run/thesis.tex", "text");
  CHECK(says(check_run(store), "holds files that were not made by a run"));
  write_file(scratch / "s.h5.run/lock", "1");
  CHECK(check_run(store).empty());
  fs::remove_all(scratch / "s.h5.run");
  write_file(scratch / "s.h5.run", "text");
  CHECK(says(check_run(store), "is not a folder"));
  fs::remove(scratch / "s.h5.run");
  fs::create_symlink(scratch / "nowhere", scratch / "s.h5.run");
  CHECK(says(check_run(store), "is not a folder"));
}

TEST_CASE("output guard: protects files of the arguments and the items found in them") {
  PlanItem item;
  item.path = "in/a.off";
  item.tensor_path = "tensors.h5";
  const std::vector<std::string> arguments = {"in", "-", "@list.txt", "b.ply"};
  CHECK(input_files(arguments, std::span(&item, 1)) ==
        std::vector<fs::path>{"in", "list.txt", "b.ply", "in/a.off", "tensors.h5"});
}

TEST_CASE("a terminating signal removes the temporary files being written") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
    const ScratchFolder scratch;
    write_file(scratch / "done", "old");
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      for (const int any : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) std::signal(any, SIG_DFL);
      remove_temporaries_on_signals();
      AtomicFile done(scratch / "done"), half(scratch / "half"), other(scratch / "other");
      done.append("new");
      done.commit();
      half.append("half");
      std::raise(signal);
      ::_exit(1);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == signal);
    CHECK(read_file(scratch / "done") == "new");
    CHECK(std::distance(fs::directory_iterator(scratch.path()), fs::directory_iterator()) == 1);
  }
}
