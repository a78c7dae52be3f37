#include "jobs/cli/unfinished_export.h"

#include <fmt/format.h>

#include <utility>

#include "io/file/atomic_file.h"
#include "io/file/directory.h"
#include "io/file/file_error.h"
#include "io/file/read_file.h"
#include "io/json/json_reader.h"
#include "io/json_writer.h"
#include "io/parameters_text.h"
#include "jobs/cli/usage_error.h"

namespace meander {

namespace fs = std::filesystem;

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
        fmt::format("another export into `{}` was begun and did not end: {} (repeat its command, or --fresh "
                    "makes this one from the beginning)",
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
  JsonWriter json;
  json.begin_object();
  json.member("parameters", parameters_);
  json.member("replaces", replaces_ ? 1 : 0);
  json.end_object();
  replace_file(description(), json.text() + "\n");
  return replaces_;
}

void UnfinishedExport::end() { remove_file(description()); }

}  // namespace meander
