#include "jobs/run/array_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>

#include "io/archive/archive.h"
#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/item_id.h"
#include "io/json/json_reader.h"
#include "io/json_writer.h"
#include "io/parameters_text.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/inputs/label_file.h"
#include "jobs/run/array_script.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

fs::path report_path(const std::string& store, std::size_t shard) {
  return fs::path(shard_folder(store, shard)) += ".json";
}

[[noreturn]] void refuse_items(const fs::path& path, const std::string& why) {
  throw RunError(RunError::Kind::unusable,
                 fmt::format("{} is damaged ({}): plan again with --fresh", path.string(), why));
}

// The archives of a shard, each listed once.
class OpenArchives {
 public:
  // Empty where the archive or the member is gone: the item is then read as a file, and its row says that the
  // file is missing. `inner`: the name of the archive that has the member, inside the one at `path`; or "".
  PackedFile find(const std::string& path, const std::string& inner, const std::string& member) {
    const std::shared_ptr<const Archive> archive = open(path, inner);
    if (!archive) return {};
    for (std::size_t m = 0; m < archive->members().size(); ++m)
      if (archive->members()[m].name == member) return {archive, m};
    return {};
  }

 private:
  std::shared_ptr<const Archive> open(const std::string& path, const std::string& inner) {
    std::shared_ptr<const Archive>& archive = archives_[{path, inner}];
    if (archive) return archive;
    const std::shared_ptr<const Archive> outer = inner.empty() ? nullptr : open(path, "");
    const auto member = outer ? outer->find(inner) : std::nullopt;
    try {
      if (inner.empty()) archive = std::make_shared<const Archive>(path);
      if (member) archive = std::make_shared<const Archive>(outer, *member);
    } catch (const ItemError&) {
    }
    return archive;
  }

  std::map<std::pair<std::string, std::string>, std::shared_ptr<const Archive>> archives_;
};

}  // namespace

void check_run_outputs(const RunOptions& options, const Inputs& inputs) {
  std::vector<fs::path> read = input_files(options.inputs, inputs.items);
  for (const std::string& labels : options.collect.labels) read.push_back(path_of_labels(labels));
  check_run_outputs(options.store, options.fresh, read);
}

std::vector<ArrayShard> cut_into_shards(std::span<const double> costs, std::size_t shards) {
  std::uint64_t block = 256;
  while (block > 1 && costs.size() < 16 * block * shards) block /= 2;
  double left = std::accumulate(costs.begin(), costs.end(), 0.0);
  std::vector<ArrayShard> result(shards);
  std::uint64_t row = 0;
  for (std::size_t s = 0; s < shards; ++s) {
    ArrayShard& shard = result[s];
    shard.begin = row;
    const double share = left / static_cast<double>(shards - s);
    while (row < costs.size()) {
      double cost = 0;
      const std::uint64_t end = std::min<std::uint64_t>(row + block, costs.size());
      for (std::uint64_t r = row; r < end; ++r) cost += costs[r];
      // A block goes to the shard whose cost it brings closer to its share.
      const bool last = s + 1 == shards;
      if (!last && shard.cost > 0 && shard.cost + 0.5 * cost > share) break;
      shard.cost += cost;
      row = end;
    }
    shard.end = row;
    left = std::max(0.0, left - shard.cost);
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const ArrayShard& a, const ArrayShard& b) { return a.cost > b.cost; });
  return result;
}

std::size_t shards_of_minutes(std::span<const double> costs, double minutes, int threads) {
  const double total = std::accumulate(costs.begin(), costs.end(), 0.0);
  const double shards = std::ceil(total / (60 * minutes * threads));
  return static_cast<std::size_t>(std::clamp(shards, 1.0, std::max(1.0, static_cast<double>(costs.size()))));
}

std::uint64_t shards_per_task(std::uint64_t shards, std::uint64_t max_tasks) {
  return std::max<std::uint64_t>(1, (shards + max_tasks - 1) / max_tasks);
}

std::vector<std::size_t> tasks_of_shards(std::span<const std::size_t> ascending,
                                         std::uint64_t shards_per_task, std::int64_t offset) {
  std::vector<std::size_t> tasks;
  for (const std::size_t shard : ascending) {
    const std::int64_t task = static_cast<std::int64_t>(shard / shards_per_task) - offset;
    if (task >= 0 && (tasks.empty() || tasks.back() != static_cast<std::size_t>(task)))
      tasks.push_back(static_cast<std::size_t>(task));
  }
  return tasks;
}

