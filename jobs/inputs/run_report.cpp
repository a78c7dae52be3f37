#include "jobs/inputs/run_report.h"

#include <fmt/format.h>

#include "io/file/read_file.h"
#include "io/item_id.h"
#include "io/json/json_reader.h"
#include "io/json/json_tree.h"
#include "io/run_error.h"
#include "kernels/core/status.h"
#include "meander_version.h"

namespace meander {

namespace {

// The result of `read`, or a default value when it throws.
template <class Read>
auto or_nothing(const Read& read) -> decltype(read()) {
  try {
    return read();
  } catch (const RunError&) {
    return {};
  }
}

std::set<std::string> texts_of(const std::string& list) {
  std::set<std::string> texts;
  try {
    const JsonTree tree(list);
    for (const JsonValue& value : tree.root().items())
      if (const auto text = value.text()) texts.emplace(*text);
  } catch (const ItemError&) {
    return {};
  }
  return texts;
}

}  // namespace

std::string build_text() {
  const std::string type = *meander_build_type == '\0' ? "" : fmt::format(" ({})", meander_build_type);
  return fmt::format("{} for {}{} with {}", meander_compiler, meander_architecture, type, meander_libraries);
}

RunReport read_run_report(const std::filesystem::path& store) {
  using std::chrono::nanoseconds, std::chrono::system_clock;
  std::filesystem::path path = store;
  path += ".run.json";
  const auto report = or_nothing([&]() -> std::optional<JsonObject> {
    const std::optional<std::string> text = content_if_exists(path);
    if (!text) return std::nullopt;
    return JsonObject(*text, path.string());
  });
  RunReport known;
  if (!report) return known;
  known.root = unescape_id(or_nothing([&] { return report->text("root"); }).value_or(""));
  if (const auto since = or_nothing([&] { return report->integer("inputs_read_since_unix_ns"); }))
    known.inputs_read_since =
        system_clock::time_point(std::chrono::duration_cast<system_clock::duration>(nanoseconds(*since)));
  if (const auto micro = or_nothing([&] { return report->integer("describe_microseconds"); }))
    known.describe_milliseconds = static_cast<double>(*micro) / 1000;
  if (const auto builds = report->members().find("builds"); builds != report->members().end())
    known.builds = texts_of(builds->second);
  return known;
}

}  // namespace meander
