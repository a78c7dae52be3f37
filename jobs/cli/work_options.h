// The options of every command that works on many models: threads, memory, time and what it prints.
#pragma once

#include <cstdint>
#include <string>

#include "jobs/cli/command_line.h"

namespace meander {

struct WorkOptions {
  int threads = 0;                                      // 0: as many as the machine (or its cgroup) gives
  std::string memory = "4G", timeout = "120s";          // as they are given
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;  // the budget of the whole process
  std::uint64_t model_bytes = 0;                        // of memory_bytes, what memory_for_models leaves
  double timeout_seconds = 120;                         // for one model; 0: none
  bool allow_oversize = false, json = false;
  std::string progress = "auto";  // auto|bar|plain|json|none
};

// --threads, --memory, --allow-oversize and --timeout.
void add_budget_options(Command& running, WorkOptions& options);
// --progress and --json.
void add_progress_options(Command report, WorkOptions& options);

// Reads the memory and the time from their texts and chooses the threads. Throws UsageError.
void resolve_work_options(WorkOptions& options);

}  // namespace meander
