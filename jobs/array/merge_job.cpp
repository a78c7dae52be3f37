// meander merge joins the shards of an array into its store, or finished stores into a new one.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "jobs/cli/allow_failures.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/working_process.h"
#include "jobs/inputs/input_options.h"
#include "jobs/inputs/run_report.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/run_options.h"
#include "jobs/rows/run_summary.h"
#include "jobs/rows/store_update.h"
#include "jobs/run/array_plan.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct MergeOptions {
  std::vector<std::string> inputs;
  std::string output;
  bool fresh = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
  std::string pack_size;  // bytes with a unit; empty: one file
};

// Options for the summary of a store that this process has not made.
RunOptions options_of(const std::string& path, const StoreReader& store, const MergeOptions& merging) {
  RunOptions options;
  options.store = path;
  options.json = merging.json;
  options.sample.samples = store.samples();
  return options;
}

// Warns of rows by several builds, which may differ where docs/STORE.md says so.
void note_builds(const std::set<std::string>& builds) {
  if (builds.size() < 2) return;
  fmt::print(stderr,
             "meander: {} builds made these rows, which may differ where docs/STORE.md says so (Builds):\n",
             builds.size());
  for (const std::string& build : builds) fmt::print(stderr, "  {}\n", build);
}

// ---- The shards of an array -------------------------------------------------------------------------------

// The paths of the inputs of failed rows, by row.
std::map<std::uint64_t, fs::path> failed_paths(const std::string& store, const RunArray& array) {
  std::map<std::uint64_t, fs::path> paths;
  for (std::size_t s = 0; s < array.shards.size(); ++s) {
    const ArrayShard& shard = array.shards[s];
    const auto report = read_shard_report(store, s);
    if (shard.rows() == 0 || (report && report->failed == 0)) continue;
    const std::vector<PlanItem> items =
        read_shard_items(shard_folder(store, s), read_shard_plan(store, s).header);
    const StoreReader rows(shard_store(store, s), StoreCheck::none);
    for (std::uint64_t row = 0; row < items.size(); ++row)
      if (rows.report(row).status != Status::ok) paths[shard.begin + row] = items[row].path;
  }
  return paths;
}

std::uint64_t pack_rows_of(const MergeOptions& options, const StoreHeader& header) {
  return options.pack_size.empty() ? 0 : rows_of_pack(header, parse_bytes(options.pack_size));
}

int merge_array(const std::string& store, const MergeOptions& merging, const Laboratory* laboratory) {
  const RunArray array = *read_run_array(store);
  if (const std::vector<std::size_t> missing = missing_shards(store, array); !missing.empty()) {
    fmt::print(stderr, "meander: {} of {} shards of {}.run are not done: --array={}\n", missing.size(),
               array.shards.size(), store, array_expression(tasks_of_shards(missing, array.shards_per_task)));
    return exit_stopped;
  }
  RunPlan plan;
  for (std::size_t s = 0; s < array.shards.size() && plan.header.ids.empty(); ++s)
    plan = read_shard_plan(store, s);
  RunOptions options = planned_options(array, plan.header, laboratory);
  options.store = store;
  options.json = merging.json;
  const std::map<std::uint64_t, fs::path> paths = failed_paths(store, array);
  RunOutcome outcome;
  outcome.root = plan.root;
  outcome.inputs_read_since_unix_ns = array.inputs_listed_unix_ns;
  outcome.builds.clear();
  for (std::size_t s = 0; s < array.shards.size(); ++s)
    if (const auto report = read_shard_report(store, s)) {
      outcome.seconds += report->seconds;
      if (!report->build.empty()) outcome.builds.insert(report->build);
    }
  outcome.done_now = array.rows;
  merge_run_array(store, array, pack_rows_of(merging, plan.header), [&] {
    outcome.summary = summarize(StoreReader(store, StoreCheck::none), true);
    write_run_report(options, outcome);
    write_failed_list(options, outcome.summary, [&](std::uint64_t row) {
      const auto path = paths.find(row);
      return path == paths.end() ? fs::path() : path->second;
    });
  });
  note_builds(outcome.builds);
  print_summary(outcome, options);
  return outcome.exit_code();
}

// ---- Finished stores --------------------------------------------------------------------------------------

class StoreMerge {
 public:
  explicit StoreMerge(const MergeOptions& options) : options_(options) {}

  int run() {
    const std::vector<fs::path> read(options_.inputs.begin(), options_.inputs.end());
    check_run_outputs(options_.output, options_.fresh, read);
    if (!options_.fresh) refuse_finished_store(options_.output, RunPurpose::merge);
    if (options_.fresh) discard_run(options_.output);
    for (const std::string& path : options_.inputs)
      stores_.push_back(std::make_unique<StoreReader>(path, options_.check));
    const RunPlan plan = join();
    const std::atomic<bool>& stop = catch_stop_signals();
    RunDirectory directory(options_.output, plan);
    for (std::size_t s = 0; s < stores_.size(); ++s) {
      PlannedStore planned{plan, {}, std::vector<std::optional<std::uint64_t>>(plan.header.ids.size())};
      for (std::size_t row = 0; row < source_.size(); ++row)
        if (source_[row].first == s) planned.kept[row] = source_[row].second;
      if (!copy_kept_rows(*stores_[s], planned, directory, stop)) {
        directory.sync();
        fmt::print(stderr, "meander: stopped with {} of {} rows merged; the same command continues\n",
                   directory.done_count(), plan.header.ids.size());
        return exit_stopped;
      }
    }
    RunOutcome outcome;
    RunOptions options;
    directory.finish([&] {
      const StoreReader store(options_.output, StoreCheck::none);
      options = options_of(options_.output, store, options_);
      outcome.summary = summarize(store, true);
      write_reports(options, outcome);
    });
    note_builds(outcome.builds);
    print_summary(outcome, options);
    return outcome.exit_code();
  }

