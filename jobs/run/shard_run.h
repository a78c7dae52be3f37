// meander run STORE.run works on one task of an array.
#pragma once

#include "jobs/cli/jobs.h"
#include "jobs/rows/run_options.h"

namespace meander {

// Works on the shards of the task that `which` or the environment names. `given` has the threads, memory and
// progress of the command line; any other option of `command`, except those of `which`, is an error. Returns
// exit_done when all rows of the shards are recorded, failed ones included, and exit_stopped when the command
// has to be repeated.
int run_shards(const RunOptions& given, const ShardOptions& which, const Command& command,
               const Laboratory* laboratory, const StageHook& hook);

// The number of the task that a scheduler started, and the variable that has it; empty without a scheduler.
struct TaskNumber {
  std::uint64_t number = 0;
  std::string variable;
};
TaskNumber task_of_environment();

}  // namespace meander
