// meander run STORE.run: one task of an array.
#pragma once

#include "jobs/cli/jobs.h"
#include "jobs/rows/run_options.h"

namespace meander {

// Works on the shards of the task that `which`, or the environment, names. `given`: what the command line
// says of threads, memory and progress; `command` knows which options those were, and every other one but
// `which` is an error. Returns exit_done when all rows of the shards are recorded, failed ones included,
// exit_stopped when the same command is to be called again.
int run_shards(const RunOptions& given, const ShardOptions& which, const Command& command,
               const Laboratory* laboratory, const StageHook& hook);

// The number of the task that a scheduler started, and the variable that said so; empty where none did.
struct TaskNumber {
  std::uint64_t number = 0;
  std::string variable;
};
TaskNumber task_of_environment();

}  // namespace meander
