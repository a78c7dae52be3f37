// meander describe adds descriptors to a finished store without sampling again.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "io/json_writer.h"
#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/progress.h"
#include "jobs/cli/working_process.h"
#include "jobs/describe/describe_options.h"
#include "jobs/describe/describe_stages.h"
#include "jobs/rows/described_meshes.h"
#include "jobs/rows/descriptor_choice.h"
#include "jobs/rows/lone_item.h"
#include "jobs/rows/memory_budget.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

// Why rows could not be described completely: the first reason of each row, whose status is ok where nothing
// failed but the model has no such descriptor. `add` and `of` may be called from many threads.
class RowProblems {
 public:
  void add(std::uint64_t row, Failure problem) {
    const std::lock_guard lock(mutex_);
    by_row_.try_emplace(row, std::move(problem));
  }
  std::optional<Failure> of(std::uint64_t row) const {
    const std::lock_guard lock(mutex_);
    const auto at = by_row_.find(row);
    return at == by_row_.end() ? std::nullopt : std::optional(at->second);
  }
  // Called once no thread adds any more.
  const std::map<std::uint64_t, Failure>& all() const { return by_row_; }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint64_t, Failure> by_row_;
};

struct DescribeSummary {
  std::string store;
  std::span<const std::string> ids;
  std::span<const Descriptor> descriptors;
  const std::map<std::uint64_t, Failure>& problems;  // by row
  std::uint64_t not_ok = 0;                          // rows without samples
  double seconds = 0;
};

// With the status ok nothing failed: the model has no such descriptor.
std::string_view kind_of(const Failure& problem) {
  return problem.status == Status::ok ? "incomplete" : name_of(problem.status);
}

// On standard output, as text or as one JSON object.
void print_summary(const DescribeSummary& summary, bool as_json) {
  std::string names;
  for (const Descriptor descriptor : summary.descriptors)
    names += (names.empty() ? "" : ",") + std::string(name_of(descriptor));
  const std::uint64_t described = summary.ids.size() - summary.not_ok - summary.problems.size();
  if (as_json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("store", summary.store);
                 json.member("descriptors", names);
                 json.member("rows", std::uint64_t{summary.ids.size()});
                 json.member("described", described);
                 json.member("not_ok", summary.not_ok);
                 json.member("seconds", summary.seconds);
                 json.key("problems");
                 json.begin_array();
                 for (const auto& [row, problem] : summary.problems) {
                   json.begin_object();
                   json.member("id", summary.ids[row]);
                   json.member("status", kind_of(problem));
                   json.member("reason", problem.reason);
                   json.end_object();
                 }
                 json.end_array();
               }));
    return;
  }
  fmt::print("{}: {} rows described with {} in {:.2f} s", summary.store, described, names, summary.seconds);
  if (summary.not_ok > 0) fmt::print(", {} without samples", summary.not_ok);
  fmt::print("\n");
  if (summary.problems.empty()) return;
  fmt::print("{} {} could not be described completely; missing values are NaN:\n", summary.problems.size(),
             summary.problems.size() == 1 ? "row" : "rows");
  constexpr std::size_t max_shown = 100;
  std::size_t shown = 0;
  for (const auto& [row, problem] : summary.problems) {
    if (shown++ == max_shown) break;
    fmt::print("  {}: {}: {}\n", summary.ids[row], kind_of(problem), problem.reason);
  }
  if (summary.problems.size() > max_shown)
    fmt::print("  and {} more (--json lists all)\n", summary.problems.size() - max_shown);
}

// Adds the rows that an earlier start of the job left without their descriptors: those of `rows` (ascending)
// that are not described.
void add_earlier_problems(const StoreReader& store, const Describer& describer,
                          std::span<const std::uint64_t> rows, RowProblems& problems) {
  if (rows.empty()) return;
  for (const DescriptorSchema& schema : store.descriptors()) {
    if (schema.group != "descriptors" || !describer.makes(schema.name)) continue;
    constexpr std::uint64_t block = 4096;
    for (auto row = rows.begin(); row != rows.end();) {
      const std::uint64_t begin = *row, count = std::min(block, store.rows() - begin);
      const std::vector<float> values = store.read_descriptor(schema.name, begin, count);
      for (; row != rows.end() && *row < begin + count; ++row)
        if (!is_described(schema, std::span(values).subspan((*row - begin) * schema.width, schema.width)))
          problems.add(*row, {Status::ok, fmt::format("`{}` could not be made before the job was interrupted",
                                                      schema.name)});
    }
  }
}

// Rows are described in two rounds: first with their meshes; those that failed, again without.
enum class Round { with_meshes, with_points };

class DescribeJob {
 public:
  explicit DescribeJob(DescribeOptions& options) : options_(options) {}

