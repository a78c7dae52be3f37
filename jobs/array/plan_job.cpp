// meander plan divides a run among many processes.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <numeric>

#include "io/archive/model_bytes.h"
#include "io/json_writer.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/memory_budget.h"
#include "jobs/rows/run_header.h"
#include "jobs/rows/store_update.h"
#include "jobs/run/array_plan.h"
#include "jobs/run/array_script.h"
#include "kernels/core/parallel.h"
#include "pipeline/work_estimate.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

class PlanJob {
 public:
  PlanJob(PlanOptions& options, std::vector<std::string> arguments, const Laboratory* laboratory)
      : options_(options), run_(options.run), arguments_(std::move(arguments)), laboratory_(laboratory) {}

  int run() {
    const auto listed = std::chrono::system_clock::now() - std::chrono::seconds(2);
    const Inputs inputs = collect_run_inputs(run_);
    choose_attribute_kinds(run_, nullptr, inputs.items);
    const StoreHeader header = run_header(run_, inputs, laboratory_);
    check_run_outputs(run_, inputs);
    if (!run_.fresh && fs::exists(run_.store))
      throw UsageError(fmt::format(
          "`{}` exists: bring it up to date with `meander run`, or replace it with --fresh", run_.store));
    if (run_.fresh) discard_run(run_.store);
    if (read_run_plan(run_.store))
      throw UsageError(
          fmt::format("`{}.run` holds an unfinished run of one process: repeat the command that began it, or "
                      "discard it with --fresh",
                      run_.store));
    if (read_run_array(run_.store))
      throw UsageError(fmt::format(
          "`{}.run` is planned already: see `meander status`, or discard it with --fresh", run_.store));
    const std::vector<double> costs = costs_of(inputs.items);
    const std::size_t count = shards(costs);
    RunArray array{arguments_,
                   fs::current_path().string(),
                   std::chrono::nanoseconds(listed.time_since_epoch()).count(),
                   inputs.items.size(),
                   cut_into_shards(costs, count),
                   shards_per_task(count, options_.max_tasks)};
    const std::string script = script_of(array);
    create_run_array(run_.store, array, {header, RunPurpose::sample, inputs.root.string()},
                     [&](std::size_t s, const fs::path& folder) {
                       write_shard_items(
                           folder,
                           std::span(inputs.items).subspan(array.shards[s].begin, array.shards[s].rows()));
                     });
    if (options_.emit.empty())
      report(array, costs);
    else
      fmt::print("{}", script);
    return exit_code_of(inputs.notes.unread.empty() ? exit_done : exit_some_failed, options_.allow_failures);
  }

 private:
  std::vector<double> costs_of(const std::vector<PlanItem>& items) const {
    std::vector<double> costs(items.size());
    parallel_tasks(items.size(), [&](std::size_t i) {
      std::error_code none;
      const std::uint64_t bytes =
          items[i].packed ? items[i].packed.facts().bytes : fs::file_size(items[i].path, none);
      costs[i] = estimated_seconds(none ? 0 : bytes, run_.sample);
    });
    return costs;
  }

  std::size_t shards(std::span<const double> costs) const {
    if (options_.shards == "auto")
      return std::min(shards_of_minutes(costs, options_.minutes_per_shard, std::max(1, run_.threads)),
                      static_cast<std::size_t>(max_shards));
    const std::uint64_t count = number_in(options_.shards).value_or(0);
    if (count < 1 || count > max_shards)
      throw UsageError(fmt::format("--shards: `{}` is neither `auto` nor a number from 1 to {}",
                                   options_.shards, max_shards));
    return count;
  }

  // Made before anything is written, since the scheduler may not be able to name a path.
  std::string script_of(const RunArray& array) const {
    if (options_.emit.empty()) return {};
    return array_script(options_.emit, {running_program(), fs::absolute(run_.store), array.shards.size(),
                                        array.shards_per_task});
  }

  void report(const RunArray& array, std::span<const double> costs) const {
    const std::size_t count = array.shards.size();
    const std::uint64_t each = array.shards_per_task, tasks = (count + each - 1) / each;
    const double total = std::accumulate(costs.begin(), costs.end(), 0.0);
    if (run_.json) {
      fmt::print("{}\n", json_object([&](JsonWriter& json) {
                   json.member("run", run_.store + ".run");
                   json.member("rows", array.rows);
                   json.member("shards", std::uint64_t{count});
                   json.member("tasks", tasks);
                   json.member("shards_per_task", each);
                   json.member("array", fmt::format("0-{}", tasks - 1));
                   json.member("estimated_processor_seconds", total);
                   json.member("largest_shard_seconds", array.shards.front().cost);
                 }));
      return;
    }
    fmt::print("{}.run: {} models in {} shards, about {:.0f} processor seconds, the largest shard {:.1f}\n",
               run_.store, array.rows, count, total, array.shards.front().cost);
    fmt::print(
        "work on shard i:  meander run {}.run --shard i/{}    or as an array of tasks: --array=0-{}{}\n",
        run_.store, count, tasks - 1, each > 1 ? fmt::format(", {} shards each", each) : "");
    fmt::print("when all have ended with 0:  meander merge {}.run\n", run_.store);
  }

  PlanOptions& options_;
  RunOptions& run_;
  const std::vector<std::string> arguments_;
  const Laboratory* laboratory_;
};

}  // namespace

JobFunction add_plan_job(Command& program, const Laboratory* laboratory, std::vector<std::string> arguments) {
  auto options = std::make_shared<PlanOptions>();
  auto texts = std::make_shared<RunOptionTexts>();
  add_plan_command(program, *options, *texts);
  return [options, texts, laboratory, arguments = std::move(arguments)] {
    if (options->run.store.empty()) throw UsageError("--output is required");
    const int threads = options->run.threads;
    resolve_run_options(options->run, *texts, laboratory);
    options->run.threads = threads;  // those of a task, not of this command
    return PlanJob(*options, arguments, laboratory).run();
  };
}

}  // namespace meander
