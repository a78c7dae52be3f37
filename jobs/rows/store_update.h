// A finished store and the inputs of today: what changed since it was made, and how it is brought up to date.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "jobs/rows/run_options.h"

namespace meander {

// A finished store beside the inputs of today. Rows are those of the store.
struct StoreComparison {
  std::vector<std::uint64_t> added;     // positions in the list of inputs: items that the store lacks
  std::vector<std::uint64_t> changed;   // rows whose input has other bytes than were sampled
  std::vector<std::uint64_t> vanished;  // rows without an input
  bool relabeled = false;               // a label, a split or the list of classes differs
};

// Compares by id. A file counts as changed when its size differs, or when it was modified at or after `since`
// and its SHA-256 differs; files that could not be opened count when they can be opened now. Cost: one stat
// an item, and the reading of files that were modified. Runs on all threads that oneTBB may use.
StoreComparison compare_with_inputs(const StoreReader& store, const std::vector<PlanItem>& items,
                                    const StoreHeader& header, std::chrono::system_clock::time_point since);

// A store that is to be made: its rows and where each comes from.
struct PlannedStore {
  RunPlan plan;
  std::vector<PlanItem> items;                     // one a row; its path is empty where no input has the id
  std::vector<std::optional<std::uint64_t>> kept;  // the row of an older store that is taken as it is
};

// What the plan of an update does again; empty for plans of other purposes.
std::optional<RetryOptions> retry_of(const RunPlan& plan);

// The plan that brings a store up to date: `header` is that of a new store of today's inputs. Rows whose
// input vanished stay, but for retry.vanished.
RunPlan plan_update(const StoreReader& store, const StoreHeader& header, const StoreComparison& compared,
                    const RetryOptions& retry);

// The rows of a plan: from the inputs by id, and from `store` (may be null) those that need not be done
// again.
PlannedStore planned_store(RunPlan plan, const std::vector<PlanItem>& items, const StoreReader* store,
                           const StoreComparison& compared, const RetryOptions& retry);

// Copies the kept rows into the run that makes the new store; rows that are there already are left alone.
// Decoding and encoding run in parallel. False when `stop` was set on the way.
bool copy_kept_rows(const StoreReader& store, const PlannedStore& planned, RunDirectory& directory,
                    const std::atomic<bool>& stop);

// When the unfinished run of a store was begun, by the clock of its file system.
std::chrono::system_clock::time_point run_begun(const std::string& store);

// The moment from which on a modified input may not be what a store holds: STORE.run.json has it; without
// it, the modification time of the store.
std::chrono::system_clock::time_point inputs_read_since(const std::string& store);

}  // namespace meander
