// meander describe: more descriptors for a finished store, without sampling again.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "io/digest.h"
#include "io/json_writer.h"
#include "io/parameters_text.h"
#include "io/store/crc32c.h"
#include "io/store/row_codec.h"
#include "io/store/store.h"
#include "jobs/command_line.h"
#include "jobs/descriptor_choice.h"
#include "jobs/exit_status.h"
#include "jobs/input_options.h"
#include "jobs/inputs.h"
#include "jobs/jobs.h"
#include "jobs/lone_item.h"
#include "jobs/memory_budget.h"
#include "jobs/option_words.h"
#include "jobs/output_guard.h"
#include "jobs/progress.h"
#include "jobs/store_items.h"
#include "jobs/units.h"
#include "jobs/working_process.h"
#include "kernels/core/parallel.h"
#include "kernels/mesh/prepare_mesh.h"
#include "meander_version.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct DescribeOptions {
  std::string store, output, descriptors, memory = "4G", timeout = "120s", progress = "auto";
  std::vector<std::string> inputs;
  InputOptions collect;  // how the inputs are read
  DescribeParameters describe;
  int threads = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t model_bytes = 0;  // of memory_bytes
  double timeout_seconds = 0;
  DescriptorShapeOptions shape;
  bool replace = false, fresh = false, allow_oversize = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
};

bool has(const std::vector<Descriptor>& list, Descriptor descriptor) {
  return std::find(list.begin(), list.end(), descriptor) != list.end();
}

void resolve(DescribeOptions& options) {
  std::vector<std::string> problems;
  DescribeParameters& describe = options.describe;
  describe.descriptors = parse_descriptors("--descriptors", options.descriptors, problems);
  if (options.descriptors.empty())
    problems.push_back(fmt::format("describe needs --descriptors: one or more of {}, separated by commas",
                                   fmt::join(descriptor_names, ", ")));
  const bool meshes = std::any_of(describe.descriptors.begin(), describe.descriptors.end(), needs_mesh);
  if (problems.empty() && meshes && options.inputs.empty())
    problems.push_back(
        "geodesic and basics need the meshes, and a store does not keep their paths: give the inputs of the "
        "run behind the store (meander describe STORE INPUT... --descriptors ...)");
  if (problems.empty() && !meshes && !options.inputs.empty())
    problems.push_back(
        fmt::format("{} need no meshes: leave `{}` out", options.descriptors, options.inputs.front()));
  if (problems.empty()) check_descriptor_shape(options.shape, describe, problems);
  try {
    options.memory_bytes = parse_bytes(options.memory);
  } catch (const UsageError& error) {
    problems.push_back(std::string("--memory: ") + error.what());
  }
  try {
    options.timeout_seconds = parse_seconds(options.timeout);
  } catch (const UsageError& error) {
    problems.push_back(std::string("--timeout: ") + error.what());
  }
  if (options.threads == 0) options.threads = std::max(1, oneapi::tbb::info::default_concurrency());
  if (!problems.empty()) throw UsageError(fmt::format("{}", fmt::join(problems, "\n")));
}

// ---- the header of the new store -------------------------------------------------------------------------

struct Described {
  Descriptor descriptor;
  bool now;  // by this job, or in the store already
};

// A parameter of some descriptors: one value where all that it matters to agree, else one for each.
void merge_parameter(std::map<std::string, std::string>& members, const char* name, const std::string& value,
                     const std::vector<Described>& described, bool (*matters)(Descriptor)) {
  std::map<std::string, std::string> values, before;
  const std::string old = members.contains(name) ? members[name] : value;
  if (old.starts_with('{')) before = split_members(old);
  for (const Described& d : described) {
    if (!matters(d.descriptor)) continue;
    const std::string key(name_of(d.descriptor));
    values[key] = d.now ? value : before.contains(key) ? before[key] : old;
  }
  const bool one = std::all_of(values.begin(), values.end(),
                               [&](const auto& v) { return v.second == values.begin()->second; });
  members[name] = values.empty() ? value : one ? values.begin()->second : join_members(values);
}

