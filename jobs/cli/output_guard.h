// The rule of every job that writes: what may be replaced, asked before the first change.
//
// An existing file is replaced only by one of the same kind, determined by its content, and never when the
// command reads it; an empty file is nobody's. Outputs are files in folders that exist and can be written to.
// A job protects its inputs, then checks all outputs, and only then begins to write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
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
  replace,  // it goes: its content is what this command makes
  keep,     // an error that says that --fresh replaces it
};

class OutputGuard {
 public:
  // A file that the command reads: no output may have its place, under any name (links, hard links, other
  // spellings: device and inode are compared). A path where nothing is protects nothing. Costs nothing until
  // an output is found to exist. `what` the message calls it.
  void protect(std::filesystem::path input, const char* what = "an input of this command") {
    inputs_.push_back({std::move(input), what});
  }
  void protect(std::span<const std::filesystem::path> inputs) {
    for (const std::filesystem::path& input : inputs) protect(input);
  }

  // Throws UsageError when the file must not or cannot be written: it is an input, an output checked before,
  // of none of `kinds`, no file, `existing` keeps it, or its folder is missing or closed. `option` is what
  // the user gave it with, "-o" say. Folders that the job makes itself: missing_folders. An empty path is no
  // output.
  void check(const std::filesystem::path& path, std::initializer_list<FileKind> kinds,
             const std::string& option, Existing existing = Existing::replace, bool missing_folders = false);

  // Throws UsageError when `folder` cannot be made or written to, or is something else than a folder.
  void check_folder(const std::filesystem::path& folder, const std::string& option) const;

 private:
  using FileNumber = std::pair<std::uint64_t, std::uint64_t>;  // device, inode
  void refuse_input(const std::filesystem::path& path, const FileNumber& number, const std::string& option);

  struct Input {
    std::filesystem::path path;
    const char* what;
  };
  std::vector<Input> inputs_;
  std::size_t numbered_ = 0;  // of inputs_, those in input_numbers_
  std::map<FileNumber, Input> input_numbers_;
  std::map<std::filesystem::path, std::string> outputs_;  // and their options
};

// The files that the INPUT arguments of a command name or contain: the arguments themselves (a list without
// its @), the items found in them, and the files of their tensors.
std::vector<std::filesystem::path> input_files(std::span<const std::string> arguments,
                                               std::span<const PlanItem> items);

// Throws UsageError when a store of this name must not or cannot be written: see OutputGuard::check. A store
// that exists passes: whether it is continued, replaced or refused is the job's affair; an empty file passes
// with `fresh` alone. STORE.run must be the work of an interrupted run, or nothing: with --fresh it is
// removed with all that it holds. The store given to --reuse, or to describe, is not an input here.
void check_store_output(const std::filesystem::path& store, bool fresh, OutputGuard& guard);

// Throws UsageError where the store exists, for a job that makes new stores without --fresh. It passes where
// a run for `purpose` (RunPlan::purpose) is beside it: its process died after it had named the store, and it
// is finished again.
void refuse_finished_store(const std::filesystem::path& store, RunPurpose purpose);

// check_store_output for everything that `meander run` writes: the store, STORE.run.json and
// STORE.failed.txt. `inputs`: all files that the run reads, see input_files.
void check_run_outputs(const std::filesystem::path& store, bool fresh,
                       std::span<const std::filesystem::path> inputs);

}  // namespace meander
