// What `meander remesh` made, one row an item: DIR/remesh.json and DIR/remesh.csv; while it works, the lines
// of DIR/remesh.json.log since.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "kernels/core/status.h"
#include "kernels/remesh/remesh_surface.h"

namespace meander {

// By which a changed input is known.
struct InputStamp {
  std::int64_t bytes = -1;     // of its files, or of the archive that it is in; -1: not known
  std::int64_t modified = -1;  // nanoseconds of the system's file clock
  bool operator==(const InputStamp&) const = default;
};

struct RemeshRecord {
  Status status = Status::internal;
  std::string message;  // why it failed; of a mesh what a user should know of it, or nothing
  std::string file;     // the mesh, relative to DIR; empty where there is none
  std::string lacks;  // what vertices should carry and the model has not, or not everywhere; words of options
  std::uint32_t samples = 0;
  RemeshReport mesh;
  double seconds = 0;  // from the item's admission to its row; depends on the machine
  InputStamp input;    // when it was read
};

struct RemeshTable {
  std::string parameters_json;                  // all parameters that decide the meshes
  std::string root;                             // of the ids of lists; empty where there are none
  std::map<std::string, RemeshRecord> records;  // by id
  std::set<std::string> planned;  // files that a run that has not ended may have made; empty at its end
  std::set<std::string> begun;    // ids that a process which died was at work on; in the log alone
};

// What a user should know of a mesh: components without a sample, samples at one place, vertices that stayed,
// triangles that cross, values that it lacks.
std::string remesh_message(const RemeshReport& report, const std::string& lacks);

// Both files, as text.
std::string json_of(const RemeshTable& table);
std::string csv_of(const RemeshTable& table);
// Throws RunError where `text`, the content of `source`, is no table of the command.
RemeshTable remesh_table_of(const std::string& text, const std::string& source);

// Lines of the log: an item that is begun, and what became of one.
std::string log_line(const std::string& id);
std::string log_line(const std::string& id, const RemeshRecord& record);
// Adds the whole lines of a log to the table. Ignores everything after the first incomplete line, which a
// kill or a power cut may leave.
void add_logged(std::string_view log, const std::string& source, RemeshTable& table);

}  // namespace meander
