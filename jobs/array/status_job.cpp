// meander status shows the progress of an array.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>
#include <vector>

#include "io/file/folder_lock.h"
#include "io/json_writer.h"
#include "io/store/run_directory.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/usage_error.h"
#include "jobs/rows/run_options.h"
#include "jobs/rows/run_summary.h"
#include "jobs/run/array_plan.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct StatusOptions {
  std::string run;
  bool array = false, json = false;
  int offset = 0;                   // as given to the tasks
  std::uint64_t shards_a_task = 0;  // 0: as planned
};

// The shards in one state, and their rows.
struct ShardList {
  std::vector<std::size_t> shards;
  std::uint64_t rows = 0, rows_done = 0;
};

struct ArrayStatus {
  std::uint64_t rows_done = 0, failed = 0;
  ShardList done, in_work, interrupted, waiting;
  std::vector<std::size_t> missing;
  double cost = 0, cost_done = 0;
  double seconds = 0, reported_cost = 0;  // of the shards with a report
};

// The list of a shard. Its lock shows whether a process works on it: of this machine, or of one that shares
// locks.
ShardList ArrayStatus::*list_of(const std::string& store, std::size_t number, const ArrayShard& shard) {
  if (shard.rows() == 0 || fs::exists(shard_store(store, number))) return &ArrayStatus::done;
  const LockState lock = lock_state(shard_folder(store, number), "lock");
  if (lock == LockState::absent) return &ArrayStatus::waiting;
  return lock == LockState::held ? &ArrayStatus::in_work : &ArrayStatus::interrupted;
}

ArrayStatus status_of(const std::string& store, const RunArray& array) {
  ArrayStatus status;
  for (std::size_t s = 0; s < array.shards.size(); ++s) {
    const ArrayShard& shard = array.shards[s];
    status.cost += shard.cost;
    const auto member = list_of(store, s, shard);
    ShardList& list = status.*member;
    list.shards.push_back(s);
    list.rows += shard.rows();
    if (member != &ArrayStatus::done) {
      status.missing.push_back(s);
      if (member == &ArrayStatus::waiting) continue;
      const RecordedRows recorded = recorded_rows(shard_store(store, s), shard.rows());
      list.rows_done += recorded.done;
      status.rows_done += recorded.done;
      status.failed += recorded.failed;
      status.cost_done += shard.cost * static_cast<double>(recorded.done) / static_cast<double>(shard.rows());
      continue;
    }
    status.rows_done += shard.rows();
    status.cost_done += shard.cost;
    if (const auto report = read_shard_report(store, s)) {
      status.failed += report->failed;
      status.seconds += report->seconds;
      status.reported_cost += shard.cost;
    }
  }
  return status;
}

// The remaining time of the tasks at work, or of one if there are none; negative before the first report.
double seconds_left(const ArrayStatus& status) {
  if (status.seconds <= 0 || status.reported_cost <= 0) return -1;
  const double tasks = static_cast<double>(std::max<std::size_t>(1, status.in_work.shards.size()));
  return (status.cost - status.cost_done) * status.seconds / status.reported_cost / tasks;
}

// The tasks that have to be started again.
std::string missing_tasks(const StatusOptions& options, const RunArray& array, const ArrayStatus& status) {
  const std::uint64_t each = options.shards_a_task == 0 ? array.shards_per_task : options.shards_a_task;
  return array_expression(tasks_of_shards(status.missing, each, options.offset));
}

void print_json(const StatusOptions& options, const RunArray& array, const ArrayStatus& status) {
  fmt::print("{}\n", json_object([&](JsonWriter& json) {
               json.member("merged", false);
               json.member("rows", array.rows);
               json.member("rows_done", status.rows_done);
               json.member("failed", status.failed);
               json.member("shards", std::uint64_t{array.shards.size()});
               json.member("shards_done", std::uint64_t{status.done.shards.size()});
               json.member("shards_in_work", std::uint64_t{status.in_work.shards.size()});
               json.member("shards_interrupted", std::uint64_t{status.interrupted.shards.size()});
               json.member("shards_per_task", array.shards_per_task);
               json.member("array", missing_tasks(options, array, status));
               if (const double left = seconds_left(status); left >= 0) json.member("seconds_left", left);
             }));
}

