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
#include <vector>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/file/directory.h"
#include "io/file/file_error.h"
#include "io/file/read_file.h"
#include "io/json/json_reader.h"
#include "io/json_writer.h"
#include "io/mesh/mesh_format.h"
#include "io/parameters_text.h"
#include "io/store/run_plan.h"
#include "io/word_list.h"
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

// The file of this name, links followed; empty when there is none. A link to nothing is an error of its own,
// since the file would be made somewhere else.
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

// When the job creates folders, the folder that the first of them is created in is checked.
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

// Refuses a folder without the lock of a run, since --fresh removes the folder with all that it holds.
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
  // Links are followed: the target is replaced.
  check_writable(folder_of(fs::is_symlink(path, none) ? fs::canonical(path, none) : path), option, false);
}

void OutputGuard::check_folder(const fs::path& folder, const std::string& option) const {
  std::error_code none;
  // Without the slash that the name of a folder may end in.
  const fs::path whole = folder.has_filename() ? folder : folder.parent_path();
  if (fs::is_symlink(whole, none)) facts_of(whole, option);
  check_writable(whole, option, true);
}

std::vector<fs::path> input_files(std::span<const std::string> arguments, std::span<const PlanItem> items) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments)
    if (argument != "-") files.emplace_back(argument.starts_with('@') ? argument.substr(1) : argument);
  for (const PlanItem& item : items) files.push_back(file_of(item));
  fs::path last;  // file of tensors; all items often have the same
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

namespace {

// A store under the name of another kind of file would be taken for one.
void check_store_name(const fs::path& store) {
  const std::string extension = lower_ascii(store.extension().string());
  MeshFormat format;
  std::error_code none;
  if (!fs::exists(store, none) &&
      (mesh_format_of(store, format) ||
       std::any_of(std::begin(kind_endings), std::end(kind_endings),
                   [&](const KindEnding& other) { return other.ending == extension; })))
    throw UsageError(
        fmt::format("-o: `{}` has the extension of another kind of file: a store is an HDF5 file, as x.h5; "
                    "`meander export x.h5 -o x.ply` writes points, `meander remesh` meshes",
                    store.string()));
}

}  // namespace

void check_run_outputs(const fs::path& store, bool fresh, std::span<const fs::path> inputs) {
  check_store_name(store);
  OutputGuard guard;
  guard.protect(inputs);
  check_store_output(store, fresh, guard);
  guard.check(with_suffix(store, ".run.json"), {FileKind::json}, "the report of -o");
  guard.check(with_suffix(store, ".failed.txt"), {FileKind::item_list}, "the list of failures of -o");
}

namespace {

constexpr std::size_t longest_part = 230, longest_extension = 16;

}  // namespace

fs::path shortened_parts(const fs::path& path) {
  fs::path result;
  for (const fs::path& part : path) {
    std::string name = part.string();
    if (name.size() > longest_part) {
      const auto digest = sha256(std::as_bytes(std::span(name)));
      // An extension that is not short is part of the name: it may be nearly all of it.
      const std::string extension = part.extension().string();
      const std::string ending = "~" + hex_text(std::span(digest).first(8)) +
                                 (extension.size() <= longest_extension ? extension : std::string());
      std::size_t kept = longest_part - std::min(longest_part, ending.size());
      while (kept > 0 && (static_cast<unsigned char>(name[kept]) & 0xC0) == 0x80) --kept;  // whole characters
      name = name.substr(0, kept) + ending;
    }
    result /= name;
  }
  return result;
}

void remove_temporaries(const fs::path& folder, const std::function<bool(const std::string&)>& is_own) {
  std::error_code none;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end; entry.increment(none)) {
    const std::string name = entry->path().filename().string();
    const std::size_t mark = name.rfind(".tmp");
    if (mark == std::string::npos || mark + 4 == name.size() ||
        name.find_first_not_of("0123456789", mark + 4) != std::string::npos)
      continue;
    if (is_own(name.substr(0, mark))) leftovers.push_back(entry->path());
  }
  for (const fs::path& path : leftovers) fs::remove(path, none);
}

void remove_temporaries(const fs::path& folder, const std::set<std::string>& names) {
  std::map<fs::path, std::set<std::string>> by_folder;
  for (const std::string& name : names) {
    const fs::path path = folder / name;
    by_folder[path.parent_path()].insert(path.filename().string());
  }
  for (const auto& folder_of_files : by_folder)
    remove_temporaries(folder_of_files.first,
                       [&](const std::string& name) { return folder_of_files.second.contains(name); });
}

UnfinishedExport::UnfinishedExport(fs::path folder, std::string parameters, bool fresh, OutputGuard& guard)
    : folder_(std::move(folder)), parameters_(std::move(parameters)), replaces_(fresh) {
  guard.check_folder(folder_, "-o");
  guard.check(description(), {FileKind::json}, "the description of the export", Existing::replace, true);
  if (fresh) return;
  const std::optional<std::string> text = content_if_exists(description());
  if (!text) return;
  const JsonObject begun(*text, description().string());
  const std::string before = begun.text("parameters").value_or("");
  if (before != parameters_)
    throw UsageError(
        fmt::format("another export into `{}` is unfinished: {} (repeat its command, or start this one anew "
                    "with --fresh)",
                    folder_.string(), parameter_differences(before, parameters_)));
  continues_ = true;
  replaces_ = begun.integer("replaces").value_or(1) != 0;
}

fs::path UnfinishedExport::description() const { return folder_ / description_name; }

bool UnfinishedExport::has_made(const fs::path& file) const {
  return continues_ && !replaces_ && fs::exists(file);
}

bool UnfinishedExport::begin() {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw_file_error(error.value(), "create", folder_, FullDisk::ends_command);
  if (continues_) return true;
  const std::string text = json_object([&](JsonWriter& json) {
    json.member("parameters", parameters_);
    json.member("replaces", replaces_ ? 1 : 0);
  });
  replace_file(description(), text + "\n");
  return replaces_;
}

void UnfinishedExport::end() { remove_file(description()); }

}  // namespace meander
