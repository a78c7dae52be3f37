// How `meander plan` divides a run among many processes, and what each of them is told of its items.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/run_array.h"
#include "jobs/rows/run_options.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// Checks everything that the run writes (check_run_outputs) against its inputs and files of labels.
void check_run_outputs(const RunOptions& options, const Inputs& inputs);

// The options of `meander plan`: those of `meander run` that decide the rows, and how these are divided.
struct PlanOptions {
  RunOptions run;
  std::string shards = "auto";  // a number, or auto: as many as minutes_per_shard makes
  double minutes_per_shard = 5;
  std::uint64_t max_tasks = 1001;  // of an array; Slurm's default of MaxArraySize
  bool allow_failures = false;     // folders that cannot be read
  std::string emit;                // the scheduler to print a script for; empty: none
};

// Adds the subcommand with its options.
void add_plan_command(Command& program, PlanOptions& options, RunOptionTexts& texts);

// Divides rows of these costs into `shards` contiguous ranges of about equal cost, numbered by falling cost:
// an array of tasks works on them in the order of their numbers, and would wait for large ones at its end.
// Ranges begin at multiples of a power of two of at most 256 that leaves at least sixteen blocks per shard.
// With fewer rows than shards the last shards are empty. Pure. O(rows + shards log shards).
std::vector<ArrayShard> cut_into_shards(std::span<const double> costs, std::size_t shards);

// The number of shards, at least one, for which each takes about `minutes` on `threads` processors.
std::size_t shards_of_minutes(std::span<const double> costs, double minutes, int threads);

// The number of shards that each of at most `max_tasks` tasks takes.
std::uint64_t shards_per_task(std::uint64_t shards, std::uint64_t max_tasks);

// The tasks that work on these shards, each once, ascending: with K shards per task, task t works on the
// shards (t + offset) K to (t + offset) K + K - 1. Shards without a task are left out.
std::vector<std::size_t> tasks_of_shards(std::span<const std::size_t> ascending,
                                         std::uint64_t shards_per_task, std::int64_t offset = 0);

// Numbers in the notation of job arrays, "3,7-9". If that is longer than `max_bytes`, which fits into an
// argument of a command, the shortest gaps are closed: a finished task that is started again ends at once.
std::string array_expression(std::span<const std::size_t> ascending, std::size_t max_bytes = 64 << 10);

// Writes items.jsonl into the folder of a shard: one line per item with the place of its file.
void write_shard_items(const std::filesystem::path& folder, std::span<const PlanItem> items);
// Reads the items of a shard whose plan has the ids of `header`; archives are listed again. Throws
// RunError(unusable) when the file is damaged.
std::vector<PlanItem> read_shard_items(const std::filesystem::path& folder, const StoreHeader& header);

// The options that the array was planned with: its arguments are parsed again. Throws RunError(unusable) when
// this program turns them into other parameters than those of the plan.
RunOptions planned_options(const RunArray& array, const StoreHeader& header, const Laboratory* laboratory);

// The STORE of `path` if that is a folder STORE.run that holds an array; else "".
std::string store_of_array(const std::string& path);

// The report that stands beside the result of a shard, for `meander status`.
struct ShardReport {
  std::uint64_t rows = 0, failed = 0;
  double seconds = 0;  // since the start of the process
  int threads = 1;
  std::int64_t ended_unix_time = 0;
  std::string host, build;  // build_text of run_report.h
};
void write_shard_report(const std::string& store, std::size_t shard, const ShardReport& report);
// Empty if the report is missing or damaged, which is not worth an error.
std::optional<ShardReport> read_shard_report(const std::string& store, std::size_t shard);

}  // namespace meander
