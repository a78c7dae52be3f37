// Files on a failing disk: the calls of the program go through those below, which record them and fail on
// demand.
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/plot/png_writer.h"
#include "io/point_files.h"
#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;
using meander::test::ScratchFolder;
namespace fs = std::filesystem;

namespace {

struct Faults {
  std::string call;          // that fails
  int error = 0;             // with this
  std::size_t short_by = 0;  // bytes that the first write takes less, without an error
  bool watched = false;      // calls are recorded and fail
  std::vector<std::string> calls;
};
Faults faults;

// True when the call is to fail.
bool note(const char* call) {
  if (!faults.watched) return false;
  faults.calls.emplace_back(call);
  if (faults.call != call) return false;
  errno = faults.error;
  return true;
}

bool is_folder(int descriptor) { return fs::is_directory("/proc/self/fd/" + std::to_string(descriptor)); }

}  // namespace

extern "C" {

int fsync(int descriptor) {
  if (faults.watched && note(is_folder(descriptor) ? "sync folder" : "sync")) return -1;
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

ssize_t pwrite(int descriptor, const void* bytes, size_t count, off_t offset) {
  if (note("write")) return -1;
  if (faults.watched && faults.short_by > 0 && count > faults.short_by)
    count -= std::exchange(faults.short_by, 0);
  return ::syscall(SYS_pwrite64, descriptor, bytes, count, offset);
}

int close(int descriptor) {
  const bool fails = faults.watched && !is_folder(descriptor) && note("close");
  const auto result = static_cast<int>(::syscall(SYS_close, descriptor));
  if (fails) errno = faults.error;
  return fails ? -1 : result;
}

int rename(const char* from, const char* to) noexcept {
  if (note("rename")) return -1;
  return static_cast<int>(::syscall(SYS_renameat, AT_FDCWD, from, AT_FDCWD, to));
}
}

namespace {

struct Writer {
  const char* name;
  std::function<void(const fs::path&)> write;
};

// Everything that replaces a file atomically.
std::vector<Writer> writers() {
  Samples samples;
  samples.points = samples.normals = {0, 0, 1};
  samples.face = {0};
  samples.density = {1};
  return {{"text", [](const fs::path& path) { replace_file(path, "a text"); }},
          {"picture", [](const fs::path& path) { write_png(path, RgbImage(8, 8)); }},
          {"points", [=](const fs::path& path) { write_points(path, PointFormat::ply, samples, {}); }}};
}

std::vector<std::string> watch(const std::function<void()>& body) {
  faults.calls.clear();
  faults.watched = true;
  try {
    body();
  } catch (...) {
    faults.watched = false;
    throw;
  }
  faults.watched = false;
  return faults.calls;
}

}  // namespace

TEST_CASE("atomic files: written, synced, closed, renamed, then the folder synced") {
  const ScratchFolder folder;
  for (const Writer& writer : writers()) {
    INFO(writer.name);
    CHECK(watch([&] { writer.write(folder / "file"); }) ==
          std::vector<std::string>{"write", "sync", "close", "rename", "sync folder"});
  }
}

TEST_CASE("atomic files: every failing call is one error with the final name, and the old file stays") {
  const ScratchFolder folder;
  const fs::path path = folder / "file";
  for (const Writer& writer : writers())
    for (const char* call : {"write", "sync", "close", "rename"})
      for (const int error : {ENOSPC, EDQUOT, EIO, EACCES}) {
        INFO(writer.name << ": " << call << " fails with " << error);
        replace_file(path, "old");
        faults.call = call;
        faults.error = error;
        std::string said;
        try {
          watch([&] { writer.write(path); });
        } catch (const RunError& failure) {
          said = failure.what();
          CHECK(failure.kind() == RunError::Kind::unusable);
        }
        faults.call.clear();
        CHECK(said.find(path.string() + ": ") != std::string::npos);
        CHECK(content_of_file(path) == "old");
        CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
      }
}

TEST_CASE("atomic files: a full disk stops a run, any other failure makes its file unusable") {
  const ScratchFolder folder;
  for (const auto& [error, kind] :
       {std::pair{ENOSPC, RunError::Kind::stopped}, std::pair{EIO, RunError::Kind::stopped},
        std::pair{EACCES, RunError::Kind::unusable}}) {
    faults.call = "write";
    faults.error = error;
    try {
      watch([&] { replace_file(folder / "plan.bin", "x", FullDisk::stops_run); });
      FAIL("nothing was thrown");
    } catch (const RunError& failure) {
      CHECK(failure.kind() == kind);
    }
    faults.call.clear();
  }
}

TEST_CASE("atomic files: a short write is continued") {
  const ScratchFolder folder;
  faults.short_by = 3;
  CHECK(watch([&] { replace_file(folder / "file", "a text"); }).size() == 6);
  CHECK(content_of_file(folder / "file") == "a text");
}

TEST_CASE("atomic files: a folder that cannot be synced is an error, unless its file system never can") {
  const ScratchFolder folder;
  faults.call = "sync folder";
  faults.error = EIO;
  CHECK_THROWS_AS(watch([&] { replace_file(folder / "file", "x"); }), RunError);
  faults.error = EINVAL;
  CHECK_NOTHROW(watch([&] { replace_file(folder / "file", "y"); }));
  faults.call.clear();
  CHECK(content_of_file(folder / "file") == "y");
}
