#include "jobs/cli/allow_failures.h"

#include <memory>
#include <utility>

#include "jobs/cli/exit_status.h"

namespace meander {

void add_failures_option(Command command, bool& allowed) {
  command.add_flag("--allow-failures", allowed,
                   "End with 0 instead of 3 when items failed, for scripts that stop at errors (set -e)");
}

int exit_code_of(int status, bool allowed) {
  return allowed && status == exit_some_failed ? static_cast<int>(exit_done) : status;
}

JobFunction with_failures_option(Command command, JobFunction job) {
  const auto allowed = std::make_shared<bool>(false);
  add_failures_option(std::move(command), *allowed);
  return [allowed, job = std::move(job)] { return exit_code_of(job(), *allowed); };
}

}  // namespace meander
