// meander remesh: from files to meshes whose vertices are the samples.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "io/archive/model_bytes.h"
#include "io/item_id.h"
#include "io/json_writer.h"
#include "io/mesh/mesh_writer.h"
#include "io/parameters_text.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/progress.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/working_process.h"
#include "jobs/inputs/input_options.h"
#include "jobs/remesh/remesh_folder.h"
#include "jobs/remesh/remesh_options.h"
#include "jobs/remesh/remesh_stages.h"
#include "jobs/remesh/remesh_table.h"
#include "jobs/rows/lone_item.h"
#include "jobs/rows/memory_budget.h"
#include "jobs/rows/planned_run.h"
#include "jobs/rows/run_header.h"

namespace meander {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double much_of_area = 0.1;  // dropped: more than this is worth a line of its own

InputStamp stamp_of_file(const fs::path& file) {
  std::error_code none;
  const auto modified = fs::last_write_time(file, none);
  if (none) return {};
  const auto bytes = fs::file_size(file, none);
  if (none) return {};
  return {static_cast<std::int64_t>(bytes),
          std::chrono::duration_cast<std::chrono::nanoseconds>(modified.time_since_epoch()).count()};
}

// With the files that the model names.
InputStamp stamp_of(const PlanItem& item) {
  InputStamp stamp = stamp_of_file(file_of(item));
  if (!item.known_format || row_of(item.format).companions == nullptr || stamp == InputStamp{}) return stamp;
  try {
    const MeshEstimate peeked = peek_model(item);
    for (const fs::path& file : companion_files(peeked, item)) {
      const InputStamp beside = stamp_of_file(file);
      stamp.bytes += beside.bytes;
      stamp.modified = std::max(stamp.modified, beside.modified);
    }
  } catch (const ItemError&) {  // reading it says why
  }
  return stamp;
}

// Logs the items that are begun; the meshes are no rows.
class BegunItems final : public RowSink {
 public:
  BegunItems(RemeshFolder& folder, std::span<const PlanItem> items) : folder_(folder), items_(items) {}
  void begin(std::uint64_t row) override { folder_.log_begun(items_[row].id); }
  void write(EncodedRow) override {}

 private:
  RemeshFolder& folder_;
  std::span<const PlanItem> items_;  // by row
};

class RemeshJob {
 public:
  RemeshJob(RemeshOptions& options, const StageHook& hook)
      : options_(options),
        run_(options.run),
        carried_(carried_columns(options)),
        folder_(options.run.store),
        hook_(hook) {}

  int run() {
    list_own_files();
    if (earlier_) run_.collect.remembered_root = earlier_->root;
    inputs_ = collect_run_inputs(run_);
    header_ = run_header(run_, inputs_, nullptr);
    run_.model_bytes =
        memory_for_models(run_.memory_bytes, header_, run_.sample, run_.threads, inputs_.index_bytes);
    names_ = remesh_names(inputs_.items, std::string(row_of(options_.format).extensions.front()));
    take_earlier_table();
    check_outputs();
    try_suspects();
    // A file of somebody else's that --fresh replaces becomes the command's own when it is, not before.
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (is_own(i) || !fs::exists(target(i))) table_.planned.insert(names_[i]);
    folder_.begin(table_, own_files_);
    const bool stopped = !make_meshes();
    if (!stopped) table_.planned.clear();
    folder_.end(table_);
    if (stopped) return exit_stopped;
    print_summary();
    return failed() > 0 || !inputs_.notes.unread.empty() ? exit_some_failed : exit_done;
  }

 private:
  // What earlier runs into this folder have made, or, where the last one did not end, may have.
  void list_own_files() {
    std::optional<RemeshTable> table;
    try {
      table = folder_.read();
    } catch (const RunError&) {
      if (!run_.fresh) throw;  // with --fresh: no table of this command, so nothing here is its own
    }
    if (!table) return;
    own_files_ = table->planned;
    for (const auto& [id, record] : table->records)
      if (!record.file.empty()) own_files_.insert(record.file);
    if (!run_.fresh) earlier_ = std::move(table);
  }
  bool is_own(std::size_t item) const { return own_files_.contains(names_[item]); }

  // Meshes that an earlier process made with these parameters stay, where the input has not changed since.
  void take_earlier_table() {
    table_.parameters_json = run_.parameters_json;
    table_.root = inputs_.root.string();
    if (!earlier_) return;
    if (earlier_->parameters_json != table_.parameters_json)
      throw UsageError(fmt::format(
          "`{}` was made with other parameters: {} (--fresh makes all meshes anew, or choose another folder)",
          folder_.path().string(), parameter_differences(earlier_->parameters_json, table_.parameters_json)));
    std::map<std::string_view, std::size_t> rows;
    for (std::size_t i = 0; i < inputs_.items.size(); ++i) rows[inputs_.items[i].id] = i;
    for (const auto& [id, record] : earlier_->records) {
      const auto found = rows.find(id);
      if (found == rows.end()) {
        vanished_.insert(id);
        table_.records[id] = record;
      } else if (is_current(found->second, record)) {
        table_.records[id] = record;
      }
    }
  }

