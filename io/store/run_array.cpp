#include "io/store/run_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>
#include <type_traits>
#include <utility>

#include "io/file/atomic_file.h"
#include "io/file/directory.h"
#include "io/file/folder_lock.h"
#include "io/file/read_file.h"
#include "io/item_id.h"
#include "io/json/json_reader.h"
#include "io/json_writer.h"
#include "io/store/run_folder.h"
#include "io/store/run_plan.h"
#include "io/store/store_merge.h"

namespace meander {

namespace fs = std::filesystem;
using namespace store;

namespace {

constexpr const char* description = "array.json";
constexpr std::int64_t array_version = 1;
constexpr std::size_t shards_of_folder = 1000;

// Lists stand as objects whose members are named 0, 1, 2, ...
template <class Value>
void write_list(JsonWriter& json, const char* name, const std::vector<Value>& values,
                const std::function<void(const Value&)>& write) {
  json.key(name);
  json.begin_object();
  for (std::size_t i = 0; i < values.size(); ++i) {
    json.key(std::to_string(i));
    write(values[i]);
  }
  json.end_object();
}

template <class Value>
std::vector<Value> read_list(const JsonObject& json, const std::string& name, const std::string& source,
                             const std::function<Value(const JsonObject&, const std::string&)>& read) {
  const auto found = json.members().find(name);
  if (found == json.members().end())
    throw RunError(RunError::Kind::unusable, fmt::format("{} has no `{}`", source, name));
  const JsonObject list(found->second, source);
  std::vector<Value> values;
  for (std::size_t i = 0; i < list.members().size(); ++i) values.push_back(read(list, std::to_string(i)));
  return values;
}

std::int64_t integer_of(const JsonObject& json, const std::string& name, const std::string& source) {
  const auto value = json.integer(name);
  if (!value) throw RunError(RunError::Kind::unusable, fmt::format("{} has no `{}`", source, name));
  return *value;
}

ArrayShard shard_of(const std::string& text, const std::string& source) {
  const JsonObject json(text, source);
  ArrayShard shard;
  shard.begin = static_cast<std::uint64_t>(integer_of(json, "begin", source));
  shard.end = static_cast<std::uint64_t>(integer_of(json, "end", source));
  const auto cost = json.members().find("cost_seconds");
  if (cost != json.members().end()) shard.cost = std::strtod(cost->second.c_str(), nullptr);
  return shard;
}

std::string json_of(const RunArray& array) {
  JsonWriter json;
  json.begin_object();
  json.member("tool", "meander");
  json.member("array_version", array_version);
  json.member("rows", array.rows);
  json.member("folder", escape_id(array.folder));
  json.member("inputs_listed_unix_ns", array.inputs_listed_unix_ns);
  write_list<std::string>(json, "arguments", array.arguments,
                          [&](const std::string& argument) { json.value(escape_id(argument)); });
  write_list<ArrayShard>(json, "shards", array.shards, [&](const ArrayShard& shard) {
    json.begin_object();
    json.member("begin", shard.begin);
    json.member("end", shard.end);
    json.member("cost_seconds", shard.cost);
    json.end_object();
  });
  json.end_object();
  return json.text() + "\n";
}

// Every row is in one shard.
bool covers_all_rows(const RunArray& array) {
  std::map<std::uint64_t, std::uint64_t> ranges;
  for (const ArrayShard& shard : array.shards) {
    if (shard.end < shard.begin) return false;
    if (shard.rows() > 0 && !ranges.emplace(shard.begin, shard.end).second) return false;
  }
  std::uint64_t row = 0;
  for (const auto& [begin, end] : ranges) {
    if (begin != row) return false;
    row = end;
  }
  return row == array.rows;
}

RunPlan plan_of_shard(const RunPlan& plan, const ArrayShard& shard) {
  const auto rows = [&](const auto& values) {
    const auto begin =
        values.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(shard.begin, values.size()));
    const auto end =
        values.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(shard.end, values.size()));
    return std::decay_t<decltype(values)>(begin, end);
  };
  const StoreHeader& all = plan.header;
  RunPlan part{{all.columns, all.samples, all.compression, all.seed, all.order, all.parameters_json,
                all.label_names, all.descriptors, rows(all.ids), rows(all.labels), rows(all.splits),
                all.method_version, all.tool_version},
               plan.purpose,
               plan.root};
  return part;
}

}  // namespace

fs::path array_folder(const fs::path& store) { return with_suffix(store, ".run"); }

