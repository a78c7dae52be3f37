#include "jobs/inputs.h"

#include <catch2/catch.hpp>

#include "jobs/command_line.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("collect_inputs: ids are paths with extension, sorted by bytes, other files are counted") {
  const ScratchFolder scratch;
  for (const char* name :
       {"b/x.OFF", "b/a.obj", "Z.stl", "b/c/deep.Ply", "readme.md", "data.csv", "more.csv"}) {
    std::filesystem::create_directories((scratch / name).parent_path());
    write_file(scratch / name, "");
  }
  const Inputs inputs = collect_inputs({scratch.path().string()}, true);
  REQUIRE(inputs.items.size() == 4);
  CHECK(inputs.items[0].id == "Z.stl");
  CHECK(inputs.items[1].id == "b/a.obj");
  CHECK(inputs.items[2].id == "b/c/deep.Ply");
  CHECK(inputs.items[3].id == "b/x.OFF");
  CHECK(inputs.items[3].row == 3);
  CHECK(inputs.skipped.at(".csv") == 2);
  CHECK(inputs.label_names[static_cast<std::size_t>(inputs.items[2].label)] == "c");
}

TEST_CASE("collect_inputs: several folders are told apart by their names, equal ids are refused") {
  const ScratchFolder scratch;
  for (const char* name : {"one/x.off", "two/x.off", "deep/one/x.off"}) {
    std::filesystem::create_directories((scratch / name).parent_path());
    write_file(scratch / name, "");
  }
  const Inputs inputs = collect_inputs({(scratch / "one").string(), (scratch / "two").string() + "/"}, false);
  REQUIRE(inputs.items.size() == 2);
  CHECK(inputs.items[0].id == "one/x.off");
  CHECK(inputs.items[0].label == -1);
  CHECK_THROWS_AS(collect_inputs({(scratch / "one").string(), (scratch / "deep/one").string()}, false),
                  UsageError);
  CHECK_THROWS_AS(collect_inputs({(scratch / "nowhere").string()}, false), UsageError);
}

TEST_CASE("collect_inputs: a file named explicitly always makes a row, lists keep their paths") {
  const ScratchFolder scratch;
  write_file(scratch / "strange.xyz", "");
  write_file(scratch / "list.txt", "# comment\n\nsome/where/a.off\r\n./b.obj\n");
  const Inputs inputs =
      collect_inputs({(scratch / "strange.xyz").string(), "@" + (scratch / "list.txt").string()}, false);
  REQUIRE(inputs.items.size() == 3);
  CHECK(inputs.items[0].id == "b.obj");
  CHECK(inputs.items[1].id == "some/where/a.off");
  CHECK(inputs.items[2].id == "strange.xyz");
  CHECK_FALSE(inputs.items[2].known_format);
}

TEST_CASE("collect_inputs: Princeton classifications give labels and files of the database") {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "db/1/m123");
  write_file(scratch / "db/1/m123/m123.off", "");
  write_file(scratch / "test.cla", "PSB 1\n3 3\n\nanimal 0 0\n\ndog animal 2\n123\n7\n\nplane 0 1 250\n");
  const Inputs inputs = collect_inputs({(scratch / "test.cla").string()}, false);
  REQUIRE(inputs.items.size() == 3);
  CHECK(inputs.items[0].id == "db/0/m7/m7.off");
  CHECK(inputs.items[1].id == "db/1/m123/m123.off");
  CHECK(inputs.label_names == std::vector<std::string>{"dog", "plane"});
  CHECK(inputs.items[1].label == 0);
  CHECK(inputs.items[2].label == 1);
  CHECK(std::filesystem::exists(inputs.items[1].path));
  write_file(scratch / "bad.cla", "PSB 1\n1 5\ndog 0 2 1 2\n");
  CHECK_THROWS_AS(collect_inputs({(scratch / "bad.cla").string()}, false), UsageError);
}

TEST_CASE("command line: bytes, seconds and the nearest word") {
  CHECK(parse_bytes("512M") == std::uint64_t{512} << 20);
  CHECK(parse_bytes("1.5GiB") == std::uint64_t{3} << 29);
  CHECK(parse_bytes("100") == 100);
  CHECK_THROWS(parse_bytes("12Q"));
  CHECK_THROWS(parse_bytes("-4G"));
  CHECK(parse_seconds("120s") == 120);
  CHECK(parse_seconds("2m") == 120);
  CHECK(parse_seconds("0") == 0);
  CHECK_THROWS(parse_seconds("5 parsecs"));
  CHECK(nearest("progresive", std::vector<std::string>{"curve", "progressive"}) == "progressive");
  CHECK(nearest("xyzzy", std::vector<std::string>{"curve", "progressive"}).empty());
  CHECK(edit_distance("abcd", "abdc") == 1);
}
