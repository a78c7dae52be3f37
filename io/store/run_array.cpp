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
  json.member("shards_per_task", array.shards_per_task);
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
               plan.root,
               plan.retry};
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
  const std::int64_t shards_per_task = json.integer("shards_per_task").value_or(1);  // not in older ones
  if (shards_per_task < 1 || shards_per_task > static_cast<std::int64_t>(max_shards))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} is damaged: {} shards a task", source, shards_per_task));
  array.shards_per_task = static_cast<std::uint64_t>(shards_per_task);
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
  return read_plan_of_shard(shard_folder(store, shard));
}

std::vector<std::size_t> missing_shards(const fs::path& store, const RunArray& array) {
  std::vector<std::size_t> missing;
  for (std::size_t s = 0; s < array.shards.size(); ++s)
    if (array.shards[s].rows() > 0 && !fs::exists(shard_store(store, s))) missing.push_back(s);
  return missing;
}

namespace {

// Shards with rows, by their rows.
std::vector<std::size_t> shards_by_row(const RunArray& array) {
  std::vector<std::size_t> shards;
  for (std::size_t s = 0; s < array.shards.size(); ++s)
    if (array.shards[s].rows() > 0) shards.push_back(s);
  std::sort(shards.begin(), shards.end(),
            [&](std::size_t a, std::size_t b) { return array.shards[a].begin < array.shards[b].begin; });
  return shards;
}

// The header of these rows, and where they come from.
struct RowsOfShards {
  StoreHeader header;
  std::vector<MergeSource> sources;  // counted from the first of the rows
};

RowsOfShards rows_of_shards(const fs::path& store, const RunArray& array, std::span<const std::size_t> by_row,
                            RowRange rows) {
  RowsOfShards part;
  for (const std::size_t s : by_row) {
    const ArrayShard& shard = array.shards[s];
    const std::uint64_t begin = std::max(shard.begin, rows.begin), end = std::min(shard.end, rows.end);
    if (begin >= end) continue;
    part.sources.push_back({shard_store(store, s),
                            {begin - rows.begin, end - rows.begin},
                            begin - shard.begin,
                            shard.end - end});
    const RunPlan taken =
        plan_of_shard(read_shard_plan(store, s), {begin - shard.begin, end - shard.begin, 0});
    if (part.sources.size() == 1) {
      part.header = taken.header;
      continue;
    }
    const auto append = [](auto& values, const auto& more) {
      values.insert(values.end(), more.begin(), more.end());
    };
    append(part.header.ids, taken.header.ids);
    append(part.header.labels, taken.header.labels);
    append(part.header.splits, taken.header.splits);
  }
  return part;
}

void write_rows(const fs::path& store, const RowsOfShards& part) {
  const fs::path made = part_of_store(store);
  merge_rows(made, part.header, make_layout(part.header), part.sources);
  rename_file(made, store);
}

fs::path packing_marker(const fs::path& store) { return array_folder(store) / "packs.json"; }

// STORE.run/packs.json says that packs are being made, and of how many rows: those that are there are then of
// this merge.
class PackedMerge {
 public:
  PackedMerge(const fs::path& store, const RunArray& array, std::uint64_t rows_of_pack)
      : store_(store), array_(array), rows_of_pack_(rows_of_pack) {}

  void write() {
    begin();
    const std::vector<std::size_t> by_row = shards_by_row(array_);
    std::vector<StorePack> packs;
    StoreHeader whole;
    for (std::uint64_t begin = 0; begin < array_.rows; begin += rows_of_pack_) {
      const RowsOfShards part =
          rows_of_shards(store_, array_, by_row, {begin, std::min(begin + rows_of_pack_, array_.rows)});
      const fs::path path = pack_path(store_, packs.size());
      remove_leftovers(path);
      if (!fs::exists(path) || !check_whole_file(path).empty()) write_rows(path, part);
      StorePack& pack = packs.emplace_back(sealed_pack(path));
      pack.file = path.filename().string();
      pack.first_id = part.header.ids.front();
      pack.rows = part.header.ids.size();
      std::size_t longest = 1;
      for (const std::string& id : part.header.ids) longest = std::max(longest, id.size());
      id_width_ = std::max(id_width_, static_cast<std::uint32_t>(longest));
      if (packs.size() == 1) whole = part.header;
      if (part.header.columns->has_names()) {
        const Hdf5Lock lock;
        pack.names_bytes = StoreFileReader(path).names_bytes();
      }
    }
    write_index(whole, packs);
  }

