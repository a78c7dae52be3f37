// An export into a folder that has begun and not ended.
#pragma once

#include <filesystem>
#include <string>

#include "jobs/cli/output_guard.h"

namespace meander {

// While an export is at work FOLDER/meander-export.json says which one, so that the same command knows the
// files of a process that was stopped or killed for its own. Files appear under their names whole.
class UnfinishedExport {
 public:
  static constexpr const char* description_name = "meander-export.json";

  // parameters: one JSON object, all that decides the files and their contents. Changes nothing. Throws
  // UsageError where the folder cannot be written to, or where another export was begun and not ended in it,
  // unless `fresh` makes everything anew.
  UnfinishedExport(std::filesystem::path folder, std::string parameters, bool fresh, OutputGuard& guard);

  // What an export that is continued finds is its own.
  Existing existing() const { return continues_ || replaces_ ? Existing::replace : Existing::keep; }
  // Whether an earlier process of this export has made the file. Never where it began with --fresh: the file
  // may then be that of the export before.
  bool has_made(const std::filesystem::path& file) const;

  // Once all outputs are checked: makes the folder. True where an earlier process may have left temporary
  // files in it.
  bool begin();
  void end();  // once all files are there

 private:
  std::filesystem::path description() const;

  std::filesystem::path folder_;
  std::string parameters_;
  bool replaces_;  // begun with --fresh
  bool continues_ = false;
};

}  // namespace meander
