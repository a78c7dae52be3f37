#include "jobs/cli/output_guard.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string_view>
#include <system_error>

#include "io/file/file_error.h"
#include "io/store/run_plan.h"
#include "jobs/cli/usage_error.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

fs::path with_suffix(const fs::path& store, std::string_view suffix) {
  fs::path path = store;
  path += suffix;
  return path;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : "."; }

// What is behind the name, links followed; empty when nothing is. A link to nothing is an error of its own:
// the file would be made somewhere else.
std::optional<struct stat> facts_of(const fs::path& path, const std::string& option) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) == 0) return facts;
  const int error = errno;
  if (error != ENOENT)
    throw UsageError(fmt::format("{}: cannot access `{}`: {}", option, path.string(), std::strerror(error)));
  if (::lstat(path.c_str(), &facts) == 0)
    throw UsageError(
        fmt::format("{}: `{}` is a symbolic link to a missing file: remove the link or give another name",
                    option, path.string()));
  return std::nullopt;
}

// For folders that the job creates, the parent of the first of them is checked.
void check_writable(const fs::path& folder, const std::string& option, bool missing_folders) {
  struct stat facts {};
  const bool there = ::stat(folder.c_str(), &facts) == 0;
  if (!there && errno == ENOENT && missing_folders) return check_writable(folder_of(folder), option, true);
  if (!there && errno == ENOENT)
    throw UsageError(
        fmt::format("{}: the folder `{}` does not exist: create it first", option, folder.string()));
  if (!there && errno != ENOTDIR)
    throw UsageError(
        fmt::format("{}: cannot access `{}`: {}", option, folder.string(), std::strerror(errno)));
  if (!there || !S_ISDIR(facts.st_mode))
    throw UsageError(fmt::format("{}: `{}` is not a folder", option, folder.string()));
  if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) != 0)
    throw UsageError(fmt::format("{}: cannot write to the folder `{}`: {}", option, folder.string(),
                                 std::strerror(errno)));
}

FileKind kind_for_message(const fs::path& path, const std::string& option) {
  try {
    return kind_of_file(path);
  } catch (const FileError& error) {
    throw UsageError(fmt::format("{}: `{}` exists but cannot be read, so its kind is unknown: {}", option,
                                 path.string(), error.code().message()));
  }
}

// Work that a run left begins with its lock. --fresh removes the folder with all that it holds.
void check_run_folder(const fs::path& folder) {
  std::error_code none;
  if (!fs::exists(fs::symlink_status(folder, none))) return;
  const auto refuse = [&](const std::string& what) {
    throw UsageError(
        fmt::format("`{}` is reserved for the unfinished work of this store, but it {}: move it away, or "
                    "give the store another name",
                    folder.string(), what));
  };
  if (!fs::is_directory(folder, none)) refuse("is not a folder");
  if (!fs::is_empty(folder, none) && !fs::exists(folder / "lock", none))
    refuse("holds files that were not made by a run");
}

}  // namespace

void OutputGuard::refuse_input(const fs::path& path, const FileNumber& number, const std::string& option) {
  for (; numbered_ < inputs_.size(); ++numbered_) {
    struct stat facts {};
    if (::stat(inputs_[numbered_].path.c_str(), &facts) == 0)
      input_numbers_.try_emplace({facts.st_dev, facts.st_ino}, inputs_[numbered_]);
  }
  const auto found = input_numbers_.find(number);
  if (found == input_numbers_.end()) return;
  const Input& input = found->second;
  throw UsageError(fmt::format("{}: `{}` is {}{} and would be replaced: give another name", option,
                               path.string(), input.what,
                               input.path == path ? "" : " (as `" + input.path.string() + "`)"));
}

void OutputGuard::check(const fs::path& path, std::initializer_list<FileKind> kinds,
                        const std::string& option, Existing existing, bool missing_folders) {
  if (path.empty()) return;
  std::error_code none;
  const fs::path canonical = fs::weakly_canonical(path, none);
  const auto [other, first] = outputs_.try_emplace(none ? path : canonical, option);
  if (!first)
    throw UsageError(
        fmt::format("{} and {} would write the same file `{}`", other->second, option, path.string()));
  const std::optional<struct stat> facts = facts_of(path, option);
  if (!facts) return check_writable(folder_of(path), option, missing_folders);
  if (S_ISDIR(facts->st_mode))
    throw UsageError(fmt::format("{}: `{}` is a folder, not a file", option, path.string()));
  if (!S_ISREG(facts->st_mode))
    throw UsageError(fmt::format("{}: `{}` is a device or another special file and cannot be replaced",
                                 option, path.string()));
  refuse_input(path, {facts->st_dev, facts->st_ino}, option);
  const FileKind kind = kind_for_message(path, option);
  if (kind != FileKind::empty && std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
    throw UsageError(
        fmt::format("{}: `{}` is {}: this command replaces only {}; give another name, or move it away",
                    option, path.string(), describe(kind), describe(*kinds.begin())));
  if (existing == Existing::keep)
    throw UsageError(fmt::format("{}: `{}` exists (--fresh replaces it)", option, path.string()));
  // A link is followed: its target is what is replaced.
  check_writable(folder_of(fs::is_symlink(path, none) ? fs::canonical(path, none) : path), option, false);
}

void OutputGuard::check_folder(const fs::path& folder, const std::string& option) const {
  std::error_code none;
  // A name that ends in a slash is that of the folder.
  const fs::path whole = folder.has_filename() ? folder : folder.parent_path();
  if (fs::is_symlink(whole, none)) facts_of(whole, option);
  check_writable(whole, option, true);
}

std::vector<fs::path> input_files(std::span<const std::string> arguments, std::span<const PlanItem> items) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments)
    if (argument != "-") files.emplace_back(argument.starts_with('@') ? argument.substr(1) : argument);
  for (const PlanItem& item : items) files.push_back(file_of(item));
  fs::path last;  // of tensors: often one file for all items
  for (const PlanItem& item : items)
    if (!item.tensor_path.empty() && item.tensor_path != last) files.push_back(last = item.tensor_path);
  return files;
}

void check_store_output(const fs::path& store, bool fresh, OutputGuard& guard) {
  guard.check(store, {FileKind::store}, "-o");
  std::error_code none;
  if (!fresh && fs::exists(store, none) && kind_for_message(store, "-o") == FileKind::empty)
    throw UsageError(fmt::format("-o: `{}` is an empty file (--fresh replaces it)", store.string()));
  check_run_folder(with_suffix(store, ".run"));
}

void refuse_finished_store(const fs::path& store, RunPurpose purpose) {
  if (!fs::exists(store)) return;
  const std::optional<RunPlan> begun = read_run_plan(store);
  if (!begun || begun->purpose != purpose)
    throw UsageError(fmt::format("`{}` exists (--fresh replaces it)", store.string()));
}

void check_run_outputs(const fs::path& store, bool fresh, std::span<const fs::path> inputs) {
  OutputGuard guard;
  guard.protect(inputs);
  check_store_output(store, fresh, guard);
  guard.check(with_suffix(store, ".run.json"), {FileKind::json}, "the report of -o");
  guard.check(with_suffix(store, ".failed.txt"), {FileKind::item_list}, "the list of failures of -o");
}

}  // namespace meander
