#include "io/whole_file.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "support/mesh_files.h"

using namespace meander;
using meander::test::ScratchFolder;

namespace {

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("write_whole_file: replaces, also by nothing, and leaves nothing beside it") {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "taken/inside");
  const auto path = folder / "a.csv";
  write_whole_file(path, std::string_view("one\0two\n", 8));
  CHECK(content(path) == std::string("one\0two\n", 8));
  write_whole_file(path, "");
  CHECK(std::filesystem::file_size(path) == 0);
  CHECK_THROWS_AS(write_whole_file(folder / "no/a.csv", "x"), std::system_error);
  CHECK_THROWS_AS(write_whole_file(folder / "taken", "x"), std::system_error);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
}

TEST_CASE("WholeFileWriter: pieces become one file, but only when it is finished") {
  const ScratchFolder folder;
  const auto path = folder / "m.bin";
  write_whole_file(path, "old");
  const auto append = [](WholeFileWriter& writer, std::string_view text) {
    writer.append(std::as_bytes(std::span<const char>(text)));
  };
  {
    WholeFileWriter writer(path);
    append(writer, "given up");
  }
  CHECK(content(path) == "old");
  WholeFileWriter writer(path);
  append(writer, "one ");
  append(writer, "two");
  CHECK(content(path) == "old");
  writer.finish();
  CHECK(content(path) == "one two");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
  CHECK_THROWS_AS(WholeFileWriter(folder / "no/m.bin"), std::system_error);
}
