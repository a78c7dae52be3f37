#include "io/file/atomic_file.h"

#include <sys/stat.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

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

std::ptrdiff_t entries(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

}  // namespace

TEST_CASE("replace_file: replaces a file, also with empty content, and leaves no temporary file") {
  const ScratchFolder folder;
  fs::create_directories(folder / "taken/inside");
  const auto path = folder / "a.csv";
  replace_file(path, std::string_view("one\0two\n", 8));
  CHECK(content_of_file(path) == std::string("one\0two\n", 8));
  replace_file(path, "");
  CHECK(fs::file_size(path) == 0);
  CHECK_THROWS_AS(replace_file(folder / "no/a.csv", "x"), FileError);
  CHECK_THROWS_AS(replace_file(folder / "taken", "x"), FileError);
  CHECK(entries(folder.path()) == 2);
}

TEST_CASE("AtomicFile: pieces become one file only when it is finished") {
  const ScratchFolder folder;
  const auto path = folder / "m.bin";
  replace_file(path, "old");
  {
    AtomicFile writer(path);
    writer.append("given up");
  }
  CHECK(content_of_file(path) == "old");
  AtomicFile writer(path);
  writer.append("one ");
  writer.append("two");
  CHECK(content_of_file(path) == "old");
  writer.commit();
  CHECK(content_of_file(path) == "one two");
  CHECK(entries(folder.path()) == 1);
  CHECK_THROWS_AS(AtomicFile(folder / "no/m.bin"), FileError);
}

TEST_CASE("atomic files: every writer follows links and never replaces a pipe") {
  const ScratchFolder folder;
  const auto write_all = [](const fs::path& path) {
    return std::vector<std::function<void()>>{[=] { replace_file(path, "text"); },
                                              [=] { write_points(path, PointFormat::off, {}, {}); },
                                              [=] { write_png(path, RgbImage(2, 2)); }};
  };
  fs::create_symlink("far", folder / "near");
  for (const auto& write : write_all(folder / "near")) {
    replace_file(folder / "far", "old");
    write();
    CHECK(fs::is_symlink(folder / "near"));
    CHECK(content_of_file(folder / "far") != "old");
  }
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
  for (const auto& write : write_all(folder / "pipe")) {
    CHECK_THROWS_AS(write(), RunError);
    CHECK(fs::is_fifo(folder / "pipe"));
  }
  CHECK(entries(folder.path()) == 3);
}

TEST_CASE("content_of_file: reads all bytes, from pipes too, and a missing file is an error or empty") {
  const ScratchFolder folder;
  const std::string text(100000, 'x');
  replace_file(folder / "long", text);
  CHECK((content_of_file(folder / "long") == text));
  replace_file(folder / "empty", "");
  CHECK(content_of_file(folder / "empty").empty());
  CHECK(content_of_file("/proc/self/stat").size() > 10);  // says that it has no bytes
  CHECK_FALSE(content_if_exists(folder / "none"));
  CHECK(content_if_exists(folder / "empty") == "");
  CHECK_THROWS_AS(content_of_file(folder / "none"), FileError);
  CHECK_THROWS_AS(content_of_file(folder.path()), FileError);
}

TEST_CASE("pending files: can be removed while being written, and are forgotten once finished") {
  const ScratchFolder folder;
  {
    const PendingFile first(folder / "a", FullDisk::ends_command);
    PendingFile second(folder / "b", FullDisk::ends_command);
    second.commit(second.create());
  }
  std::vector<std::unique_ptr<AtomicFile>> many;  // more than are noted
  for (int i = 0; i < 300; ++i) many.push_back(std::make_unique<AtomicFile>(folder / std::to_string(i)));
  remove_pending_files();
  int left = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    left += entry.path().filename() != "b";
  CHECK(left == 300 - 256);
  CHECK(std::filesystem::exists(folder / "b"));
  many.clear();
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()),
                      std::filesystem::directory_iterator()) == 1);
}
