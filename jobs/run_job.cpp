// meander run: from files to one store.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <unordered_map>

#include "jobs/descriptor_choice.h"
#include "jobs/exit_status.h"
#include "jobs/inputs.h"
#include "jobs/jobs.h"
#include "jobs/lone_item.h"
#include "jobs/progress.h"
#include "jobs/run_options.h"
#include "jobs/run_summary.h"
#include "jobs/working_process.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

class StoreSink : public RowSink {
 public:
  explicit StoreSink(RunDirectory& directory) : directory_(directory) {}
  void begin(std::uint64_t row) override { directory_.begin_item(row); }
  void write(const EncodedRow& row) override { directory_.end_item(row); }

 private:
  RunDirectory& directory_;
};

StoreHeader make_header(const RunOptions& options, const Inputs& inputs) {
  StoreHeader header;
  header.samples = options.sample.place.samples;
  if (options.sample.method == MethodChoice::anisotropic) header.content = StoreContent::anisotropic_meshes;
  header.compression = options.compression;
  header.seed = options.sample.seed;
  header.order = options.sample.place.order == OrderKind::curve ? "curve" : "progressive";
  header.parameters_json = parameters_json(options.sample, options.compression);
  header.label_names = inputs.label_names;
  header.descriptors = schemas_of(options.sample.describe);
  if (options.sample.method == MethodChoice::anisotropic) {
    constexpr std::array<const char*, anisotropy_names.size()> meanings = {
        "segments that the surface was charted in",
        "share of the area whose chart follows the tensor within the limits",
        "mean angle between the chart's first axis and the primary direction, radians; charts in the metric "
        "are turned freely",
        "mean ratio of the chart's singular values in the tensor's metric; 1 is conformal",
        "mean ratio of the two wanted spacings",
        "share of the triangles whose ratio was cut to the largest allowed"};
    for (std::size_t i = 0; i < meanings.size(); ++i)
      header.descriptors.push_back({anisotropy_names[i], 1, {{"meaning", meanings[i]}}, "anisotropy"});
  }
  if (options.sample.certify) {
    header.descriptors.push_back(
        {certificate_box_error,
         1,
         {{"meaning",
           "root mean square error over 1000 random rotated boxes with exact areas, relative to random "
           "points; smaller is better"}},
         "certificate"});
    header.descriptors.push_back(
        {certificate_rho,
         1,
         {{"meaning",
           "smallest distance between samples over that of a hexagonal lattice of the same density"}},
         "certificate"});
  }
  for (const PlanItem& item : inputs.items) {
    header.ids.push_back(item.id);
    header.labels.push_back(item.label);
    header.splits.push_back(item.split);
  }
  return header;
}

// Header peeks, in parallel: what every item will probably need. Returns the bytes of all files.
std::uint64_t reserve_memory(std::vector<PlanItem>& items, const SampleParameters& parameters, int threads) {
  std::atomic<std::uint64_t> total{0};
  oneapi::tbb::parallel_for(std::size_t{0}, items.size(), [&](std::size_t i) {
    MeshEstimate estimate;
    try {
      if (items[i].known_format) estimate = peek_mesh(items[i].path, items[i].format);
    } catch (const ItemError&) {  // the read stage will say why
    }
    items[i].reserved_bytes = estimate_bytes(estimate, parameters, threads);
    total += estimate.file_bytes;
  });
  return total;
}

// Rows of a finished store by content, for --reuse: only what the same parameters and the same seed made, and
// never a status that depends on the machine.
class ReusableRows {
 public:
  ReusableRows(const std::string& path, const StoreHeader& header) : store_(path) {
    if (store_.parameters_json() != header.parameters_json || store_.method_version() != store_method_version)
      throw UsageError("--reuse: `" + path + "` was made with other parameters:\n  " +
                       store_.parameters_json() + "\nnot\n  " + header.parameters_json);
    for (std::uint64_t row = 0; row < store_.rows(); ++row) {
      const ItemReport report = store_.report(row);
      if (!depends_on_machine(report.status)) rows_.emplace(key_of(report.content_sha256), row);
    }
  }

  bool find(const std::array<std::uint8_t, 32>& content, Row& row) const {
    const auto at = rows_.find(key_of(content));
    if (at == rows_.end()) return false;
    Row found = store_.read_row(at->second);
    found.label = row.label;
    row = std::move(found);
    return true;
  }

