#include "jobs/python/about_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "io/json_writer.h"
#include "io/table/npy_header.h"
#include "jobs/cli/command_line.h"
#include "jobs/inputs/surface_sources.h"
#include "jobs/rows/run_options.h"
#include "kernels/data/columns.h"
#include "kernels/model/remesh_model.h"
#include "kernels/model/sample_settings.h"
#include "kernels/surface/surface_settings.h"
#include "meander_version.h"

namespace meander {

namespace {

template <class Names>
void add_names(JsonWriter& json, const char* name, const Names& names) {
  json.key(name);
  json.begin_array();
  for (const std::string_view text : names) json.value(text);
  json.end_array();
}

// The settings with a keyword, as Python shows them: {keyword, type, default, words, list, help}.
template <class Settings>
void add_settings(JsonWriter& json, const char* name, std::span<const SettingList<Settings>* const> lists) {
  const Settings defaults;
  json.key(name);
  json.begin_array();
  for (const SettingList<Settings>* const list : lists)
    for (const Setting<Settings>& setting : list->items()) {
      if (setting.keyword.empty()) continue;
      const SettingValue value = setting.value(defaults);
      const bool truth = !setting.truth.first.empty() || std::holds_alternative<bool>(value);
      json.begin_object();
      json.member("keyword", setting.keyword);
      json.member("type", truth                                        ? "bool"
                          : std::holds_alternative<std::string>(value) ? "str"
                          : std::holds_alternative<double>(value)      ? "float"
                                                                       : "int");
      json.key("default");
      if (!setting.shows_default)
        json.null();
      else if (!setting.truth.first.empty())
        json.value(std::get<std::string>(value) == setting.truth.first);
      else
        std::visit([&](const auto& content) { json.value(content); }, value);
      add_names(json, "words", truth ? std::vector<std::string>() : setting.words);
      json.member("list", setting.is_list);
      json.member("help", setting.help);
      json.end_object();
    }
  json.end_array();
}

// What the description of a column in a store begins with, where it needs an option.
std::string prefix_of(const SampleColumn& column) {
  const std::string prefix = fmt::format("with --{} only: ", column.option);
  return !column.option.empty() && column.doc.starts_with(prefix) ? prefix : "";
}

// The columns of samples: {dataset, former (in older stores, where that is another name), array, type, width,
// doc, always, option, set}.
void add_columns(JsonWriter& json) {
  const Samples none;
  json.key("columns");
  json.begin_array();
  for (const SampleColumn& column : sample_columns) {
    json.begin_object();
    json.member("dataset", column.name);
    json.member("former", column.name_in(0));
    json.member("array", column.array_name());
    with_array(column, none,
               [&]<class Value>(const std::vector<Value>&) { json.member("type", numpy_type<Value>); });
    json.member("width", column.width);
    json.member("doc", column.doc.substr(prefix_of(column).size()));
    json.member("always", column.having == Having::all);
    json.member("option", column.option);
    json.member("set", name_of(column.set));
    json.end_object();
  }
  json.end_array();
}

// What decides where a run writes and what it prints, which meander.run sees to by itself, and what there is
// in place of a store.
constexpr std::string_view own_options[] = {"--help", "--help-all", "--output",  "--progress",
                                            "--json", "--stats",    "--dry-run", "--allow-failures"};
constexpr std::string_view array_heading = "Array";

// The settings that options of `run` set, by the option.
std::map<std::string, const Setting<SampleParameters>*> settings_by_option() {
  std::map<std::string, const Setting<SampleParameters>*> found;
  for (const SampleSettings* const list : sample_settings())
    for (const Setting<SampleParameters>& setting : list->items())
      if (!setting.option.empty()) found[setting.long_option()] = &setting;
  return found;
}

void add_run_option(JsonWriter& json, const OptionDescription& option, const std::string& name,
                    const Setting<SampleParameters>* setting) {
  // meander.run has the file itself under the name `store`.
  std::string keyword = name == "--store"                                 ? "columns"
                        : setting != nullptr && !setting->keyword.empty() ? setting->keyword
                                                                          : name.substr(2);
  std::replace(keyword.begin(), keyword.end(), '-', '_');
  json.begin_object();
  json.member("keyword", keyword);
  json.member("option", name);
  const bool truth = setting != nullptr && !setting->truth.first.empty();
  json.member("type", option.value.empty() || truth ? "bool"
                      : option.value == "N"         ? "int"
                      : option.value == "X"         ? "float"
                                                    : "str");
  json.member("default", option.initial);
  add_names(json, "words", truth ? std::vector<std::string>() : option.words);
  add_names(json, "truth",
            truth ? std::vector<std::string>{setting->truth.first, setting->truth.second}
                  : std::vector<std::string>());
  json.member("list", option.repeated);
  json.member("help", option.help);
  json.end_object();
}

// The options of `run`, those of the shards of an array left out.
void add_run_options(JsonWriter& json) {
  CommandLine line("meander", "", meander_version, "");
  Command program = line.program();
  RunOptions options;
  RunOptionTexts texts;
  ShardOptions shard;
  const CommandDescription described = add_run_command(program, options, texts, shard).description();
  const std::map<std::string, const Setting<SampleParameters>*> settings = settings_by_option();
  json.key("run_options");
  json.begin_array();
  for (const OptionDescription& option : described.options) {
    if (option.flags.empty() || option.heading.starts_with(array_heading)) continue;
    const std::string& name = option.flags.back();
    if (std::find(std::begin(own_options), std::end(own_options), name) != std::end(own_options)) continue;
    const auto setting = settings.find(name);
    add_run_option(json, option, name, setting == settings.end() ? nullptr : setting->second);
  }
  json.end_array();
}

}  // namespace

std::string about_text() {
  JsonWriter json;
  json.begin_object();
  json.member("version", meander_version);
  add_names(json, "surfaces", surface_names());
  add_names(json, "descriptors", descriptor_names);
  add_columns(json);
  // Arrays have colors and attributes of their own in place of what files bring along.
  const SampleSettings* const of_arrays[] = {&point_settings(), &column_settings(), &training_settings(),
                                             &collection_settings()};
  const SampleSettings* const training[] = {&training_settings()};
  const SurfaceSettings* const surface[] = {&surface_settings()};
  add_settings<SampleParameters>(json, "mesh_settings", of_arrays);
  add_settings<SampleParameters>(json, "file_settings", sample_settings());
  add_settings<SampleParameters>(json, "training_settings", training);
  add_settings<SurfaceSampleParameters>(json, "surface_settings", surface);
  const SettingList<RemeshParameters>* const mesh[] = {&remesh_settings()};
  add_settings<RemeshParameters>(json, "remesh_settings", mesh);
  add_run_options(json);
  json.end_object();
  return json.text();
}

}  // namespace meander
