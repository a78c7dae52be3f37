// Making the rows of a planned store: from an older store, from items tried alone, from the flow graph.
#pragma once

#include <functional>
#include <memory>

#include "jobs/cli/jobs.h"
#include "jobs/rows/run_options.h"
#include "jobs/rows/run_summary.h"
#include "jobs/rows/store_update.h"

namespace meander {

struct ItemEstimate {
  std::uint64_t bytes = 0;     // of all files
  std::uint64_t unopened = 0;  // items whose file does not exist or cannot be opened
  std::string first_unopened;  // the id of the first one
};

// Sets the bytes and the work that every item will probably need, from header peeks in parallel; `more`, if
// given, says which bytes a command needs besides. Small files are not opened for it where the most that they
// can hold is nothing to `budget`, the bytes that models may take at once; 0 looks into all.
ItemEstimate estimate_items(std::vector<PlanItem>& items, const SampleParameters& parameters, int threads,
                            std::uint64_t budget,
                            const std::function<std::uint64_t(const MeshEstimate&)>& more = {});

// Says on standard error that most of the items cannot be opened, where that is so.
void warn_of_unopened(const ItemEstimate& estimate, std::size_t items);

// The sum of PlanItem::work.
double total_work(const std::vector<PlanItem>& items);

// The options as the graph takes them.
GraphParameters graph_parameters(const RunOptions& options);

struct PlannedRunParameters {
  const RunOptions& options;
  const StageHook& hook;
  ReuseLookup reuse;                    // may be empty
  const StoreReader* older = nullptr;   // where kept rows come from; null when none is kept
  std::function<void()> finished = {};  // see RunDirectory::finish
};

// Tries the items that were in flight when an earlier process died, each alone in a child process, and writes
// the rows of those that crash. It forks: call it before this process starts any thread.
void try_suspects(const PlannedStore& planned, const PlannedRunParameters& parameters);

// Makes or continues STORE.run/ and, when every row is done, renames the store to its name. Adds what was
// done to `outcome`. False when it was stopped first: standard error says why, the run can be continued.
bool make_planned_store(const PlannedStore& planned, const PlannedRunParameters& parameters,
                        RunOutcome& outcome);

}  // namespace meander
