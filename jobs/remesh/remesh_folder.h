// The folder that `meander remesh` writes to.
#pragma once

#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/file/file_descriptor.h"
#include "jobs/remesh/remesh_table.h"
#include "pipeline/sampling_graph.h"

namespace meander {

std::filesystem::path remesh_json_path(const std::filesystem::path& folder);
std::filesystem::path remesh_csv_path(const std::filesystem::path& folder);

// The names of the meshes of the items, relative to the folder: ids with another extension; where that gives
// one name to several items, it follows their own extension. A name that is then still taken, by another mesh
// or by a folder of meshes, gets "~2", "~3", ... before the extension, and a part of a path that is too long
// for file systems ends with a hash of the whole.
std::vector<std::string> remesh_names(std::span<const PlanItem> items, const std::string& extension);

// Held by one process: the lock, the table, and the log of what was done since the table was written. A
// process that dies leaves the log to the next; one that ends removes it.
class RemeshFolder {
 public:
  // Nothing is made or written yet. Throws RunError(stopped) while another process holds the folder.
  explicit RemeshFolder(std::filesystem::path path);
  ~RemeshFolder();
  RemeshFolder(const RemeshFolder&) = delete;
  RemeshFolder& operator=(const RemeshFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  // The table that earlier processes left, with their log; nothing where none was here. Throws RunError where
  // there is a table of something else.
  std::optional<RemeshTable> read() const;

  // Makes the folder where it is missing, removes what an earlier process left half-written of its `planned`
  // files, writes the table, and begins an empty log. Throws FileError, as the following do.
  void begin(const RemeshTable& table, const std::set<std::string>& half_written);
  // Lines of the log; from any thread. On disk some seconds later.
  void log_begun(const std::string& id);
  void log_record(const std::string& id, const RemeshRecord& record);
  // The table replaces the log.
  void end(const RemeshTable& table);

  // In a child process: the lock is the parent's.
  void leave_lock_to_parent() { lock_ = {}; }

 private:
  std::filesystem::path lock_path() const;
  std::filesystem::path log_path() const;
  void write(const RemeshTable& table) const;
  void append(const std::string& line, bool sync);

  const std::filesystem::path path_;
  FileDescriptor lock_;
  std::mutex mutex_;  // guards what follows
  FileDescriptor log_;
  std::uint64_t log_bytes_ = 0;
  std::chrono::steady_clock::time_point last_sync_;
};

}  // namespace meander