namespace {

// Gaps of up to `closed` numbers are closed.
std::string expression_over_gaps(std::span<const std::size_t> ascending, std::size_t closed) {
  std::string text;
  for (std::size_t i = 0; i < ascending.size();) {
    std::size_t end = i + 1;
    while (end < ascending.size() && ascending[end] - ascending[end - 1] <= closed + 1) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ",", ascending[i]);
    if (end - i > 1) text += fmt::format("-{}", ascending[end - 1]);
    i = end;
  }
  return text;
}

}  // namespace

std::string array_expression(std::span<const std::size_t> ascending, std::size_t max_bytes) {
  std::string text = expression_over_gaps(ascending, 0);
  if (text.size() <= max_bytes) return text;
  std::size_t too_few = 0, enough = ascending.back() - ascending.front();  // one range
  while (enough - too_few > 1) {
    const std::size_t closed = too_few + (enough - too_few) / 2;
    (expression_over_gaps(ascending, closed).size() <= max_bytes ? enough : too_few) = closed;
  }
  return expression_over_gaps(ascending, enough);
}

void write_shard_items(const fs::path& folder, std::span<const PlanItem> items) {
  AtomicFile file(folder / "items.jsonl", FullDisk::stops_run);
  for (const PlanItem& item : items) {
    JsonWriter json;
    json.begin_object();
    json.member("id", item.id);
    json.member("path", escape_id(fs::absolute(item.path).string()));
    if (item.packed) {
      json.member("archive", escape_id(fs::absolute(item.packed.archive->path()).string()));
      if (item.packed.archive->outer()) json.member("inner", escape_id(item.packed.archive->name_in_outer()));
      json.member("member", escape_id(item.packed.facts().name));
    }
    json.member("known_format", item.known_format);
    json.member("format", static_cast<std::int64_t>(item.format));
    json.member("folders_above", std::uint64_t{item.folders_above});
    if (!item.tensor_path.empty())
      json.member("tensor_path", escape_id(fs::absolute(item.tensor_path).string()));
    if (!item.tensor_dataset.empty()) json.member("tensor_dataset", item.tensor_dataset);
    json.end_object();
    file.append(json.text() + "\n");
  }
  file.commit();
}

std::vector<PlanItem> read_shard_items(const fs::path& folder, const StoreHeader& header) {
  const fs::path path = folder / "items.jsonl";
  const std::optional<std::string> text = content_if_exists(path);
  if (!text) refuse_items(path, "it is missing");
  std::vector<PlanItem> items;
  OpenArchives archives;
  std::string_view rest(*text);
  for (std::size_t end; (end = rest.find('\n')) != std::string_view::npos; rest.remove_prefix(end + 1)) {
    const JsonObject json(rest.substr(0, end), path.string());
    PlanItem& item = items.emplace_back();
    item.row = items.size() - 1;
    item.id = json.text("id").value_or("");
    if (item.row >= header.ids.size() || item.id != header.ids[item.row])
      refuse_items(path, fmt::format("line {} does not match the item of the plan", items.size()));
    item.path = unescape_id(json.text("path").value_or(""));
    if (const auto archive = json.text("archive"))
      item.packed = archives.find(unescape_id(*archive), unescape_id(json.text("inner").value_or("")),
                                  unescape_id(json.text("member").value_or("")));
    const auto known = json.members().find("known_format");
    item.known_format = known == json.members().end() || known->second != "false";
    const std::int64_t format = json.integer("format").value_or(0);
    if (format < 0 || format >= static_cast<std::int64_t>(mesh_formats().size()))
      refuse_items(path, fmt::format("line {} has the unknown format {}", items.size(), format));
    item.format = static_cast<MeshFormat>(format);
    item.folders_above = static_cast<std::uint32_t>(
        std::clamp<std::int64_t>(json.integer("folders_above").value_or(1), 0, 65535));
    item.tensor_path = unescape_id(json.text("tensor_path").value_or(""));
    item.tensor_dataset = json.text("tensor_dataset").value_or("");
  }
  if (items.size() != header.ids.size()) refuse_items(path, "it ends too early");
  return items;
}

