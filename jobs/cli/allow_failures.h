// --allow-failures, of the commands that can end with exit_some_failed.
#pragma once

#include "jobs/cli/command_line.h"
#include "jobs/cli/jobs.h"

namespace meander {

void add_failures_option(Command command, bool& allowed);
// The exit code of a command: exit_done instead of exit_some_failed where failures are allowed.
int exit_code_of(int status, bool allowed);

// The job with the option.
JobFunction with_failures_option(Command command, JobFunction job);

}  // namespace meander