// The parameters of `meander run --describe` with what is described now added.
std::string described_parameters(const StoreReader& store, const std::vector<DescriptorSchema>& schemas,
                                 const DescribeParameters& describe) {
  std::map<std::string, std::string> members = split_members(store.parameters_json());
  std::vector<Described> described;
  std::string names;
  for (const DescriptorSchema& schema : schemas) {
    if (schema.group != "descriptors") continue;
    if (schema.name == geodesic_disconnected_name) continue;  // comes with geodesic
    names += (names.empty() ? "" : ",") + schema.name;
    const auto at = std::find(descriptor_names.begin(), descriptor_names.end(), schema.name);
    if (at == descriptor_names.end()) continue;  // of a later program
    const auto descriptor = static_cast<Descriptor>(at - descriptor_names.begin());
    described.push_back({descriptor, has(describe.descriptors, descriptor)});
  }
  members["describe"] = "\"" + names + "\"";
  merge_parameter(members, "descriptor_bins", fmt::format("{}", describe.bins), described, has_bins);
  merge_parameter(members, "descriptor_scale",
                  describe.scale == HistogramScale::mean ? "\"mean\"" : "\"largest\"", described,
                  takes_scale);
  merge_parameter(members, "geodesic_sources", fmt::format("{}", describe.geodesic_sources), described,
                  [](Descriptor d) { return d == Descriptor::geodesic; });
  return join_members(members);
}

StoreHeader described_header(const StoreReader& store, const DescribeOptions& options) {
  StoreHeader header = store.header();
  header.descriptors.clear();
  std::vector<DescriptorSchema> added = schemas_of(options.describe);
  if (store.tool_version() != meander_version)
    for (DescriptorSchema& schema : added) schema.attributes.emplace_back("tool_version", meander_version);
  // Those of the store keep their places; measures of the samples come last.
  std::vector<DescriptorSchema> measures;
  for (const DescriptorSchema& old : store.descriptors()) {
    if (old.group != "descriptors") {
      measures.push_back(old);
      continue;
    }
    const auto again = std::find_if(added.begin(), added.end(),
                                    [&](const DescriptorSchema& schema) { return schema.name == old.name; });
    if (again != added.end() && !options.replace)
      throw UsageError(fmt::format("`{}` has the descriptor {} already (--replace computes it again)",
                                   options.store, old.name));
    header.descriptors.push_back(again == added.end() ? old : *again);
    if (again != added.end()) added.erase(again);
  }
  header.descriptors.insert(header.descriptors.end(), added.begin(), added.end());
  header.descriptors.insert(header.descriptors.end(), measures.begin(), measures.end());
  header.parameters_json = described_parameters(store, header.descriptors, options.describe);
  return header;
}

// ---- one row ---------------------------------------------------------------------------------------------

// A row that lacks descriptors, and why.
struct Problem {
  Status status = Status::internal;
  std::string reason;
};

// What every row is described with; shared by all threads.
struct Describer {
  const StoreHeader& header;
  SampleParameters points, meshes;  // the descriptors that need the samples alone, and the others
  double timeout_seconds = 0;
  std::uint64_t memory_bytes = 0;
  bool allow_oversize = false;

  bool makes(std::string_view name) const {
    const auto named = [&](Descriptor descriptor) { return makes_row(descriptor, name); };
    const auto &of_points = points.describe.descriptors, &of_meshes = meshes.describe.descriptors;
    return std::any_of(of_points.begin(), of_points.end(), named) ||
           std::any_of(of_meshes.begin(), of_meshes.end(), named);
  }
};

Row read_row(const StoreReader& store, std::uint64_t row) {
  Row content = store.read_row(row);
  if (content.report.status == Status::ok &&
      crc32c(std::span<const float>(content.samples.points)) != content.report.points_crc32c)
    throw RunError(
        RunError::Kind::unusable,
        fmt::format("the points of row {} are not those that were written: see meander verify", row));
  return content;
}

