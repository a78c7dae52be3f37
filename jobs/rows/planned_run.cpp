#include "jobs/rows/planned_run.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <optional>

#include "io/archive/model_bytes.h"
#include "jobs/cli/progress.h"
#include "jobs/cli/working_process.h"
#include "jobs/rows/lone_item.h"
#include "kernels/core/parallel.h"
#include "pipeline/memory_estimate.h"
#include "pipeline/work_estimate.h"

namespace meander {

namespace {

class StoreSink : public RowSink {
 public:
  explicit StoreSink(RunDirectory& directory) : directory_(directory) {}
  void begin(std::uint64_t row) override { directory_.begin_item(row); }
  void write(EncodedRow row) override { directory_.end_item(std::move(row)); }

 private:
  RunDirectory& directory_;
};

// Records in the run directory that nothing is in flight, however the graph ended.
class EndOfFlight {
 public:
  explicit EndOfFlight(RunDirectory& directory) : directory_(directory) {}
  ~EndOfFlight() {
    try {
      directory_.forget_begun();
    } catch (
        const RunError&) {  // for example a full disk: the next process retries a few items unnecessarily
    }
  }
  EndOfFlight(const EndOfFlight&) = delete;
  EndOfFlight& operator=(const EndOfFlight&) = delete;

 private:
  RunDirectory& directory_;
};

class PlannedRun {
 public:
  PlannedRun(const PlannedStore& planned, const PlannedRunParameters& parameters, RunOutcome& outcome)
      : planned_(planned),
        header_(planned.plan.header),
        options_(parameters.options),
        parameters_(parameters),
        outcome_(outcome),
        directory_(options_.store, planned.plan) {}

  bool run() {
    std::atomic<bool>& stop_requested = catch_stop_signals();
    set_allocator_limits(options_.memory_bytes);
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(options_.threads));
    count_earlier_rows();
    if (parameters_.older != nullptr &&
        !copy_kept_rows(*parameters_.older, planned_, directory_, stop_requested)) {
      stopped("");
      return false;
    }
    if (!run_graph(stop_requested)) return false;
    directory_.finish(parameters_.finished);
    return true;
  }

 private:
  // Rows that earlier processes made for this plan; those that are kept from an older store are not theirs.
  void count_earlier_rows() {
    for (std::uint64_t row = 0; row < planned_.items.size(); ++row) {
      if (planned_.kept[row] || !directory_.done(row)) continue;
      ++earlier_;
      earlier_failures_ += directory_.status(row) != Status::ok;
    }
  }

