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

// The options of `meander plan`: those of `meander run` that decide the rows, and how these are divided.
struct PlanOptions {
  RunOptions run;
  std::string shards = "auto";  // a number, or auto: as many as minutes_per_shard makes
  double minutes_per_shard = 5;
  std::uint64_t max_tasks = 1001;  // of an array; Slurm's default of MaxArraySize
  std::string emit;                // the scheduler to print a script for; empty: none
};

// Adds the subcommand with its options.
void add_plan_command(Command& program, PlanOptions& options, RunOptionTexts& texts);

// Estimated seconds of one processor for an item of this size; right within a factor of two or so, which is
// enough to divide work. `bytes`: of the file.
double estimated_seconds(std::uint64_t bytes, const SampleParameters& parameters);

// Divides rows of these costs into `shards` contiguous ranges of about equal cost, numbered by falling cost:
// an array of tasks works on them in the order of their numbers, and large ones last would keep everybody
// waiting. Ranges begin at multiples of a power of two, 256 at most, that leaves at least sixteen blocks a
// shard; where there are fewer rows than shards the last ones are empty. Pure. O(rows + shards log shards).
std::vector<ArrayShard> cut_into_shards(std::span<const double> costs, std::size_t shards);

// As many shards as make each take about `minutes` on `threads` processors; at least one.
std::size_t shards_of_minutes(std::span<const double> costs, double minutes, int threads);

// How many shards each of at most `max_tasks` tasks takes.
std::uint64_t shards_per_task(std::uint64_t shards, std::uint64_t max_tasks);

// The tasks that work on these shards, each once, ascending; task t on the shards (t + offset) K .. + K - 1.
// Shards that no such task has are left out.
std::vector<std::size_t> tasks_of_shards(std::span<const std::size_t> ascending,
                                         std::uint64_t shards_per_task, std::int64_t offset = 0);

// "3,7-9": numbers in the notation of job arrays. Beyond `max_bytes`, which one argument of a command may
// take, the shortest gaps are closed: what is done already ends at once when it is started again.
std::string array_expression(std::span<const std::size_t> ascending, std::size_t max_bytes = 64 << 10);

// items.jsonl in the folder of a shard: where the items are, one line each.
void write_shard_items(const std::filesystem::path& folder, std::span<const PlanItem> items);
// The items of a shard whose plan has these ids; archives are listed again. Throws RunError(unusable) when
// the file is damaged.
std::vector<PlanItem> read_shard_items(const std::filesystem::path& folder, const StoreHeader& header);

// The options that the array was planned with: its arguments, understood again. Throws RunError(unusable)
// when this program makes other parameters of them than the plan has.
RunOptions planned_options(const RunArray& array, const StoreHeader& header, const Laboratory* laboratory);

// The store of STORE.run, when `path` names such a folder that holds an array.
std::string store_of_array(const std::string& path);

// What is left beside the result of a shard for `meander status`.
struct ShardReport {
  std::uint64_t rows = 0, failed = 0;
  double seconds = 0;  // that the process took, from its start
  int threads = 1;
  std::int64_t ended_unix_time = 0;
  std::string host, build;  // build_text of run_report.h
};
void write_shard_report(const std::string& store, std::size_t shard, const ShardReport& report);
// Empty where there is none, or it is damaged: it is not worth an error.
std::optional<ShardReport> read_shard_report(const std::string& store, std::size_t shard);

}  // namespace meander