  int run() {
    store_ = open_described_store(options_);
    output_ = described_output(options_);
    if (store_->rows() == 0) {
      fmt::print("shard {} of `{}` has no rows: there is nothing to describe, and no store is made\n",
                 options_.shard, options_.store);
      return exit_done;
    }
    header_ = described_header(*store_, options_);
    describer_ = make_describer(header_, options_.describe);
    if (describer_.uses_meshes())
      meshes_ = DescribedMeshes(options_.store, header_.ids, options_.inputs, options_.collect);
    options_.model_bytes = memory_for_models(options_.memory_bytes, header_, describer_.all(),
                                             options_.threads, meshes_.index_bytes());
    describer_.memory_bytes = options_.model_bytes;
    describer_.allow_oversize = options_.allow_oversize;
    describer_.timeout_seconds = options_.timeout_seconds;
    check_described_output(options_, meshes_.files_read());
    if (options_.fresh) discard_run(output_);
    directory_ = std::make_unique<RunDirectory>(output_, RunPlan{header_, RunPurpose::describe});
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(options_.threads));
    try_suspects();
    return describe_rows();
  }

 private:
  Round first_round() const { return describer_.uses_meshes() ? Round::with_meshes : Round::with_points; }

  std::optional<PlanItem> plan_of(std::uint64_t row, Round round) {
    PlanItem plan;
    plan.row = row;
    plan.id = header_.ids[row];
    if (round == Round::with_meshes && !meshes_.add_file(plan)) {
      problems_.add(row, {Status::unreadable, "no file of this id is in the input"});
      return std::nullopt;
    }
    plan.reserved_bytes = estimate_bytes({}, describer_.points, options_.threads);
    plan.work = work_of(row);
    return plan;
  }

  GraphStages stages_of(Round round, const StoreReader& store) {
    const DescribeFailed failed = [this](const GraphItem& item, Failure problem) {
      problems_.add(item.plan->row, std::move(problem));
    };
    return round == Round::with_meshes ? stages_with_meshes(describer_, store, failed)
                                       : stages_with_points(describer_, store, failed);
  }

  // Tries rows that were in flight when an earlier process died, as `run` does.
  void try_suspects() {
    GraphParameters parameters;
    parameters.sample = describer_.points;
    parameters.timeout_seconds = options_.timeout_seconds;
    std::optional<StoreReader> own;  // not that of the parent, with which the child would share an offset
    const StageHook hook = [&](GraphStages& stages) {
      stages = stages_of(first_round(), own.emplace(options_.store, StoreCheck::none, options_.rows));
    };
    for (const std::uint64_t row : directory_->suspects()) {
      const std::optional<PlanItem> plan = plan_of(row, first_round());
      if (!plan) continue;
      const LoneResult result = try_item_alone(
          *plan, parameters, [&] { directory_->leave_lock_to_parent(); }, hook);
      if (result.crashed) problems_.add(row, {Status::crashed, result.reason});
    }
  }

  int describe_rows() {
    set_allocator_limits(options_.memory_bytes);
    stop_ = &catch_stop_signals();
    for (std::uint64_t row = 0; row < header_.ids.size(); ++row)
      if (directory_->done(row) && store_->report(row).status == Status::ok) done_before_.push_back(row);
    const auto start = std::chrono::steady_clock::now();
    bool stopped = false;
    {
      const auto [rows, work] = count_work();
      Progress progress(progress_style(options_.progress), rows, work, options_.threads, header_.samples);
      progress_ = &progress;
      if (directory_->done_count() > 0)
        progress.note(fmt::format("continuing: {} of {} rows are done already", directory_->done_count(),
                                  header_.ids.size()));
      // Incomplete rows are written last, so that a stopped job retries them.
      stopped = !describe_all(first_round());
      if (!stopped && !problems_.all().empty()) stopped = !describe_all(Round::with_points);
      progress_ = nullptr;
    }
    if (stopped) {
      directory_->sync();
      fmt::print(stderr, "meander: stopped with {} of {} rows done; the same command continues\n",
                 directory_->done_count(), header_.ids.size());
      return exit_stopped;
    }
    store_.reset();
    directory_->finish();
    directory_.reset();
    if (!done_before_.empty())
      add_earlier_problems(StoreReader(output_, StoreCheck::none), describer_, done_before_, problems_);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    print_summary({output_.string(), header_.ids, options_.describe.descriptors, problems_.all(), not_ok_,
                   seconds.count()},
                  options_.json);
    return problems_.all().empty() ? exit_done : exit_some_failed;
  }

  // The estimated seconds of a row: its descriptors come from its mesh, or else from its points.
  double work_of(std::uint64_t row) const {
    constexpr double a_row = 1e-3, a_byte = 1e-8;
    const std::uint64_t of_mesh = meshes_.bytes(row);
    return a_row + a_byte * static_cast<double>(of_mesh > 0 ? of_mesh : std::uint64_t{12} * header_.samples);
  }

  // The rows to be described and their work.
  std::pair<std::uint64_t, double> count_work() {
    std::uint64_t rows = 0;
    double work = 0;
    for (std::uint64_t row = 0; row < header_.ids.size(); ++row) {
      const bool ok = store_->report(row).status == Status::ok;
      not_ok_ += !ok;
      if (!ok || directory_->done(row)) continue;
      ++rows;
      work += work_of(row);
    }
    return {rows, work};
  }

  // Describes the rows in stretches of one journal each. False when stopped.
  bool describe_all(Round round) {
    constexpr std::uint64_t stretch = 4096;
    for (std::uint64_t begin = 0; begin < header_.ids.size(); begin += stretch) {
      const std::uint64_t end = std::min<std::uint64_t>(header_.ids.size(), begin + stretch);
      std::vector<PlanItem> plan;
      for (std::uint64_t row = begin; row < end && !*stop_; ++row) {
        if (directory_->done(row)) continue;
        if (store_->report(row).status != Status::ok) {  // such a row has no descriptors
          Row content = store_->read_row(row);
          directory_->end_item(encode_row(header_, row, content));
        } else if (round == Round::with_points || !problems_.of(row)) {
          if (std::optional<PlanItem> item = plan_of(row, round)) plan.push_back(std::move(*item));
        }
      }
      // A model beyond the budget is refused once its file has been read and its size is certain.
      if (round == Round::with_meshes)
        reserve_described(plan, describer_.meshes, options_.threads,
                          options_.allow_oversize ? ~std::uint64_t{0} : options_.model_bytes);
      if (*stop_ || !describe_plan(plan, round)) return false;
    }
    return true;
  }

  bool describe_plan(const std::vector<PlanItem>& plan, Round round) {
    if (plan.empty()) return true;
    GraphParameters parameters;
    parameters.sample = describer_.meshes;
    parameters.threads = options_.threads;
    parameters.memory_bytes = options_.model_bytes;
    // Rows without their meshes must get through; their descriptors have their own limit.
    parameters.timeout_seconds = round == Round::with_meshes ? options_.timeout_seconds : 0;
    parameters.allow_oversize = true;  // the stages themselves refuse what is too large
    GraphStages stages = stages_of(round, *store_);
    for (GraphStage& stage : stages)
      stage.body = [this, body = std::move(stage.body)](GraphItem& item) { run_or_stop(body, item); };
    DescribedRowSink rows(*directory_, round == Round::with_points);
    std::vector<NodeStatistics> nodes;
    const GraphResult result = run_sampling_graph(plan, parameters, stages, header_, rows, *stop_, nodes,
                                                  [&](const FinishedItem& item) { tell(item, round); });
    if (store_error_) std::rethrow_exception(store_error_);
    return !result.stopped;
  }

  // A store that cannot be read stops the job.
  void run_or_stop(const std::function<void(GraphItem&)>& body, GraphItem& item) {
    try {
      body(item);
    } catch (const RunError&) {
      const std::lock_guard lock(store_error_mutex_);
      if (!store_error_) store_error_ = std::current_exception();
      *stop_ = true;
      throw RunCanceled();
    }
  }

  void tell(const FinishedItem& item, Round round) {
    const std::uint64_t row = item.plan.row;
    if (round == Round::with_meshes && item.report.status != Status::ok)
      return problems_.add(row, {item.report.status, item.report.reason});
    const std::optional<Failure> problem = problems_.of(row);
    if (!problem) return progress_->finished(item);
    ItemReport report = item.report;
    report.status = problem->status;
    report.reason = problem->reason;
    progress_->finished({item.plan, report, item.failed_in, item.file_bytes, item.seconds,
                         item.waited_seconds, item.reused, item.in_flight_seconds});
  }

  DescribeOptions& options_;
  std::unique_ptr<StoreReader> store_;
  std::filesystem::path output_;
  StoreHeader header_;
  Describer describer_;
  DescribedMeshes meshes_;
  std::unique_ptr<RunDirectory> directory_;
  std::atomic<bool>* stop_ = nullptr;
  Progress* progress_ = nullptr;
  RowProblems problems_;
  std::mutex store_error_mutex_;
  std::vector<std::uint64_t> done_before_;  // ok rows that an earlier start ended, ascending
  std::exception_ptr store_error_;
  std::uint64_t not_ok_ = 0;
};

}  // namespace

JobFunction add_describe_job(Command& program) {
  auto options = std::make_shared<DescribeOptions>();
  const Command command = add_describe_command(program, *options);
  return with_failures_option(command.under("Report"), [options] {
    resolve_describe_options(*options);
    return DescribeJob(*options).run();
  });
}

}  // namespace meander
