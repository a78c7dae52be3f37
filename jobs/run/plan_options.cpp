#include "jobs/run/plan_options.h"

#include "jobs/run/array_script.h"

namespace meander {

void add_plan_command(Command& program, PlanOptions& options, RunOptionTexts& texts) {
  Command command = program.add_subcommand("plan", "Divide a run among many processes or machines");
  add_store_options(command, options.run, texts);
  Command array = command.under("Array");
  array.add_option("--shards", options.shards, "How many tasks: a number, or auto").show_default();
  array
      .add_option("--per-shard-minutes", options.minutes_per_shard,
                  "What auto aims at, on the threads of -j (default 1), 0.01 to 10000")
      .show_default()
      .range(0.01, 10000.0);
  array
      .add_option(
          "--max-array", options.most_tasks,
          "Tasks that an array may have (Slurm: MaxArraySize); where there are more shards, each task "
          "does several")
      .show_default()
      .range(std::uint64_t{1}, std::uint64_t{4000001});
  array
      .add_option("--emit", options.emit,
                  "Print a script that runs the array with this program, by its absolute path")
      .one_of(script_schedulers());
  Command running = command.under("Running");
  add_budget_options(running, options.run, texts);
  add_older_store_options(running, options.run);
  add_progress_options(command.under("Report"), options.run);
}

}  // namespace meander