void mesh_descriptors(const Describer& describer, GraphItem& item, const CancelToken& cancel,
                      std::vector<DescriptorRow>& rows) {
  const PlanItem& plan = *item.plan;
  const Row& row = item.model.row;
  if (!plan.known_format)
    throw ItemError(Status::unsupported_format, "`" + plan.path.string() + "` is no mesh file");
  MeshEstimate estimate;
  PolygonMesh mesh;
  {
    const MappedFile file(plan.path);
    if (sha256(file.bytes()) != row.report.content_sha256)
      throw ItemError(Status::unreadable,
                      "`" + plan.path.string() + "` is not the file that was sampled: its SHA-256 differs");
    mesh = read_mesh(file.bytes(), plan.format, cancel);
    item.file_bytes = estimate.file_bytes = file.bytes().size();
  }
  estimate.vertices = mesh.vertex_count();
  const std::size_t corners = mesh.corners.size(), polygons = mesh.polygon_count();
  estimate.triangles = corners > 2 * polygons ? corners - 2 * polygons : 0;
  const std::uint64_t needed =
      estimate_bytes(estimate, describer.meshes, oneapi::tbb::this_task_arena::max_concurrency());
  if (needed > describer.memory_bytes && !describer.allow_oversize)
    throw ItemError(Status::too_large, fmt::format("needs about {} MiB, --memory leaves {} MiB for models "
                                                   "(raise it, or --allow-oversize)",
                                                   needed >> 20, describer.memory_bytes >> 20));
  if (needed > item.reserved_bytes) throw NeedsMoreMemory(needed);
  const PreparedMesh prepared = prepare_mesh(mesh, cancel);
  item.model.row.samples.triangle = sample_triangles(mesh, prepared, row.samples);
  for (DescriptorRow& made :
       describe_samples(prepared, row.samples, item.model.key, describer.meshes.describe, cancel))
    rows.push_back(std::move(made));
}

// Calls body and returns what went wrong with it; a stop of the job and a lack of reserved memory get out.
template <class Body>
std::optional<Problem> try_to(const Body& body) {
  try {
    body();
  } catch (const RunCancelled&) {
    throw;
  } catch (const NeedsMoreMemory&) {
    throw;
  } catch (const RunError&) {
    throw;
  } catch (const ItemError& error) {
    return Problem{error.status(), error.what()};
  } catch (const std::bad_alloc&) {
    return Problem{Status::out_of_memory, "an allocation failed"};
  } catch (const std::exception& error) {
    return Problem{Status::internal, error.what()};
  }
  return std::nullopt;
}

// Reads a row that is ok and adds its descriptors; those that cannot be made are all 0.
std::optional<Problem> describe_row(const Describer& describer, const StoreReader& store, GraphItem& item,
                                    bool with_meshes) {
  CancelToken cancel = item.model.cancel;
  if (describer.timeout_seconds > 0)
    cancel.deadline =
        std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                               std::chrono::duration<double>(describer.timeout_seconds));
  item.model.row = read_row(store, item.plan->row);
  Row& row = item.model.row;
  item.model.key = make_random_key(describer.header.seed, row.report.content_sha256);
  std::vector<DescriptorRow> made;
  std::optional<Problem> problem;
  if (with_meshes && !describer.meshes.describe.descriptors.empty())
    problem = try_to([&] { mesh_descriptors(describer, item, cancel, made); });
  const auto point_problem = try_to([&] {
    for (DescriptorRow& d :
         describe_samples({}, row.samples, item.model.key, describer.points.describe, cancel))
      made.push_back(std::move(d));
  });
  if (!problem) problem = point_problem;
  std::vector<DescriptorRow> all;
  for (const DescriptorSchema& schema : describer.header.descriptors) {
    const auto named = [&](const DescriptorRow& d) { return d.name == schema.name; };
    auto found = std::find_if(made.begin(), made.end(), named);
    if (found == made.end() && !describer.makes(schema.name)) {
      found = std::find_if(row.descriptors.begin(), row.descriptors.end(), named);
      all.push_back(std::move(*found));
    } else if (found != made.end()) {
      all.push_back(std::move(*found));
    } else {
      all.push_back({schema.name, std::vector<float>(schema.width, 0.0f)});
    }
  }
  row.descriptors = std::move(all);
  return problem;
}

