// What `meander remesh` made: DIR/remesh.json and DIR/remesh.csv, one row an item.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "kernels/core/status.h"
#include "kernels/remesh/remesh_surface.h"

namespace meander {

struct RemeshRecord {
  Status status = Status::internal;
  std::string message;  // why it failed; of a mesh what a user should know of it, or nothing
  std::string file;     // the mesh, relative to DIR; empty where there is none
  std::uint32_t samples = 0;
  RemeshReport mesh;
  double seconds = 0;  // from the item's admission to its row; depends on the machine
};

struct RemeshTable {
  std::string parameters_json;                  // all parameters that decide the meshes
  std::string root;                             // of the ids of lists; empty where there are none
  std::map<std::string, RemeshRecord> records;  // by id
  std::set<std::string> planned;  // files that a run that has not ended may have made; empty at its end
};

// What a user should know of a mesh: components without a sample, samples at one place, vertices that stayed.
std::string remesh_message(const RemeshReport& report);

// The table in a folder; nothing where there is none. Throws RunError where it is not one.
std::optional<RemeshTable> read_remesh_table(const std::filesystem::path& folder);

// Both files, each whole or not at all. Throws FileError.
void write_remesh_table(const std::filesystem::path& folder, const RemeshTable& table);

std::filesystem::path remesh_json_path(const std::filesystem::path& folder);
std::filesystem::path remesh_csv_path(const std::filesystem::path& folder);

}  // namespace meander
