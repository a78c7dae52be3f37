// The options of `meander plan`: those of `meander run` that decide the rows, and how they are divided.
#pragma once

#include <cstdint>
#include <string>

#include "jobs/rows/run_options.h"

namespace meander {

struct PlanOptions {
  RunOptions run;
  std::string shards = "auto";  // a number, or auto: of minutes_per_shard
  double minutes_per_shard = 5;
  std::uint64_t most_tasks = 1001;  // of an array: MaxArraySize, where Slurm's administrator left it alone
  std::string emit;                 // the scheduler of a script on standard output; empty: none
};

// Adds the subcommand with its options.
void add_plan_command(Command& program, PlanOptions& options, RunOptionTexts& texts);

}  // namespace meander