// ---- the job ---------------------------------------------------------------------------------------------

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
    SampleParameters parameters;
    parameters.method = MethodChoice::direct;  // nothing is flattened here, no ray is cast
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
    parameters.describe = options_.describe;
    options_.model_bytes = memory_for_models(options_.memory_bytes, header_, parameters, options_.threads);
    describer_.timeout_seconds = options_.timeout_seconds;
    describer_.memory_bytes = options_.model_bytes;
    describer_.allow_oversize = options_.allow_oversize;
  }

  bool uses_meshes() const { return !describer_.meshes.describe.descriptors.empty(); }

  // The files of the rows, by id. A row without one is a problem of that row, but not of all rows.
  void find_meshes() {
    if (!uses_meshes()) return;
    options_.collect.remembered_root = remembered_root(options_.store);
    Inputs inputs = collect_inputs(options_.inputs, options_.collect);
    print_unread(inputs.notes);
    read_ = input_files(options_.inputs, inputs.items);
    std::uint64_t found = 0;
    for (PlanItem& item : inputs.items) {
      const auto at = std::lower_bound(header_.ids.begin(), header_.ids.end(), item.id);
      if (at == header_.ids.end() || *at != item.id) continue;
      item.row = static_cast<std::uint64_t>(at - header_.ids.begin());
      files_.emplace(item.row, std::move(item));
      ++found;
    }
    if (found == 0)
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

  std::optional<PlanItem> plan_of(std::uint64_t row, bool with_meshes) {
    PlanItem plan;
    plan.row = row;
    plan.id = header_.ids[row];
    plan.label = header_.labels[row];
    if (!with_meshes) {
      plan.reserved_bytes = estimate_bytes({}, describer_.points, options_.threads);
      return plan;
    }
    const auto file = files_.find(row);
    if (file == files_.end()) {
      report_problem(row, {Status::unreadable, "no file of this id is in the input"});
      return std::nullopt;
    }
    plan.path = file->second.path;
    plan.format = file->second.format;
    plan.known_format = file->second.known_format;
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

  void report_problem(std::uint64_t row, Problem problem) {
    const std::lock_guard lock(problems_mutex_);
    problems_.insert_or_assign(row, std::move(problem));
  }
  std::optional<Problem> problem_of(std::uint64_t row) {
    const std::lock_guard lock(problems_mutex_);
    const auto at = problems_.find(row);
    return at == problems_.end() ? std::nullopt : std::optional(at->second);
  }

  // Rows that were in flight when an earlier process died, as `run` looks at them.
  void try_suspects() {
    GraphParameters parameters;
    parameters.sample.method = MethodChoice::direct;
    const StageHook hook = [this](GraphStages& stages) {
      directory_->leave_lock_to_parent();
      stages = {{"describe_row", [this](GraphItem& item) {
                   // A reader of its own: a file offset is shared with the parent, which has checked the
                   // file.
                   const StoreReader own(options_.store, StoreCheck::none);
                   describe_row(describer_, own, item, uses_meshes());
                 }}};
    };
    for (const std::uint64_t row : directory_->suspects()) {
      const std::optional<PlanItem> plan = plan_of(row, uses_meshes());
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
      stopped = !describe_all(uses_meshes());
      if (!stopped && !problems_.empty()) stopped = !describe_all(false);
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
    print_summary(seconds.count());
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
      bytes += file == files_.end() || none ? point_bytes() : size;
    }
    return {rows, bytes};
  }

  // Shards of 4096 rows, one after the other: each is read and sealed once. False when stopped.
  bool describe_all(bool with_meshes) {
    constexpr std::uint64_t stretch = 4096;
    for (std::uint64_t begin = 0; begin < header_.ids.size(); begin += stretch) {
      const std::uint64_t end = std::min<std::uint64_t>(header_.ids.size(), begin + stretch);
      std::vector<PlanItem> plan;
      for (std::uint64_t row = begin; row < end && !*stop_; ++row) {
        if (directory_->done(row)) continue;
        if (store_->report(row).status != Status::ok) {
          keep_row(row);
        } else if (!with_meshes || !problem_of(row)) {
          if (std::optional<PlanItem> item = plan_of(row, with_meshes)) plan.push_back(std::move(*item));
        }
      }
      if (with_meshes) reserve(plan);
      if (*stop_ || !describe_plan(plan, with_meshes)) return false;
    }
    return true;
  }

  // A row that is not ok has no descriptors.
  void keep_row(std::uint64_t row) {
    Row content = store_->read_row(row);
    directory_->end_item(encode_row(header_, row, content));
  }

  bool describe_plan(const std::vector<PlanItem>& plan, bool with_meshes) {
    if (plan.empty()) return true;
    GraphParameters parameters;
    parameters.sample = describer_.meshes;
    parameters.threads = options_.threads;
    parameters.memory_bytes = options_.model_bytes;
    parameters.allow_oversize = true;  // what is too large was refused in front of the graph's own measures
    const bool last = !with_meshes;
    const GraphStages stages = {
        {"describe_row", [&](GraphItem& item) { describe_in_graph(item, with_meshes); }}};
    // A row with a problem waits for the second round.
    class Sink : public RowSink {
     public:
      Sink(DescribeJob& job, bool last_round) : job_(job), last_(last_round) {}
      void begin(std::uint64_t row) override { job_.directory_->begin_item(row); }
      void write(const EncodedRow& row) override {
        if (!last_ && job_.problem_of(row.row)) return;
        const auto record = store::read_record_header(row.bytes);
        if (!record || record->status != Status::ok)
          throw RunError(RunError::Kind::stopped,
                         "row " + std::to_string(row.row) + " could not be encoded again");
        job_.directory_->end_item(row);
      }

     private:
      DescribeJob& job_;
      const bool last_;
    } sink(*this, last);
    std::vector<NodeStatistics> nodes;
    const GraphResult result = run_sampling_graph(plan, parameters, stages, header_, sink, *stop_, nodes,
                                                  [&](const FinishedItem& item) { tell(item, last); });
    if (store_error_) std::rethrow_exception(store_error_);
    return !result.stopped;
  }

  // A store that cannot be read stops the job.
  void describe_in_graph(GraphItem& item, bool with_meshes) {
    item.file_bytes = point_bytes();
    try {
      const std::optional<Problem> problem = describe_row(describer_, *store_, item, with_meshes);
      if (problem) report_problem(item.plan->row, *problem);
    } catch (const RunError&) {
      const std::lock_guard lock(problems_mutex_);
      if (!store_error_) store_error_ = std::current_exception();
      *stop_ = true;
      throw RunCancelled();
    }
  }

  std::uint64_t point_bytes() const { return std::uint64_t{12} * header_.samples; }

  void tell(const FinishedItem& item, bool last) {
    const std::optional<Problem> problem = problem_of(item.plan.row);
    if (problem && !last) return;
    if (!problem) return progress_->finished(item);
    ItemReport report = item.report;
    report.status = problem->status;
    report.reason = problem->reason;
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
            problems_.try_emplace(*row, Problem{Status::unreadable, "failed before the job was interrupted"});
      }
    }
  }

  void print_summary(double seconds) const {
    std::string names;
    for (const Descriptor descriptor : options_.describe.descriptors)
      names += (names.empty() ? "" : ",") + std::string(name_of(descriptor));
    const std::uint64_t described = header_.ids.size() - not_ok_ - problems_.size();
    if (options_.json) {
      JsonWriter json;
      json.begin_object();
      json.member("store", output_.string());
      json.member("descriptors", names);
      json.member("rows", std::uint64_t{header_.ids.size()});
      json.member("described", described);
      json.member("not_ok", not_ok_);
      json.member("seconds", seconds);
      json.key("problems");
      json.begin_array();
      for (const auto& [row, problem] : problems_) {
        json.begin_object();
        json.member("id", header_.ids[row]);
        json.member("status", name_of(problem.status));
        json.member("reason", problem.reason);
        json.end_object();
      }
      json.end_array();
      json.end_object();
      fmt::print("{}\n", json.text());
      return;
    }
    fmt::print("{}: {} rows described with {} in {:.2f} s", output_.string(), described, names, seconds);
    if (not_ok_ > 0) fmt::print(", {} without samples", not_ok_);
    fmt::print("\n");
    if (problems_.empty()) return;
    fmt::print("{} rows could not be described completely; missing values are 0:\n", problems_.size());
    constexpr std::size_t most_shown = 100;
    std::size_t shown = 0;
    for (const auto& [row, problem] : problems_) {
      if (shown++ == most_shown) break;
      fmt::print("  {}: {}: {}\n", header_.ids[row], name_of(problem.status), problem.reason);
    }
    if (problems_.size() > most_shown)
      fmt::print("  and {} more (--json lists all)\n", problems_.size() - most_shown);
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
  std::mutex problems_mutex_;
  std::map<std::uint64_t, Problem> problems_;  // by row
  std::vector<std::uint64_t> done_before_;     // ok rows that an earlier start ended, ascending
  std::exception_ptr store_error_;
  std::uint64_t not_ok_ = 0;
};

}  // namespace