  bool run_graph(std::atomic<bool>& stop_requested) {
    std::vector<PlanItem> plan;
    for (const PlanItem& item : planned_.items)
      if (!directory_.done(item.row)) plan.push_back(item);
    if (!plan.empty() && earlier_failures_ > options_.max_failures) {
      stopped(too_many_failures(earlier_failures_));
      return false;
    }
    const auto start = std::chrono::steady_clock::now();
    GraphResult result;
    {
      const EndOfFlight end(directory_);
      std::optional<EmbreeDevice> device;
      if (casts_rays(options_.sample)) device.emplace();
      GraphParameters parameters = graph_parameters(options_);
      parameters.earlier_failures = earlier_failures_;
      warn_of_unopened(estimate_items(plan, parameters.sample, options_.threads, options_.model_bytes),
                       plan.size());
      GraphStages stages = sampling_stages(parameters.sample, device ? &*device : nullptr, parameters_.reuse);
      if (parameters_.hook) parameters_.hook(stages);
      StoreSink sink(directory_);
      Progress progress(progress_style(options_.progress), plan.size(), total_work(plan), options_.threads,
                        header_.samples);
      if (earlier_ > 0)
        progress.note(
            fmt::format("continuing: {} of {} models are done already", earlier_, earlier_ + plan.size()));
      result = run_sampling_graph(plan, parameters, stages, header_, sink, stop_requested, outcome_.nodes,
                                  [&](const FinishedItem& item) { progress.finished(item); });
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    outcome_.seconds += seconds.count();
    outcome_.done_now += result.written;
    outcome_.requeued += result.requeued;
    outcome_.peak_reserved_bytes = std::max(outcome_.peak_reserved_bytes, result.peak_reserved_bytes);
    outcome_.longest_wait_seconds = std::max(outcome_.longest_wait_seconds, result.longest_wait_seconds);
    if (!result.stopped) return true;
    stopped(result.too_many_failures ? too_many_failures(earlier_failures_ + result.failed) : "");
    return false;
  }

  std::string too_many_failures(std::uint64_t failed) const {
    return fmt::format(": {} models failed, more than --max-failures {}", failed, options_.max_failures);
  }

  void stopped(const std::string& why) {
    directory_.sync();
    const bool limited = !why.empty();
    fmt::print(stderr, "meander: stopped with {} of {} models done{}; the same command{}{} continues\n",
               directory_.done_count(), planned_.items.size(), why, options_.fresh ? " without --fresh" : "",
               limited ? " with a larger --max-failures" : "");
  }

  const PlannedStore& planned_;
  const StoreHeader& header_;
  const RunOptions& options_;
  const PlannedRunParameters& parameters_;
  RunOutcome& outcome_;
  RunDirectory directory_;
  std::uint64_t earlier_ = 0, earlier_failures_ = 0;
};

// What a file that is cheaper to read than to read twice can hold at most.
std::optional<MeshEstimate> most_in_small_file(const PlanItem& item) {
  constexpr std::uintmax_t small_file = 16 << 10;
  if (!item.known_format || item.path.empty() || item.packed) return std::nullopt;
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(item.path, error);
  if (error || bytes > small_file) return std::nullopt;
  const auto most = row_of(item.format).most;
  return most == nullptr ? std::nullopt : std::optional(most(bytes));
}

}  // namespace

GraphParameters graph_parameters(const RunOptions& options) {
  GraphParameters parameters;
  parameters.sample = options.sample;
  parameters.threads = options.threads;
  parameters.memory_bytes = options.model_bytes;
  parameters.allow_oversize = options.allow_oversize;
  parameters.timeout_seconds = options.timeout_seconds;
  parameters.max_failures = options.max_failures;
  return parameters;
}

ItemEstimate estimate_items(std::vector<PlanItem>& items, const SampleParameters& parameters, int threads,
                            std::uint64_t budget,
                            const std::function<std::uint64_t(const MeshEstimate&)>& more) {
  const MemoryEstimate bytes_of(parameters, threads);
  const auto needed = [&](const MeshEstimate& mesh) {
    return bytes_of(mesh) + (more ? more(mesh) : std::uint64_t{0});
  };
  // All such models that can be in flight, two a thread, take at most half of the budget.
  const std::uint64_t negligible = budget / (4 * static_cast<std::uint64_t>(threads));
  std::atomic<std::uint64_t> total{0}, unopened{0}, first{items.size()};
  const auto not_opened = [&](std::uint64_t i) {
    ++unopened;
    for (std::uint64_t known = first; i < known && !first.compare_exchange_weak(known, i);) {
    }
  };
  parallel_tasks(items.size(), [&](std::size_t i) {
    PlanItem& item = items[i];
    if (const auto most = most_in_small_file(item); most && needed(*most) <= negligible) {
      item.reserved_bytes = needed(*most);
      item.work = estimated_seconds(most->file_bytes, parameters);
      total += most->file_bytes;
      return;
    }
    MeshEstimate estimate;
    try {
      if (item.path.empty())
        not_opened(i);
      else if (item.known_format)
        estimate = peek_model(item);
    } catch (const ItemError&) {  // the read stage will say why
      not_opened(i);
    }
    item.reserved_bytes = needed(estimate);
    item.work = estimated_seconds(estimate, parameters);
    total += estimate.file_bytes;
  });
  return {total, unopened, first < items.size() ? items[first].id : ""};
}

void warn_of_unopened(const ItemEstimate& estimate, std::size_t items) {
  if (2 * estimate.unopened <= items) return;
  fmt::print(stderr,
             "meander: {} of {} inputs do not exist or cannot be opened, such as `{}`; relative paths of a "
             "list begin at the folder in which the command runs\n",
             estimate.unopened, items, estimate.first_unopened);
}

double total_work(const std::vector<PlanItem>& items) {
  double work = 0;
  for (const PlanItem& item : items) work += item.work;
  return work;
}

void try_suspects(const PlannedStore& planned, const PlannedRunParameters& parameters) {
  const RunOptions& options = parameters.options;
  RunDirectory directory(options.store, planned.plan);
  const GraphParameters graph = graph_parameters(options);
  std::vector<std::pair<std::uint64_t, std::string>> crashed;
  for (const std::uint64_t row : directory.suspects()) {
    if (planned.items[row].path.empty()) continue;
    LoneResult result = try_item_alone(
        planned.items[row], graph, [&] { directory.leave_lock_to_parent(); }, parameters.hook);
    if (result.crashed) crashed.emplace_back(row, std::move(result.reason));
  }
  // Writing a row may start threads, so the rows come after the last verdict.
  for (const auto& [row, reason] : crashed) {
    Row content;
    content.report.status = Status::crashed;
    content.report.reason = reason;
    directory.end_item(encode_row(planned.plan.header, row, content));
    if (options.progress != "none" && options.progress != "json")
      fmt::print(stderr, "{}: crashed: {}\n", planned.items[row].id, reason);
  }
  directory.forget_begun();
}

bool make_planned_store(const PlannedStore& planned, const PlannedRunParameters& parameters,
                        RunOutcome& outcome) {
  return PlannedRun(planned, parameters, outcome).run();
}

}  // namespace meander
