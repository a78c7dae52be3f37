// The table of schemas of `meander export` against docs/TRAINING.md.
#include "jobs/export/training_schema.h"

#include <filesystem>
#include <iostream>
#include <set>

#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/scratch_files.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("export --schema: the table in docs/TRAINING.md matches the code") {
  const std::string page = read_file(std::filesystem::path(MEANDER_SOURCE_DIR) / "docs" / "TRAINING.md");
  const std::string table = schema_markdown();
  const bool is_there = page.find(table) != std::string::npos;
  if (!is_there) std::cout << table;
  CHECK(is_there);
  for (const auto& word : schema_words)
    CHECK(page.find(std::string("| ") + word.text + " ([") != std::string::npos);
}

TEST_CASE("schema_files: names below the folder, whatever the id") {
  CHECK(schema_files(SchemaKind::hunyuan, "a/b.off") ==
        std::vector<std::string>{"a/b.off_surface.npz", "a/b.off_sdf.npz"});
  CHECK(schema_files(SchemaKind::occnet, "b") ==
        std::vector<std::string>{"b/points.npz", "b/pointcloud.npz"});
  CHECK(schema_files(SchemaKind::vecset, "x/y/b") ==
        std::vector<std::string>{"ShapeNetV2_point/x/y/b.npz", "ShapeNetV2_point/x/y/b.npy",
                                 "ShapeNetV2_watertight/x/y/4_pointcloud/b.npz"});
  CHECK(schema_files(SchemaKind::vecset, "b").back() == "ShapeNetV2_watertight/4_pointcloud/b.npz");
}

TEST_CASE("schema_members: names behind a key, each once") {
  CHECK(schema_members(SchemaKind::hunyuan) == std::vector<std::string>{"surface.npz", "sdf.npz"});
  CHECK(schema_members(SchemaKind::vecset) == std::vector<std::string>{"npz", "npy", "4_pointcloud.npz"});
  for (const auto& word : schema_words) {
    const std::vector<std::string> members = schema_members(word.value);
    CHECK(members.size() == schema_files(word.value, "x").size());
    CHECK(std::set<std::string>(members.begin(), members.end()).size() == members.size());
  }
}