 private:
  static bool depends_on_machine(Status status) {
    return status == Status::timeout || status == Status::out_of_memory || status == Status::too_large ||
           status == Status::crashed || status == Status::internal || status == Status::unsupported_format ||
           status == Status::unreadable;
  }
  static std::string key_of(const std::array<std::uint8_t, 32>& content) {
    return {content.begin(), content.end()};
  }

  StoreReader store_;
  std::unordered_map<std::string, std::uint64_t> rows_;
};

// One run, step by step.
class RunJob {
 public:
  RunJob(RunOptions& options, const StageHook& hook) : options_(options), hook_(hook) {}

  int run() {
    inputs_ = collect_inputs(options_.inputs, options_.label_from_folder);
    plan_tensor_files(options_.sample.tensor, inputs_.items);
    if (inputs_.items.empty()) throw UsageError("no mesh file (.off, .obj, .ply, .stl) in the input");
    header_ = make_header(options_, inputs_);
    if (options_.dry_run) return print_plan();
    if (options_.fresh) discard_store(options_.store);
    if (std::filesystem::exists(options_.store)) {
      if (const auto status = look_at_finished_store()) return *status;
    }
    if (!options_.reuse.empty()) reusable_ = std::make_unique<ReusableRows>(options_.reuse, header_);
    directory_ = std::make_unique<RunDirectory>(options_.store, header_);
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(options_.threads));
    try_suspects();
    if (!options_.retry.empty()) keep_finished_rows();
    return run_graph();
  }

 private:
  int print_plan() {
    std::uint64_t bytes = reserve_memory(inputs_.items, options_.sample, options_.threads), largest = 0,
                  over = 0;
    for (const PlanItem& item : inputs_.items) {
      largest = std::max(largest, item.reserved_bytes);
      over += item.reserved_bytes > options_.memory_bytes;
      fmt::print("{}\t{}\t{} MiB\n", item.id, item.known_format ? "" : "unsupported_format",
                 (item.reserved_bytes + (1 << 20) - 1) >> 20);
    }
    const double points = static_cast<double>(inputs_.items.size()) * header_.samples;
    fmt::print(
        "{} models, {:.1f} MB of input, {} points each, about {:.1f} MB of points and their attributes\n",
        inputs_.items.size(), static_cast<double>(bytes) * 1e-6, header_.samples, points * 60e-6);
    fmt::print("largest model needs about {} MiB of the budget of {} MiB; {} would be too_large\n",
               largest >> 20, options_.memory_bytes >> 20, over);
    for (const auto& [extension, count] : inputs_.skipped)
      fmt::print("skipped: {} files `{}`\n", count, extension);
    return exit_done;
  }

  // A store of this name is there already. Returns the exit code when there is nothing left to do.
  std::optional<int> look_at_finished_store() {
    finished_ = std::make_unique<StoreReader>(options_.store);
    if (finished_->parameters_json() != header_.parameters_json ||
        finished_->method_version() != store_method_version)
      throw UsageError(
          fmt::format("`{}` was made with other parameters:\n  {}\nnot\n  {}\n(--fresh replaces it, or "
                      "choose another name)",
                      options_.store, finished_->parameters_json(), header_.parameters_json));
    bool same = finished_->rows() == header_.ids.size() && finished_->label_names() == header_.label_names;
    for (std::uint64_t row = 0; same && row < finished_->rows(); ++row)
      same = finished_->id(row) == header_.ids[row] && finished_->label(row) == header_.labels[row];
    if (!same)
      throw UsageError("`" + options_.store +
                       "` was made from other items or labels (write a new store with --reuse " +
                       options_.store + ", or --fresh)");
    if (!options_.retry.empty()) return std::nullopt;
    const StoreSummary summary = summarise(*finished_);
    print_summary(summary, options_, inputs_.skipped, 0, 0, {});
    return summary.failed() > 0 ? exit_some_failed : exit_done;
  }

  // --retry: every row of the finished store but those to be done again goes into the new run as it is.
  void keep_finished_rows() {
    if (!finished_)
      throw UsageError(
          "--retry needs a finished store; finish the run first with the same command without --retry");
    for (std::uint64_t row = 0; row < finished_->rows(); ++row) {
      const Status status = finished_->report(row).status;
      const bool again =
          std::find(options_.retry.begin(), options_.retry.end(), status) != options_.retry.end();
      if (!again && !directory_->done(row))
        directory_->end_item(encode_row(header_, row, finished_->read_row(row)));
    }
    finished_.reset();
  }

  GraphParameters graph_parameters() const {
    GraphParameters parameters;
    parameters.sample = options_.sample;
    parameters.threads = options_.threads;
    parameters.memory_bytes = options_.memory_bytes;
    parameters.allow_oversize = options_.allow_oversize;
    parameters.timeout_seconds = options_.timeout_seconds;
    parameters.max_failures = options_.max_failures;
    return parameters;
  }

  // Items that were in flight when an earlier process died. Before any thread is started: it forks. Writing a
  // row may start threads (it may seal a shard), so the verdicts come first and the rows after them.
  void try_suspects() {
    const GraphParameters parameters = graph_parameters();
    std::vector<std::pair<std::uint64_t, std::string>> crashed;
    for (const std::uint64_t row : directory_->suspects()) {
      LoneResult result = try_item_alone(inputs_.items[row], parameters, hook_);
      if (result.crashed) crashed.emplace_back(row, std::move(result.reason));
    }
    for (const auto& [row, reason] : crashed) {
      Row content;
      content.label = inputs_.items[row].label;
      content.report.status = Status::crashed;
      content.report.reason = reason;
      directory_->end_item(encode_row(header_, row, content));
      if (options_.progress != "none" && options_.progress != "json")
        fmt::print(stderr, "{}: crashed: {}\n", inputs_.items[row].id, reason);
    }
  }

  int run_graph() {
    set_allocator_limits();
    std::atomic<bool>& stop_requested = catch_stop_signals();
    std::vector<PlanItem> plan;
    for (const PlanItem& item : inputs_.items)
      if (!directory_->done(item.row)) plan.push_back(item);
    const std::uint64_t earlier = inputs_.items.size() - plan.size();
    const auto start = std::chrono::steady_clock::now();
    std::vector<NodeStatistics> nodes;
    GraphResult result;
    {
      std::optional<EmbreeDevice> device;
      if (casts_rays(options_.sample)) device.emplace();
      const GraphParameters parameters = graph_parameters();
      const std::uint64_t bytes = reserve_memory(plan, parameters.sample, options_.threads);
      ReuseLookup reuse;
      if (reusable_) reuse = [this](const auto& content, Row& row) { return reusable_->find(content, row); };
      GraphStages stages = sampling_stages(parameters.sample, device ? &*device : nullptr, reuse);
      if (hook_) hook_(stages);
      StoreSink sink(*directory_);
      Progress progress(progress_style(options_.progress), plan.size(), bytes, header_.samples);
      if (earlier > 0)
        progress.note(
            fmt::format("continuing: {} of {} models are done already", earlier, inputs_.items.size()));
      result = run_sampling_graph(plan, parameters, stages, header_, sink, stop_requested, nodes,
                                  [&](const FinishedItem& item) { progress.finished(item); });
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    if (result.stopped) {
      directory_->sync();
      fmt::print(stderr, "meander: stopped with {} of {} models done; the same command continues\n",
                 directory_->done_count(), inputs_.items.size());
      return exit_stopped;
    }
    directory_->finish();
    directory_.reset();
    const StoreReader store(options_.store);
    const StoreSummary summary = summarise(store);
    write_run_report(options_, summary, result, seconds.count(), nodes);
    write_failed_list(options_, summary, inputs_.items);
    print_summary(summary, options_, inputs_.skipped, seconds.count(), result.written, nodes);
    return summary.failed() > 0 ? exit_some_failed : exit_done;
  }

  RunOptions& options_;
  const StageHook& hook_;
  Inputs inputs_;
  StoreHeader header_;
  std::unique_ptr<StoreReader> finished_;
  std::unique_ptr<ReusableRows> reusable_;
  std::unique_ptr<RunDirectory> directory_;
};

}  // namespace

JobFunction add_run_job(CLI::App& program, StageHook hook) {
  auto options = std::make_shared<RunOptions>();
  auto texts = std::make_shared<RunOptionTexts>();
  add_run_command(program, *options, *texts);
  return [options, texts, hook = std::move(hook)] {
    resolve_run_options(*options, *texts);
    return RunJob(*options, hook).run();
  };
}

}  // namespace meander
