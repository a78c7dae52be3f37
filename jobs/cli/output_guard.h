// What a job may write: checked for all of its outputs before the first change.
//
// An existing file is replaced only by a file of the same kind, determined by its content, and never when the
// command reads it; an empty file may always be replaced. The folder of an output must exist and be writable.
// A job protects its inputs, then checks all outputs, and only then begins to write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/file_kind.h"
#include "io/store/run_plan.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// What happens to a file of the right kind that has the name of an output.
enum class Existing {
  replace,  // the output replaces it
  keep,     // it stays: an error says that --fresh replaces it
};

class OutputGuard {
 public:
  // Protects a file that the command reads: no output may take its place, under any name (links, hard links,
  // other spellings: device and inode are compared). A path without a file protects nothing. Costs nothing
  // until an output is found to exist. `what` is the message's name for the file.
  void protect(std::filesystem::path input, const char* what = "an input of this command") {
    inputs_.push_back({std::move(input), what});
  }
  void protect(std::span<const std::filesystem::path> inputs) {
    for (const std::filesystem::path& input : inputs) protect(input);
  }

  // Throws UsageError when the file must not or cannot be written: it is an input, an output that was checked
  // before, not a file, not of one of `kinds`, to be kept (`existing`), or in a folder that is missing or not
  // writable. `option` is the option that named it, such as "-o". missing_folders: the job makes its folder.
  // An empty path is no output and passes.
  void check(const std::filesystem::path& path, std::initializer_list<FileKind> kinds,
             const std::string& option, Existing existing = Existing::replace, bool missing_folders = false);

  // Throws UsageError when `folder` cannot be made or written to, or is not a folder.
  void check_folder(const std::filesystem::path& folder, const std::string& option) const;

 private:
  using FileNumber = std::pair<std::uint64_t, std::uint64_t>;  // device, inode
  void refuse_input(const std::filesystem::path& path, const FileNumber& number, const std::string& option);

  struct Input {
    std::filesystem::path path;
    const char* what;
  };
  std::vector<Input> inputs_;
  std::size_t numbered_ = 0;  // how many of inputs_ are in input_numbers_
  std::map<FileNumber, Input> input_numbers_;
  std::map<std::filesystem::path, std::string> outputs_;  // the options by path
};

// The files that the INPUT arguments of a command name or contain: the arguments themselves (a list without
// its @), the items found in them, and the files of their tensors.
std::vector<std::filesystem::path> input_files(std::span<const std::string> arguments,
                                               std::span<const PlanItem> items);

// Throws UsageError when a store of this name must not or cannot be written: see OutputGuard::check. An
// existing store passes, since the job decides whether it is continued, replaced or refused; an empty file
// passes with `fresh` alone. STORE.run must be missing or the work of an interrupted run, because --fresh
// removes it with all that it holds. The store of --reuse and the one that is described are not inputs in
// this sense.
void check_store_output(const std::filesystem::path& store, bool fresh, OutputGuard& guard);

// Throws UsageError when the store exists, for a job that makes new stores without --fresh. A store with a
// run for `purpose` (RunPlan::purpose) beside it passes: the process of that run died after it had given the
// store its name, and the run is finished again.
void refuse_finished_store(const std::filesystem::path& store, RunPurpose purpose);

// Checks everything that `meander run` writes: the store, STORE.run.json and STORE.failed.txt. `inputs`: all
// files that the run reads, see input_files.
void check_run_outputs(const std::filesystem::path& store, bool fresh,
                       std::span<const std::filesystem::path> inputs);

// The path with every part shortened to 230 bytes, so that a temporary name still fits into the 255 of file
// systems. A part that is too long is cut in front of its extension and gets a hash of the whole part.
std::filesystem::path shortened_parts(const std::filesystem::path& path);

// Removes the temporary files of killed processes (AtomicFile: NAME.tmp and a number) whose NAME is one of
// `names`, relative to the folder, or is in the folder itself and passes `is_own`. Lists each folder once.
void remove_temporaries(const std::filesystem::path& folder, const std::set<std::string>& names);
void remove_temporaries(const std::filesystem::path& folder,
                        const std::function<bool(const std::string& name)>& is_own);

// An export into a folder that has begun and not ended. While it works, FOLDER/meander-export.json describes
// it, so that the same command recognizes the files of a process that was stopped or killed as its own. Files
// get their names once they are complete.
class UnfinishedExport {
 public:
  static constexpr const char* description_name = "meander-export.json";

  // parameters: one JSON object with everything that decides the files and their contents. Changes nothing.
  // Throws UsageError when the folder cannot be written to, or when another export has begun in it and not
  // ended, unless `fresh` makes everything anew.
  UnfinishedExport(std::filesystem::path folder, std::string parameters, bool fresh, OutputGuard& guard);

  // The files that a continued export finds are its own.
  Existing existing() const { return continues_ || replaces_ ? Existing::replace : Existing::keep; }
  // Whether an earlier process of this export has made the file. Always false when it began with --fresh: the
  // file may then be one of the export before.
  bool has_made(const std::filesystem::path& file) const;

  // Makes the folder; called once all outputs are checked. True when an earlier process may have left
  // temporary files in it.
  bool begin();
  void end();  // called once all files are complete

 private:
  std::filesystem::path description() const;

  std::filesystem::path folder_;
  std::string parameters_;
  bool replaces_;  // begun with --fresh
  bool continues_ = false;
};

}  // namespace meander