  // An item that crashed would do so again, and take its neighbors with it.
  bool is_current(std::size_t item, const RemeshRecord& record) const {
    const bool made =
        record.status == Status::ok && record.file == names_[item] && fs::is_regular_file(target(item));
    return (made || record.status == Status::crashed) && record.input.bytes >= 0 &&
           record.input == stamp_of(inputs_.items[item]);
  }

  // The items that an earlier process was at work on when it died, each alone in a child process: those that
  // crash it, too, are recorded as such. It forks, so no thread may have been started.
  void try_suspects() {
    if (!earlier_) return;
    const GraphParameters parameters = graph_parameters(run_);
    for (std::size_t i = 0; i < inputs_.items.size(); ++i) {
      const PlanItem& item = inputs_.items[i];
      if (!earlier_->begun.contains(item.id) || is_made(i)) continue;
      const LoneResult result = try_item_alone(
          item, parameters, [this] { folder_.leave_lock_to_parent(); },
          [this](GraphStages& list) {
            add_remesh_stages(list, run_.sample, options_.mesh, carried_,
                              [](const PlanItem&, const auto&, const auto&) {});
            if (hook_) hook_(list);
          });
      if (!result.crashed) continue;
      RemeshRecord& record = table_.records[item.id];
      record.status = Status::crashed;
      record.message = result.reason;
      record.input = stamp_of(item);
      if (run_.progress != "none" && run_.progress != "json")
        fmt::print(stderr, "{}: crashed: {}\n", item.id, result.reason);
    }
  }

  fs::path target(std::size_t item) const { return folder_.path() / names_[item]; }

  bool is_made(std::size_t item) const { return table_.records.contains(inputs_.items[item].id); }

  void check_outputs() {
    OutputGuard guard;
    guard.protect(input_files(run_.inputs, inputs_.items));
    guard.check_folder(folder_.path(), "-o");
    refuse_nested_folder();
    guard.check(remesh_json_path(folder_.path()), {FileKind::json}, "the table of -o", Existing::replace,
                true);
    guard.check(remesh_csv_path(folder_.path()), {FileKind::csv}, "the table of -o", Existing::replace, true);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const fs::path name(names_[i]);
      if (name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end())
        throw UsageError(fmt::format("the item `{}` names a file outside `{}`: leave it out",
                                     inputs_.items[i].id, folder_.path().string()));
      // What no table names is somebody else's.
      const Existing existing = run_.fresh || is_own(i) ? Existing::replace : Existing::keep;
      guard.check(target(i), {mesh_kind(options_.format)}, "-o", existing, true);
    }
  }

  // The next run would find the meshes of this one among its inputs.
  void refuse_nested_folder() const {
    std::error_code none;
    const fs::path own = fs::weakly_canonical(folder_.path(), none);
    for (const std::string& argument : run_.inputs) {
      if (!fs::is_directory(argument, none)) continue;
      const fs::path input = fs::weakly_canonical(argument, none);
      if (std::mismatch(input.begin(), input.end(), own.begin(), own.end()).first == input.end())
        throw UsageError(fmt::format(
            "-o: `{}` lies in the input folder `{}`, so its meshes would be inputs of the next run: give "
            "another name",
            folder_.path().string(), argument));
    }
  }

  // The items to work on; their inputs are looked at before they are read.
  std::vector<PlanItem> plan() {
    std::vector<PlanItem> items;
    stamps_.resize(inputs_.items.size());
    for (std::size_t i = 0; i < inputs_.items.size(); ++i) {
      if (is_made(i)) continue;
      stamps_[i] = stamp_of(inputs_.items[i]);
      items.push_back(inputs_.items[i]);
    }
    return items;
  }

  GraphStages stages(const EmbreeDevice* device) {
    GraphStages list = sampling_stages(run_.sample, device);
    add_remesh_stages(list, run_.sample, options_.mesh, carried_,
                      [this](const PlanItem& item, const RemeshedSurface& made, const CarriedValues& values) {
                        fs::create_directories(target(item.row).parent_path());
                        write_mesh(target(item.row), options_.format, made.x, made.y, made.z, made.triangles,
                                   values.view());
                        const std::lock_guard lock(made_mutex_);
                        made_[item.row] = {made.report, lacking_text(values, carried_)};
                      });
    if (hook_) hook_(list);
    for (GraphStage& stage : list)
      stage.body = [this, body = std::move(stage.body)](GraphItem& item) { run_or_stop(body, item); };
    return list;
  }