 private:
  void begin() {
    const fs::path marker = packing_marker(store_);
    if (const std::optional<std::string> text = content_if_exists(marker.string())) {
      const std::int64_t rows = integer_of(JsonObject(*text, marker.string()), "rows", marker.string());
      if (static_cast<std::uint64_t>(rows) == rows_of_pack_) return;
      throw RunError(
          RunError::Kind::unusable,
          fmt::format("a merge of {} into packs of {} rows was begun, not of {}: repeat it with the "
                      "same --pack-size, or remove {} and the packs",
                      store_.string(), rows, rows_of_pack_, marker.string()));
    }
    const std::vector<fs::path> own = packs_of_store(store_);
    for (std::uint64_t p = 0; p * rows_of_pack_ < array_.rows; ++p)
      if (const fs::path path = pack_path(store_, p);
          fs::exists(path) && std::find(own.begin(), own.end(), path) == own.end())
        throw RunError(RunError::Kind::unusable,
                       fmt::format("{} exists and belongs to no store: move it away", path.string()));
    JsonWriter json;
    json.begin_object();
    json.member("rows", rows_of_pack_);
    json.end_object();
    replace_file(marker, json.text() + "\n", FullDisk::stops_run);
    // An index over packs of which some are new would be one of neither store.
    std::error_code ignored;
    if (!own.empty()) fs::remove(store_, ignored);
    remove_packs(own);
  }

  void write_index(const StoreHeader& header, const std::vector<StorePack>& packs) const {
    const fs::path made = part_of_store(store_);
    const StoreLayout layout = make_layout(header.columns, array_.rows, header.samples, header.compression,
                                           header.descriptors, id_width_, reason_width(packs));
    StoreFileWriter index(made, layout, header, packs);
    index.seal();
    rename_file(made, store_);
  }

  std::uint32_t reason_width(const std::vector<StorePack>& packs) const {
    std::uint32_t width = 1;
    for (const StorePack& pack : packs) {
      const Hdf5Lock lock;
      const StoreFileReader file(store_.parent_path() / pack.file);
      width = std::max(width, file.layout().datasets[file.layout().index_of(Role::reason)].text_width);
    }
    return width;
  }

  const fs::path& store_;
  const RunArray& array_;
  const std::uint64_t rows_of_pack_;
  std::uint32_t id_width_ = 1;
};

}  // namespace

std::uint64_t rows_of_pack(const StoreHeader& header, std::uint64_t bytes) {
  std::uint64_t of_row = 0;
  // Texts are as wide as the longest of the rows at hand, which would make packs depend on the shards.
  for (const DatasetLayout& dataset : make_layout(header).datasets)
    if (dataset.spec.type != ElementType::text) of_row += dataset.row_bytes;
  return std::max(bytes / of_row / column_chunk_rows, std::uint64_t{1}) * column_chunk_rows;
}

fs::path pack_path(const fs::path& store, std::size_t number) {
  return store.parent_path() /
         fmt::format("{}.pack-{:05}{}", store.stem().string(), number, store.extension().string());
}

void discard_packs_in_work(const fs::path& store) {
  if (!fs::exists(packing_marker(store))) return;
  std::error_code ignored;
  for (std::size_t p = 0; fs::remove(pack_path(store, p), ignored); ++p) {
  }
}

void merge_run_array(const fs::path& store, const RunArray& array, std::uint64_t pack_rows,
                     const std::function<void()>& merged) {
  const FileDescriptor lock = lock_folder(array_folder(store), "lock", false);
  remove_leftovers(store);
  if (pack_rows > 0 && pack_rows < array.rows) {
    PackedMerge(store, array, pack_rows).write();
  } else {
    const RowsOfShards all = rows_of_shards(store, array, shards_by_row(array), {0, array.rows});
    const std::vector<fs::path> replaced = packs_of_store(store);
    write_rows(store, all);
    remove_packs(replaced);
  }
  if (merged) merged();
  remove_run_folder(store);
}

}  // namespace meander
