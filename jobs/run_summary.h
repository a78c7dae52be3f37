// What a finished run prints and what it leaves beside the store.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "io/store/store.h"
#include "jobs/run_options.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// Counts over all rows of a store, those of earlier processes included.
struct StoreSummary {
  std::uint64_t rows = 0;
  std::array<std::uint64_t, status_names.size()> by_status{};
  std::array<std::uint64_t, method_names.size()> by_method{};  // of ok rows
  std::array<std::uint64_t, repair_names.size()> by_repair{};
  struct Failure {
    std::uint64_t row;
    std::string id;
    Status status;
    std::string reason;
  };
  std::vector<Failure> failures;
  std::uint64_t failed() const { return rows - by_status[0]; }
};

StoreSummary summarise(const StoreReader& store);

// The final table (or JSON) on standard output. Its first line of detail, and "notice" in JSON, is the
// attribute of --density or --tensor where no model has it.
void print_summary(const StoreSummary& summary, const RunOptions& options,
                   const std::map<std::string, std::uint64_t>& skipped, double seconds,
                   std::uint64_t done_now, const std::vector<NodeStatistics>& nodes);

// STORE.run.json: what the store itself must not hold (times, machine, threads). STORE.failed.txt: `# id:
// status: reason` and the path of every failed item, fit to be given back as @STORE.failed.txt; removed when
// nothing failed. Each is written whole or not at all; throws RunError when it cannot be.
void write_run_report(const RunOptions& options, const StoreSummary& summary, const GraphResult& result,
                      double seconds, const std::vector<NodeStatistics>& nodes);
void write_failed_list(const RunOptions& options, const StoreSummary& summary,
                       const std::vector<PlanItem>& items);

}  // namespace meander