  // A file that cannot be written stops the job.
  void run_or_stop(const std::function<void(GraphItem&)>& body, GraphItem& item) {
    try {
      body(item);
    } catch (const RunError&) {
      stop_for_output();
    } catch (const fs::filesystem_error&) {
      stop_for_output();
    }
  }

  [[noreturn]] void stop_for_output() {
    {
      const std::lock_guard lock(made_mutex_);
      if (!output_error_) output_error_ = std::current_exception();
    }
    *stop_ = true;
    throw RunCanceled();
  }

  // False when it was stopped.
  bool make_meshes() {
    std::vector<PlanItem> items = plan();
    if (items.empty()) return true;
    stop_ = &catch_stop_signals();
    set_allocator_limits(run_.memory_bytes);
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(run_.threads));
    const auto start = Clock::now();
    GraphResult result;
    {
      std::optional<EmbreeDevice> device;
      if (casts_rays(run_.sample)) device.emplace();
      const GraphParameters parameters = graph_parameters(run_);
      const ItemEstimate estimate = estimate_items(
          items, run_.sample, run_.threads, run_.model_bytes, [this](const MeshEstimate& mesh) {
            return remesh_bytes(mesh, run_.sample.samples, options_.mesh.fit, carried_);
          });
      warn_of_unopened(estimate, items.size());
      Progress progress(progress_style(run_.progress), items.size(), total_work(items), run_.threads,
                        header_.samples);
      if (items.size() < inputs_.items.size())
        progress.note(fmt::format("continuing: {} of {} models are done already",
                                  inputs_.items.size() - items.size(), inputs_.items.size()));
      BegunItems rows(folder_, inputs_.items);
      std::vector<NodeStatistics> nodes;
      const GraphStages list = stages(device ? &*device : nullptr);
      result = run_sampling_graph(items, parameters, list, header_, rows, *stop_, nodes,
                                  [&](const FinishedItem& item) {
                                    progress.finished(item);
                                    record(item);
                                  });
    }
    seconds_ = std::chrono::duration<double>(Clock::now() - start).count();
    done_now_ = result.written;
    if (output_error_) {
      folder_.end(table_);
      std::rethrow_exception(output_error_);
    }
    if (result.stopped) say_stopped(result);
    return !result.stopped;
  }

  void record(const FinishedItem& item) {
    RemeshRecord& record = table_.records[item.plan.id];
    record = {};
    record.status = item.report.status;
    record.message = item.report.reason;
    record.seconds = item.seconds;
    record.input = stamps_[item.plan.row];
    if (record.status == Status::ok) {
      {
        const std::lock_guard lock(made_mutex_);
        std::tie(record.mesh, record.lacks) = made_.at(item.plan.row);
        made_.erase(item.plan.row);
      }
      record.message = remesh_message(record.mesh, record.lacks);
      if (const std::string& notes = item.report.note_text; !notes.empty())
        record.message += (record.message.empty() ? "" : "; ") + notes;
      record.file = names_[item.plan.row];
      record.samples = header_.samples;
    } else if (is_own(item.plan.row)) {  // of earlier parameters, or of a file that has changed since
      std::error_code none;
      fs::remove(target(item.plan.row), none);
    }
    folder_.log_record(item.plan.id, record);
  }

  void say_stopped(const GraphResult& result) const {
    fmt::print(stderr, "meander: stopped with {} of {} models done{}; the same command{}{} continues\n",
               items(), inputs_.items.size(),
               result.too_many_failures ? fmt::format(": {} models failed, more than --max-failures {}",
                                                      result.failed, run_.max_failures)
                                        : "",
               run_.fresh ? " without --fresh" : "",
               result.too_many_failures ? " with a larger --max-failures" : "");
  }

  std::uint64_t items() const { return table_.records.size() - vanished_.size(); }

  std::uint64_t failed() const {
    std::uint64_t count = 0;
    for (const auto& [id, record] : table_.records)
      count += record.status != Status::ok && !vanished_.contains(id);
    return count;
  }

  void print_summary() const {
    std::map<Status, std::uint64_t> by_status;
    RemeshReport sum;
    std::uint64_t incomplete = 0, much_lost = 0, crossed = 0, lacking = 0;
    for (const auto& [id, record] : table_.records) {
      if (vanished_.contains(id)) continue;
      ++by_status[record.status];
      sum.vertices += record.mesh.vertices;
      sum.faces += record.mesh.faces;
      sum.line_vertices += record.mesh.line_vertices;
      sum.kept_vertices += record.mesh.kept_vertices;
      sum.crossings += record.mesh.crossings;
      sum.input_crossings += record.mesh.input_crossings;
      crossed += record.mesh.crossings > 0;
      lacking += !record.lacks.empty();
      sum.dropped_components += record.mesh.dropped_components;
      sum.dropped_share = std::max(sum.dropped_share, record.mesh.dropped_share);
      incomplete += record.mesh.dropped_components > 0;
      much_lost += record.mesh.dropped_share > much_of_area;
    }
    if (run_.json) return print_json(by_status, sum, incomplete, much_lost, lacking);
    fmt::print("{}: {}, {} samples each\n", folder_.path().string(), counted(items(), "model", "models"),
               header_.samples);
    for (const auto& [status, count] : by_status) fmt::print("  {:<20}{:>10}\n", name_of(status), count);
    fmt::print("  {} faces, {} vertices: {} beside the samples on boundaries and creases, {} others\n",
               sum.faces, sum.vertices, sum.line_vertices, sum.kept_vertices);
    if (incomplete > 0)
      fmt::print("  {} components without a sample were dropped in {} models (see remesh.csv)\n",
                 sum.dropped_components, incomplete);
    if (much_lost > 0)
      fmt::print(
          "  {} models lost more than {:.0f} % of their area with them, at most {:.0f} %: give more "
          "samples\n",
          much_lost, 100 * much_of_area, 100 * sum.dropped_share);
    if (sum.crossings > 0)
      fmt::print("  {} of triangles cross in {} that do not in the input (see remesh.csv)\n",
                 counted(sum.crossings, "pair", "pairs"), counted(crossed, "model", "models"));
    if (lacking > 0)
      fmt::print("  {} {} not all that the vertices should carry (see `lacks` in remesh.csv)\n",
                 counted(lacking, "model", "models"), lacking == 1 ? "has" : "have");
    if (!vanished_.empty())
      fmt::print("  {} of an earlier run {} no input any more; their rows and meshes were left\n",
                 counted(vanished_.size(), "item", "items"), vanished_.size() == 1 ? "has" : "have");
    print_notes(inputs_.notes);
    if (done_now_ > 0) fmt::print("  {} in {:.2f} s\n", counted(done_now_, "model"), seconds_);
  }

  void print_json(const std::map<Status, std::uint64_t>& by_status, const RemeshReport& sum,
                  std::uint64_t incomplete, std::uint64_t much_lost, std::uint64_t lacking) const {
    JsonWriter json;
    json.begin_object();
    json.member("folder", escape_id(folder_.path().string()));
    json.member("items", items());
    json.member("done_now", done_now_);
    json.member("seconds", seconds_);
    json.key("statuses");
    json.begin_object();
    for (const auto& [status, count] : by_status) json.member(name_of(status), count);
    json.end_object();
    json.member("vertices", sum.vertices);
    json.member("faces", sum.faces);
    json.member("line_vertices", sum.line_vertices);
    json.member("kept_vertices", sum.kept_vertices);
    json.member("crossings", sum.crossings);
    json.member("input_crossings", sum.input_crossings);
    json.member("dropped_components", sum.dropped_components);
    json.member("models_with_dropped_components", incomplete);
    json.member("models_with_much_area_dropped", much_lost);
    json.member("largest_dropped_share", sum.dropped_share);
    json.member("models_that_lack_values", lacking);
    json.member("vanished", std::uint64_t{vanished_.size()});
    write_notes(json, inputs_.notes);
    json.end_object();
    fmt::print("{}\n", json.text());
  }

  RemeshOptions& options_;
  RunOptions& run_;
  const CarriedColumns carried_;
  RemeshFolder folder_;
  const StageHook& hook_;
  Inputs inputs_;
  StoreHeader header_;
  std::vector<std::string> names_;      // of the meshes, by item
  std::set<std::string> own_files_;     // see list_own_files
  std::optional<RemeshTable> earlier_;  // that an earlier process left
  RemeshTable table_;                   // touched by the serial writer alone while the graph runs
  std::set<std::string> vanished_;      // ids of the table that have no input any more; their meshes stay
  std::vector<InputStamp> stamps_;      // of the items that are worked on, by row
  std::uint64_t done_now_ = 0;
  double seconds_ = 0;
  std::atomic<bool>* stop_ = nullptr;
  std::mutex made_mutex_;
  std::map<std::uint64_t, std::pair<RemeshReport, std::string>> made_;  // written, not yet recorded; by row
  std::exception_ptr output_error_;
};

}  // namespace

JobFunction add_remesh_job(Command& program, StageHook hook) {
  auto options = std::make_shared<RemeshOptions>();
  const Command command = add_remesh_command(program, *options);
  return with_failures_option(command.under("Report"), [options, hook = std::move(hook)] {
    resolve_remesh_options(*options);
    return RemeshJob(*options, hook).run();
  });
}

}  // namespace meander