void add_plan_command(Command& program, PlanOptions& options, RunOptionTexts& texts) {
  Command command = program.add_subcommand("plan", "Divide a run among many processes or machines");
  command.example("meander plan models/ -o store.h5 -n 2048 --shards 64 --emit slurm > job.sh",
                  "64 shards, and a script for `sbatch`");
  command.example(
      "meander plan models/ -o store.h5 -n 2048",
      "Shards of about five minutes; `meander run store.h5.run --shard 0/N` works on one, and `meander "
      "merge store.h5.run` joins them");
  add_store_options(command, options.run, texts);
  Command array = command.under("Array");
  array.add_option("--shards", options.shards, "Number of shards, or auto: by --per-shard-minutes")
      .show_default()
      .common();
  array
      .add_option("--per-shard-minutes", options.minutes_per_shard,
                  "Minutes that auto aims at per shard, on the threads of -j (default 1), 0.01 to 10000")
      .show_default()
      .range(0.01, 10000.0);
  array
      .add_option("--max-array", options.max_tasks,
                  "Maximum tasks of an array (Slurm: MaxArraySize); with more shards, each task does several")
      .show_default()
      .range(std::uint64_t{1}, std::uint64_t{4000001});
  array
      .add_option("--emit", options.emit,
                  "Print a script that runs the array with this program, by its absolute path")
      .common()
      .one_of(script_schedulers());
  Command running = command.under("Running");
  add_limit_options(running, options.run);
  add_older_store_options(running, options.run);
  add_progress_options(command.under("Report"), options.run);
  add_failures_option(command.under("Report"), options.allow_failures);
}

RunOptions planned_options(const RunArray& array, const StoreHeader& header, const Laboratory* laboratory) {
  CommandLine line("meander", "", "", "");
  Command program = line.program();
  PlanOptions options;
  RunOptionTexts texts;
  add_plan_command(program, options, texts);
  std::vector<std::string> arguments = array.arguments;
  arguments.insert(arguments.begin(), "meander");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  line.parse(static_cast<int>(pointers.size()), pointers.data());
  texts.folder = array.folder;
  resolve_run_options(options.run, texts, laboratory);
  choose_attribute_kinds(options.run, &*header.columns, {});
  options.run.sample.rows_only = !options.run.certify;
  if (options.run.parameters_json != header.parameters_json || header.method_version != store_method_version)
    throw RunError(
        RunError::Kind::unusable,
        fmt::format("the array was planned by another version of the program: {}",
                    header.method_version != store_method_version
                        ? fmt::format("its method version is {}, this one's {}", header.method_version,
                                      store_method_version)
                        : parameter_differences(header.parameters_json, options.run.parameters_json)));
  if (!options.run.reuse.empty()) options.run.reuse = (fs::path(array.folder) / options.run.reuse).string();
  return options.run;
}

std::string store_of_array(const std::string& path) {
  std::string folder = path;
  while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
  constexpr std::string_view suffix = ".run";
  if (!folder.ends_with(suffix) || !fs::exists(fs::path(folder) / "array.json")) return {};
  return folder.substr(0, folder.size() - suffix.size());
}

void write_shard_report(const std::string& store, std::size_t shard, const ShardReport& report) {
  const std::string text = json_object([&](JsonWriter& json) {
    json.member("rows", report.rows);
    json.member("failed", report.failed);
    json.member("seconds", report.seconds);
    json.member("threads", report.threads);
    json.member("ended_unix_time", report.ended_unix_time);
    json.member("host", report.host);
    json.member("build", report.build);
  });
  replace_file(report_path(store, shard), text + "\n", FullDisk::stops_run);
}

std::optional<ShardReport> read_shard_report(const std::string& store, std::size_t shard) {
  const fs::path path = report_path(store, shard);
  const std::optional<std::string> text = content_if_exists(path);
  if (!text) return std::nullopt;
  try {
    const JsonObject json(*text, path.string());
    ShardReport report;
    report.rows = static_cast<std::uint64_t>(json.integer("rows").value_or(0));
    report.failed = static_cast<std::uint64_t>(json.integer("failed").value_or(0));
    const auto seconds = json.members().find("seconds");
    if (seconds != json.members().end()) report.seconds = std::strtod(seconds->second.c_str(), nullptr);
    report.threads = static_cast<int>(json.integer("threads").value_or(1));
    report.ended_unix_time = json.integer("ended_unix_time").value_or(0);
    report.host = json.text("host").value_or("");
    report.build = json.text("build").value_or("");
    return report;
  } catch (const RunError&) {
    return std::nullopt;
  }
}

}  // namespace meander
