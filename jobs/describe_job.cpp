// meander describe: more descriptors for a finished store, without sampling again.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "io/store/row_codec.h"
#include "io/store/store.h"
#include "jobs/command_line.h"
#include "jobs/describe_options.h"
#include "jobs/describe_stages.h"
#include "jobs/describe_summary.h"
#include "jobs/exit_status.h"
#include "jobs/inputs.h"
#include "jobs/jobs.h"
#include "jobs/lone_item.h"
#include "jobs/memory_budget.h"
#include "jobs/output_guard.h"
#include "jobs/progress.h"
#include "jobs/working_process.h"
#include "kernels/core/parallel.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

// Rows are described in two rounds: with their meshes, and those that failed again without.
enum class Round { with_meshes, with_points };

class DescribeJob {
 public:
  explicit DescribeJob(DescribeOptions& options) : options_(options) {}

  int run() {
    open_store();
    header_ = described_header(*store_, options_);
    prepare_describer();
    find_meshes();
    check_output();
    if (options_.fresh) discard_run(output_);
    directory_ = std::make_unique<RunDirectory>(output_, RunPlan{header_, "describe its rows"});
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(options_.threads));
    try_suspects();
    return describe_rows();
  }

 private:
  void open_store() {
    const fs::path unfinished = options_.store + ".run";
    if (!fs::exists(options_.store) && fs::exists(unfinished))
      throw UsageError("`" + options_.store +
                       "` is not finished: repeat the `meander` command that began it");
    store_ = std::make_unique<StoreReader>(options_.store, options_.check);
    std::error_code none;
    in_place_ = options_.output.empty() || fs::equivalent(options_.output, options_.store, none);
    output_ = in_place_ ? options_.store : options_.output;
    if (store_->content() == StoreContent::surfaces && !options_.inputs.empty())
      throw UsageError("`" + options_.store +
                       "` is a store of parametric surfaces: there are no meshes for geodesic and basics");
  }

  void prepare_describer() {
    SampleParameters parameters = parameters_for("direct");  // nothing is flattened here, no ray is cast
    set_samples(parameters, header_.samples);
    parameters.describe = options_.describe;
    const std::vector<std::string> problems = validate(parameters);
    if (!problems.empty()) throw UsageError(fmt::format("{}", fmt::join(problems, "\n")));
    describer_.points = describer_.meshes = parameters;
    describer_.points.describe.descriptors.clear();
    describer_.meshes.describe.descriptors.clear();
    for (const Descriptor descriptor : options_.describe.descriptors)
      (needs_mesh(descriptor) ? describer_.meshes : describer_.points)
          .describe.descriptors.push_back(descriptor);
    options_.model_bytes = memory_for_models(options_.memory_bytes, header_, parameters, options_.threads);
    describer_.memory_bytes = options_.model_bytes;
    describer_.allow_oversize = options_.allow_oversize;
  }

  // The files of the rows, by id. A row without one is a problem of that row, but not of all rows.
  void find_meshes() {
    if (!describer_.uses_meshes()) return;
    options_.collect.remembered_root = remembered_root(options_.store);
    Inputs inputs = collect_inputs(options_.inputs, options_.collect);
    print_unread(inputs.notes);
    read_ = input_files(options_.inputs, inputs.items);
    for (PlanItem& item : inputs.items) {
      const auto at = std::lower_bound(header_.ids.begin(), header_.ids.end(), item.id);
      if (at == header_.ids.end() || *at != item.id) continue;
      item.row = static_cast<std::uint64_t>(at - header_.ids.begin());
      files_.emplace(item.row, std::move(item));
    }
    if (files_.empty())
      throw UsageError(
          fmt::format("no item of `{}` is in the input: its ids look like `{}` (give the same "
                      "INPUT as to the run)",
                      options_.store, header_.ids.empty() ? "" : header_.ids.front()));
  }

  void check_output() {
    OutputGuard guard;
    guard.protect(read_);
    if (!in_place_) guard.protect(options_.store, "the store itself");
    check_store_output(output_, options_.fresh, guard);
    if (!in_place_ && !options_.fresh && fs::exists(output_))
      throw UsageError("`" + output_.string() + "` exists (--fresh replaces it)");
  }

  Round first_round() const { return describer_.uses_meshes() ? Round::with_meshes : Round::with_points; }

  std::optional<PlanItem> plan_of(std::uint64_t row, Round round) {
    PlanItem plan;
    if (round == Round::with_meshes) {
      const auto file = files_.find(row);
      if (file == files_.end()) {
        report_problem(row, {Status::unreadable, "no file of this id is in the input"});
        return std::nullopt;
      }
      plan.path = file->second.path;
      plan.format = file->second.format;
      plan.known_format = file->second.known_format;
    }
    plan.row = row;
    plan.id = header_.ids[row];
    plan.label = header_.labels[row];
    plan.reserved_bytes = estimate_bytes({}, describer_.points, options_.threads);
    return plan;
  }

  // Header peeks: what a mesh will probably need. Those that cannot be read say so when they are read.
  void reserve(std::vector<PlanItem>& plan) {
    parallel_tasks(plan.size(), [&](std::size_t i) {
      MeshEstimate estimate;
      try {
        if (plan[i].known_format) estimate = peek_mesh(plan[i].path, plan[i].format);
      } catch (const ItemError&) {
      }
      // More than the budget is refused when the file has been read and its size is certain.
      const std::uint64_t most = options_.allow_oversize ? ~std::uint64_t{0} : options_.model_bytes;
      plan[i].reserved_bytes = std::min(most, estimate_bytes(estimate, describer_.meshes, options_.threads));
    });
  }

  void report_problem(std::uint64_t row, Failure problem) {
    const std::lock_guard lock(mutex_);
    problems_.insert_or_assign(row, std::move(problem));
  }
  bool has_problem(std::uint64_t row) {
    const std::lock_guard lock(mutex_);
    return problems_.contains(row);
  }

  GraphStages stages_of(Round round, const StoreReader& store) {
    if (round == Round::with_meshes) return stages_with_meshes(describer_, store);
    return stages_with_points(describer_, store, [this](const GraphItem& item, Failure problem) {
      const std::lock_guard lock(mutex_);
      problems_.try_emplace(item.plan->row, std::move(problem));
    });
  }

  // Rows that were in flight when an earlier process died, as `run` looks at them.
  void try_suspects() {
    GraphParameters parameters;
    parameters.sample = describer_.points;
    std::optional<StoreReader> own;  // a file offset is shared with the parent, which has checked the file
    const StageHook hook = [&](GraphStages& stages) {
      directory_->leave_lock_to_parent();
      stages = stages_of(first_round(), own.emplace(options_.store, StoreCheck::none));
    };
    for (const std::uint64_t row : directory_->suspects()) {
      const std::optional<PlanItem> plan = plan_of(row, first_round());
      if (!plan) continue;
      const LoneResult result = try_item_alone(*plan, parameters, hook);
      if (result.crashed) report_problem(row, {Status::crashed, result.reason});
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
      const auto [rows, bytes] = count_work();
      Progress progress(progress_style(options_.progress), rows, bytes, header_.samples);
      progress_ = &progress;
      if (directory_->done_count() > 0)
        progress.note(fmt::format("continuing: {} of {} rows are done already", directory_->done_count(),
                                  header_.ids.size()));
      // Incomplete rows are written last, so that a stopped job retries them.
      stopped = !describe_all(first_round());
      if (!stopped && !problems_.empty()) stopped = !describe_all(Round::with_points);
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
    find_earlier_problems();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    print_describe_summary(
        {output_.string(), header_.ids, options_.describe.descriptors, problems_, not_ok_, seconds.count()},
        options_.json);
    return problems_.empty() ? exit_done : exit_some_failed;
  }

  // The rows to be described and the bytes to be read for them.
  std::pair<std::uint64_t, std::uint64_t> count_work() {
    std::uint64_t rows = 0, bytes = 0;
    for (std::uint64_t row = 0; row < header_.ids.size(); ++row) {
      const bool ok = store_->report(row).status == Status::ok;
      not_ok_ += !ok;
      if (!ok || directory_->done(row)) continue;
      ++rows;
      const auto file = files_.find(row);
      std::error_code none;
      const std::uintmax_t size = file == files_.end() ? 0 : fs::file_size(file->second.path, none);
      bytes += file == files_.end() || none ? std::uint64_t{12} * header_.samples : size;
    }
    return {rows, bytes};
  }

  // Shards of 4096 rows, one after the other: each is read and sealed once. False when stopped.
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
        } else if (round == Round::with_points || !has_problem(row)) {
          if (std::optional<PlanItem> item = plan_of(row, round)) plan.push_back(std::move(*item));
        }
      }
      if (round == Round::with_meshes) reserve(plan);
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
    parameters.timeout_seconds = options_.timeout_seconds;
    parameters.allow_oversize = true;  // what is too large was refused in front of the graph's own measures
    GraphStages stages = stages_of(round, *store_);
    for (GraphStage& stage : stages)
      stage.body = [this, body = std::move(stage.body)](GraphItem& item) { run_or_stop(body, item); };
    // Rows that failed wait for the second round.
    class Sink : public RowSink {
     public:
      Sink(RunDirectory& directory, Round round) : directory_(directory), round_(round) {}
      void begin(std::uint64_t row) override { directory_.begin_item(row); }
      void write(const EncodedRow& row) override {
        const auto record = store::read_record_header(row.bytes);
        const bool ok = record && record->status == Status::ok;
        if (ok) return directory_.end_item(row);
        if (round_ == Round::with_points)
          throw RunError(RunError::Kind::stopped,
                         "row " + std::to_string(row.row) + " could not be encoded again");
      }

     private:
      RunDirectory& directory_;
      const Round round_;
    } sink(*directory_, round);
    std::vector<NodeStatistics> nodes;
    const GraphResult result = run_sampling_graph(plan, parameters, stages, header_, sink, *stop_, nodes,
                                                  [&](const FinishedItem& item) { tell(item, round); });
    if (store_error_) std::rethrow_exception(store_error_);
    return !result.stopped;
  }

  // A store that cannot be read stops the job.
  void run_or_stop(const std::function<void(GraphItem&)>& body, GraphItem& item) {
    try {
      body(item);
    } catch (const RunError&) {
      const std::lock_guard lock(mutex_);
      if (!store_error_) store_error_ = std::current_exception();
      *stop_ = true;
      throw RunCancelled();
    }
  }

  void tell(const FinishedItem& item, Round round) {
    const std::uint64_t row = item.plan.row;
    if (round == Round::with_meshes && item.report.status != Status::ok)
      return report_problem(row, {item.report.status, item.report.reason});
    if (!has_problem(row)) return progress_->finished(item);
    ItemReport report = item.report;
    const std::lock_guard lock(mutex_);
    report.status = problems_.at(row).status;
    report.reason = problems_.at(row).reason;
    progress_->finished(
        {item.plan, report, item.failed_in, item.file_bytes, item.seconds, item.waited_seconds, item.reused});
  }

  // Rows that an earlier start of this job ended without their descriptors. A geodesic histogram of several
  // components may rightly be all 0.
  void find_earlier_problems() {
    if (done_before_.empty()) return;
    const StoreReader store(output_, StoreCheck::none);  // sealed a moment ago
    for (const DescriptorSchema& schema : store.descriptors()) {
      if (schema.group != "descriptors" || !describer_.makes(schema.name)) continue;
      if (schema.name == geodesic_disconnected_name) continue;  // most are 0
      const bool may_be_zero = schema.name == name_of(Descriptor::geodesic);
      constexpr std::uint64_t block = 4096;
      for (auto row = done_before_.begin(); row != done_before_.end();) {
        const std::uint64_t begin = *row, count = std::min(block, store.rows() - begin);
        const std::vector<float> values = store.read_descriptor(schema.name, begin, count);
        for (; row != done_before_.end() && *row < begin + count; ++row)
          if (!is_described(schema, std::span(values).subspan((*row - begin) * schema.width, schema.width)) &&
              !(may_be_zero && store.report(*row).components > 1))
            problems_.try_emplace(*row, Failure{Status::unreadable, "failed before the job was interrupted"});
      }
    }
  }

  DescribeOptions& options_;
  std::unique_ptr<StoreReader> store_;
  fs::path output_;
  bool in_place_ = true;
  StoreHeader header_;
  Describer describer_{header_, {}, {}};
  std::map<std::uint64_t, PlanItem> files_;  // by row
  std::vector<fs::path> read_;               // all files that the arguments name or contain
  std::unique_ptr<RunDirectory> directory_;
  std::atomic<bool>* stop_ = nullptr;
  Progress* progress_ = nullptr;
  std::mutex mutex_;
  std::map<std::uint64_t, Failure> problems_;  // by row
  std::vector<std::uint64_t> done_before_;     // ok rows that an earlier start ended, ascending
  std::exception_ptr store_error_;
  std::uint64_t not_ok_ = 0;
};

}  // namespace

JobFunction add_describe_job(Command& program) {
  auto options = std::make_shared<DescribeOptions>();
  add_describe_command(program, *options);
  return [options] {
    resolve_describe_options(*options);
    return DescribeJob(*options).run();
  };
}

}  // namespace meander
