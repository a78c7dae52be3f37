// Retrying an item that was in flight when an earlier process died: alone, in a child process.
#pragma once

#include <functional>
#include <string>

#include "jobs/cli/jobs.h"
#include "pipeline/sampling_graph.h"

namespace meander {

struct LoneResult {
  bool crashed = false;  // the child itself died of SEGV, BUS, FPE, ILL or ABRT
  std::string reason;    // the signal and the stage
};

// Forks, runs the stages on the one item in the child and throws the result away: only whether the child
// survives counts. A child killed by anything else (SIGKILL by a user or by the system's memory killer) marks
// nothing. `leave` comes first in the child, to leave what it inherits: a lock that it held longer than its
// killed parent would refuse the run that continues. `hook` changes the stages. Must be called before this
// process starts any thread. Throws std::system_error when it cannot fork.
LoneResult try_item_alone(const PlanItem& item, const GraphParameters& parameters,
                          const std::function<void()>& leave, const StageHook& hook);

}  // namespace meander