 private:
  // Writes the reports of a run. A store keeps no paths, so the list of failed items has only their ids.
  void write_reports(const RunOptions& options, RunOutcome& outcome) const {
    auto since = inputs_read_since(options_.inputs.front());
    for (const std::string& path : options_.inputs) since = std::min(since, inputs_read_since(path));
    outcome.inputs_read_since_unix_ns = std::chrono::nanoseconds(since.time_since_epoch()).count();
    outcome.root = common_root();
    outcome.builds.clear();
    for (const std::string& path : options_.inputs) outcome.builds.merge(read_run_report(path).builds);
    write_run_report(options, outcome);
    write_failed_list(options, outcome.summary, [](std::uint64_t) { return fs::path(); });
  }

  // The root of the ids of lists in all stores; empty when they differ.
  std::string common_root() const {
    const std::string root = remembered_root(options_.inputs.front());
    const bool is_common =
        std::all_of(options_.inputs.begin(), options_.inputs.end(),
                    [&](const std::string& path) { return remembered_root(path) == root; });
    return is_common ? root : std::string();
  }

  // Plans the rows of all stores, by id, and notes the source of each.
  RunPlan join() {
    StoreHeader header = stores_.front()->header();
    std::set<std::string> names;
    std::map<std::string, std::pair<std::size_t, std::uint64_t>> rows;
    bool splits = false;
    for (std::size_t s = 0; s < stores_.size(); ++s) {
      const StoreReader& store = *stores_[s];
      if (const std::string otherwise = parameter_mismatch(store, header); !otherwise.empty())
        throw UsageError(fmt::format("`{}` was made with other parameters than `{}`: {}", options_.inputs[s],
                                     options_.inputs.front(), otherwise));
      names.insert(store.label_names().begin(), store.label_names().end());
      splits = splits || !store.header().splits.empty();
      for (std::uint64_t row = 0; row < store.rows(); ++row) {
        const auto [at, added] = rows.try_emplace(store.id(row), s, row);
        if (!added)
          throw UsageError(fmt::format("the item `{}` is in both `{}` and `{}`: ids must be unique",
                                       at->first, options_.inputs[at->second.first], options_.inputs[s]));
      }
    }
    header.label_names.assign(names.begin(), names.end());
    header.ids.clear();
    header.labels.clear();
    header.splits.clear();
    for (const auto& [id, place] : rows) {
      const StoreReader& store = *stores_[place.first];
      const std::int32_t label = store.label(place.second);
      const auto name =
          label < 0 ? names.end() : names.find(store.label_names()[static_cast<std::size_t>(label)]);
      header.ids.push_back(id);
      header.labels.push_back(label < 0 ? -1 : static_cast<std::int32_t>(std::distance(names.begin(), name)));
      if (splits) header.splits.push_back(store.split(place.second));
      source_.push_back(place);
    }
    return {header, RunPurpose::merge, {}};
  }

  const MergeOptions& options_;
  std::vector<std::unique_ptr<StoreReader>> stores_;
  std::vector<std::pair<std::size_t, std::uint64_t>> source_;  // store and row, by row of the result
};

int merge(const MergeOptions& options, const Laboratory* laboratory) {
  if (options.inputs.size() == 1 && options.output.empty()) {
    const std::string& path = options.inputs.front();
    if (const std::string store = store_of_array(path); !store.empty())
      return merge_array(store, options, laboratory);
    const std::string store = path.ends_with(".run") ? path.substr(0, path.size() - 4) : path;
    if (!fs::exists(store + ".run") && fs::is_regular_file(store)) {
      tidy_store(store);
      if (!options.json) fmt::print("{} is merged already\n", store);
      const StoreReader reader(store, StoreCheck::none);
      RunOutcome outcome;
      outcome.summary = summarize(reader, false);
      print_summary(outcome, options_of(store, reader, options));
      return outcome.exit_code();
    }
    throw UsageError(fmt::format("`{}` is not a run that `meander plan` made", path));
  }
  if (!options.pack_size.empty())
    throw UsageError(
        "--pack-size applies to the store of an array (STORE.run); finished stores are merged into one file");
  for (const std::string& path : options.inputs)
    if (!store_of_array(path).empty())
      throw UsageError(fmt::format(
          "`{0}` holds the shards of an array: make its store with `meander merge {0}` first", path));
  if (options.output.empty()) throw UsageError("several stores are merged into a new one: name it with -o");
  return StoreMerge(options).run();
}

}  // namespace

JobFunction add_merge_job(Command& program, const Laboratory* laboratory) {
  Command command =
      program.add_subcommand("merge", "Join the shards of an array, or finished stores, into one store");
  command.example("meander merge store.h5.run", "The shards of `meander plan models/ -o store.h5`");
  command.example("meander merge chairs.h5 tables.h5 -o furniture.h5",
                  "Finished stores that were made with the same parameters");
  auto options = std::make_shared<MergeOptions>();
  command
      .add_option("STORE", options->inputs, "STORE.run of `meander plan`, or stores of the same parameters")
      .required();
  command.add_option("-o,--output", options->output, "The store to write, for finished stores");
  command
      .add_option("--pack-size", options->pack_size,
                  "Write a store larger than this (100G, say; before compression, without ids) as packs "
                  "of at most this size, of 4,096 rows or more, and an index; for STORE.run")
      .bytes();
  command.add_flag("--fresh", options->fresh, "Replace a store of this name");
  add_trust_option(command, options->check);
  command.add_flag("--json", options->json, "The summary as JSON on standard output");
  return with_failures_option(command, [options, laboratory] { return merge(*options, laboratory); });
}

}  // namespace meander