fs::path shard_folder(const fs::path& store, std::size_t shard) {
  return array_folder(store) / "shards" / fmt::format("{:03}", shard / shards_of_folder) /
         fmt::format("shard-{:06}", shard);
}

fs::path shard_store(const fs::path& store, std::size_t shard) {
  return with_suffix(shard_folder(store, shard), ".h5");
}

void create_run_array(const fs::path& store, const RunArray& array, const RunPlan& plan,
                      const std::function<void(std::size_t, const fs::path&)>& add) {
  const fs::path folder = array_folder(store);
  const FileDescriptor lock = lock_folder(folder, "lock", true);
  if (fs::exists(folder / description) || plan_exists(folder))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} is there already (--fresh discards it)", folder.string()));
  std::error_code ignored;
  fs::remove_all(folder / "shards", ignored);
  make_folder(folder / "shards");
  for (std::size_t s = 0; s < array.shards.size(); ++s) {
    const fs::path part = shard_folder(store, s);
    make_folder(part.parent_path());
    make_folder(part);
    write_plan(part, plan_of_shard(plan, array.shards[s]));
    add(s, part);
    // The names of the shards of a group, once for all; write_plan synced what each holds.
    const bool last_of_group = s + 1 == array.shards.size() || (s + 1) % shards_of_folder == 0;
    if (last_of_group) sync_folder(part.parent_path());
  }
  sync_folder(folder / "shards");
  replace_file(folder / description, json_of(array), FullDisk::stops_run);
  sync_folder(folder.parent_path());
}

std::optional<RunArray> read_run_array(const fs::path& store) {
  const std::string source = (array_folder(store) / description).string();
  const std::optional<std::string> text = content_if_exists(source);
  if (!text) return std::nullopt;
  const JsonObject json(*text, source);
  if (json.integer("array_version") != array_version)
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} was planned by another version of the program", source));
  RunArray array;
  array.rows = static_cast<std::uint64_t>(integer_of(json, "rows", source));
  array.folder = unescape_id(json.text("folder").value_or(""));
  array.inputs_listed_unix_ns = integer_of(json, "inputs_listed_unix_ns", source);
  array.arguments =
      read_list<std::string>(json, "arguments", source, [](const JsonObject& list, const std::string& name) {
        return unescape_id(list.text(name).value_or(""));
      });
  array.shards =
      read_list<ArrayShard>(json, "shards", source, [&](const JsonObject& list, const std::string& name) {
        const auto shard = list.members().find(name);
        return shard == list.members().end() ? ArrayShard{} : shard_of(shard->second, source);
      });
  if (!covers_all_rows(array))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} is damaged: its shards are not all rows", source));
  return array;
}

RunPlan read_shard_plan(const fs::path& store, std::size_t shard) {
  return read_plan(shard_folder(store, shard));
}

std::vector<std::size_t> missing_shards(const fs::path& store, const RunArray& array) {
  std::vector<std::size_t> missing;
  for (std::size_t s = 0; s < array.shards.size(); ++s)
    if (array.shards[s].rows() > 0 && !fs::exists(shard_store(store, s))) missing.push_back(s);
  return missing;
}

void merge_run_array(const fs::path& store, const RunArray& array, const std::function<void()>& merged) {
  const fs::path folder = array_folder(store);
  const FileDescriptor lock = lock_folder(folder, "lock", false);
  std::vector<std::pair<std::uint64_t, std::size_t>> by_row;  // shards that have rows
  for (std::size_t s = 0; s < array.shards.size(); ++s)
    if (array.shards[s].rows() > 0) by_row.emplace_back(array.shards[s].begin, s);
  std::sort(by_row.begin(), by_row.end());
  RunPlan whole;
  std::vector<MergeSource> sources;
  for (const auto& [begin, s] : by_row) {
    RunPlan part = read_shard_plan(store, s);
    sources.push_back({shard_store(store, s), {begin, array.shards[s].end}});
    if (sources.size() == 1) {
      whole = std::move(part);
      continue;
    }
    const auto append = [](auto& values, auto& more) {
      values.insert(values.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    };
    append(whole.header.ids, part.header.ids);
    append(whole.header.labels, part.header.labels);
    append(whole.header.splits, part.header.splits);
  }
  remove_leftovers(store);
  const fs::path made = part_of_store(store);
  merge_rows(made, whole.header, make_layout(whole.header), sources);
  rename_file(made, store);
  if (merged) merged();
  remove_run_folder(store);
}

}  // namespace meander