JobFunction add_describe_job(Command& program) {
  Command command =
      program.add_subcommand("describe", "Add descriptors to a finished store without sampling again");
  auto options = std::make_shared<DescribeOptions>();
  command.add_option("STORE", options->store, "The store; it is replaced as a whole at the end").required();
  command.add_option("INPUT", options->inputs,
                     "The inputs of `meander run`, for geodesic and basics; files are found by their ids");
  command.add_option("--descriptors", options->descriptors,
                     "One or more of d2,a3,d1,d3,d4,geodesic,basics, separated by commas; required");
  command.add_option("-o,--output", options->output, "Write to this store instead");
  ParameterTable unused;  // the new header takes its parameters from those of the store
  add_descriptor_shape_options(command, unused, options->shape, options->describe);
  command.add_flag("--replace", options->replace, "Recompute descriptors that the store already has");
  add_list_options(command, options->collect);
  Command running = command.under("Running");
  running.add_flag("--fresh", options->fresh,
                   "Discard the unfinished work of an earlier describe (and OUTPUT)");
  add_trust_option(running, options->check);
  running.add_option("-j,--threads", options->threads, "Threads, up to 1024 (0: all available)")
      .show_default()
      .range(0, 1024);
  running.add_option("--memory", options->memory, "Memory budget of the whole process").show_default();
  running.add_flag("--allow-oversize", options->allow_oversize,
                   "Process a model that exceeds the memory budget, on its own");
  running.add_option("--timeout", options->timeout, "Time limit per model; 0: none").show_default();
  Command report = command.under("Report");
  report
      .add_option("--progress", options->progress,
                  "Progress on standard error; auto: a bar on a terminal, plain lines otherwise")
      .show_default()
      .one_of({"auto", "bar", "plain", "json", "none"});
  report.add_flag("--json", options->json, "The summary as JSON on standard output");
  return [options] {
    resolve(*options);
    return DescribeJob(*options).run();
  };
}

}  // namespace meander
