#include "jobs/remesh/remesh_folder.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <system_error>

#include "io/file/atomic_file.h"
#include "io/file/directory.h"
#include "io/file/folder_lock.h"
#include "io/file/read_file.h"
#include "jobs/cli/output_guard.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

constexpr const char* lock_name = "remesh.json.lock";
constexpr std::chrono::seconds sync_interval(10);

}  // namespace

fs::path remesh_json_path(const fs::path& folder) { return folder / "remesh.json"; }
fs::path remesh_csv_path(const fs::path& folder) { return folder / "remesh.csv"; }

std::vector<std::string> remesh_names(std::span<const PlanItem> items, const std::string& extension) {
  std::vector<fs::path> names;
  std::map<fs::path, int> uses;
  for (const PlanItem& item : items)
    ++uses[names.emplace_back(fs::path(item.id).replace_extension(extension))];
  std::set<fs::path> taken{"remesh.json", "remesh.csv"};
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (uses[names[i]] > 1) names[i] = items[i].id + extension;
    names[i] = shortened_parts(names[i]);
    for (fs::path parent = names[i].parent_path(); !parent.empty() && parent != parent.root_path();
         parent = parent.parent_path())
      taken.insert(parent);
  }
  std::vector<std::string> result;
  for (const fs::path& name : names) {
    fs::path unique = name;
    for (int k = 2; !taken.insert(unique).second; ++k)
      unique = name.parent_path() / fmt::format("{}~{}{}", name.stem().string(), k, extension);
    result.push_back(unique.string());
  }
  return result;
}

RemeshFolder::RemeshFolder(fs::path path)
    : path_(std::move(path)), lock_(lock_folder(path_, lock_name, false)) {}

RemeshFolder::~RemeshFolder() {
  std::error_code none;
  if (lock_) fs::remove(lock_path(), none);
}

fs::path RemeshFolder::lock_path() const { return path_ / lock_name; }
fs::path RemeshFolder::log_path() const { return path_ / "remesh.json.log"; }

std::optional<RemeshTable> RemeshFolder::read() const {
  const std::string source = remesh_json_path(path_).string();
  const std::optional<std::string> text = content_if_exists(source);
  if (!text) return std::nullopt;
  RemeshTable table = remesh_table_of(*text, source);
  if (const auto log = content_if_exists(log_path())) add_logged(*log, log_path().string(), table);
  return table;
}

void RemeshFolder::write(const RemeshTable& table) const {
  replace_file(remesh_csv_path(path_), csv_of(table), FullDisk::stops_run);
  replace_file(remesh_json_path(path_), json_of(table), FullDisk::stops_run);
}

void RemeshFolder::begin(const RemeshTable& table, const std::set<std::string>& half_written) {
  fs::create_directories(path_);
  if (!lock_) lock_ = lock_folder(path_, lock_name, false);
  remove_temporaries(path_, half_written);
  // Without the log the table on disk is that of the process before: what only the log told is made again.
  remove_file(log_path());
  write(table);
  log_ = open_file(log_path(), O_WRONLY | O_CREAT | O_TRUNC);
  last_sync_ = std::chrono::steady_clock::now();
}

void RemeshFolder::append(const std::string& line, bool sync) {
  const std::lock_guard lock(mutex_);
  write_at(log_, std::as_bytes(std::span(line)), log_bytes_, log_path());
  log_bytes_ += line.size();
  const auto now = std::chrono::steady_clock::now();
  if (!sync || now - last_sync_ < sync_interval) return;
  sync_data(log_, log_path());
  last_sync_ = now;
}

void RemeshFolder::log_begun(const std::string& id) { append(log_line(id), false); }

void RemeshFolder::log_record(const std::string& id, const RemeshRecord& record) {
  append(log_line(id, record), true);
}

void RemeshFolder::end(const RemeshTable& table) {
  write(table);
  log_.close();
  remove_file(log_path());
}

}  // namespace meander
