#include "jobs/cli/work_options.h"

#include <oneapi/tbb/info.h>

#include <algorithm>

#include "jobs/cli/units.h"

namespace meander {

void add_budget_options(Command& running, WorkOptions& options) {
  running.add_option("-j,--threads", options.threads, "Threads, up to 1024 (0: all available)")
      .show_default()
      .common()
      .range(0, 1024);
  running.add_option("--memory", options.memory, "Memory budget of the whole process").show_default().bytes();
  running.add_flag("--allow-oversize", options.allow_oversize,
                   "Process a model that exceeds the memory budget, on its own");
  running
      .add_option("--timeout", options.timeout,
                  "Time limit for work on one model, waiting excluded (ms, s, m, h); 0: none")
      .show_default()
      .seconds();
}

void add_progress_options(Command report, WorkOptions& options) {
  report
      .add_option("--progress", options.progress,
                  "Progress on standard error; auto: a bar on a terminal, plain lines otherwise")
      .show_default()
      .one_of({"auto", "bar", "plain", "json", "none"});
  report.add_flag("--json", options.json, "The summary as JSON on standard output");
}

void resolve_work_options(WorkOptions& options) {
  options.memory_bytes = parse_bytes(options.memory);
  options.timeout_seconds = parse_seconds(options.timeout);
  if (options.threads == 0) options.threads = std::max(1, oneapi::tbb::info::default_concurrency());
}

}  // namespace meander