void print_status(const std::string& store, const StatusOptions& options, const RunArray& array,
                  const ArrayStatus& status) {
  fmt::print("{}.run: {} of {} shards and {} of {} models done, {} failed\n", store,
             status.done.shards.size(), array.shards.size(), status.rows_done, array.rows, status.failed);
  const auto list = [](const char* what, const ShardList& shards) {
    if (shards.shards.empty()) return;
    fmt::print("  {:<12}{:>7}  with {} of {} models done: {}\n", what, shards.shards.size(), shards.rows_done,
               shards.rows, array_expression(shards.shards));
  };
  list("in work", status.in_work);
  list("interrupted", status.interrupted);
  list("waiting", status.waiting);
  if (array.shards_per_task > 1 && !status.missing.empty())
    fmt::print("  tasks of {} shards each to start again: {}\n", array.shards_per_task,
               missing_tasks(options, array, status));
  if (status.missing.empty()) {
    fmt::print("  next: meander merge {}.run\n", store);
  } else if (const double left = seconds_left(status); left >= 0) {
    const std::size_t tasks = std::max<std::size_t>(1, status.in_work.shards.size());
    fmt::print("  about {:.0f} s left for {} task{}\n", std::ceil(left), tasks, tasks == 1 ? "" : "s");
  }
}

// A store without a folder of a run is whole: an array that was merged.
void print_merged(const std::string& path, const StatusOptions& options) {
  const StoreSummary summary = summarize(StoreReader(path, StoreCheck::none), false);
  if (options.array)
    fmt::print("\n");
  else if (options.json)
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("merged", true);
                 json.member("rows", summary.rows);
                 json.member("rows_done", summary.rows);
                 json.member("failed", summary.failed());
                 json.member("array", "");
               }));
  else
    fmt::print("{} is merged: {} models, {} failed; no array is at work on it\n", path, summary.rows,
               summary.failed());
}

int print(const StatusOptions& options) {
  if (!options.array && !options.json && (options.offset != 0 || options.shards_a_task != 0))
    throw UsageError("--shard-offset and --shards-per-task apply to --array and --json");
  const std::string store = store_of_array(options.run);
  if (store.empty()) {
    const std::string& path = options.run;
    const std::string merged = path.ends_with(".run") ? path.substr(0, path.size() - 4) : path;
    if (!fs::exists(merged + ".run") && fs::is_regular_file(merged)) {
      print_merged(merged, options);
      return exit_done;
    }
    throw UsageError(fmt::format("`{}` is not a run that `meander plan` made", path));
  }
  const RunArray array = *read_run_array(store);
  const ArrayStatus status = status_of(store, array);
  if (options.array)
    fmt::print("{}\n", missing_tasks(options, array, status));
  else if (options.json)
    print_json(options, array, status);
  else
    print_status(store, options, array, status);
  return status.missing.empty() ? exit_done : exit_stopped;
}

}  // namespace

JobFunction add_status_job(Command& program) {
  Command command = program.add_subcommand("status", "Show the progress of an array of `meander plan`");
  command.example("meander status store.h5.run", "How many shards are done, and which failed");
  command.example("meander status store.h5.run --array",
                  "The tasks to start again, for the scheduler's --array");
  auto options = std::make_shared<StatusOptions>();
  command.add_option("STORE.run", options->run, "The folder that `meander plan` made").required();
  command.add_flag("--array", options->array, "Print the tasks to start again, such as 3,7-9");
  add_task_options(command, options->offset, options->shards_a_task);
  command.add_flag("--json", options->json, "The status as JSON");
  return [options] { return print(*options); };
}

}  // namespace meander
