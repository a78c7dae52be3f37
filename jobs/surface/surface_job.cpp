// meander surface samples parametric surfaces into a store.
#include <fmt/format.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <new>
#include <utility>

#include "io/digest.h"
#include "io/file/file_bytes.h"
#include "io/image/png_reader.h"
#include "io/json_writer.h"
#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/settings.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/working_process.h"
#include "jobs/inputs/surface_sources.h"
#include "jobs/rows/column_options.h"
#include "kernels/core/expression.h"
#include "kernels/core/failure.h"
#include "kernels/core/joined_texts.h"
#include "kernels/core/parallel.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface_row.h"

namespace meander {

namespace {

namespace fs = std::filesystem;
namespace tbb = oneapi::tbb;

struct SurfaceOptions {
  std::vector<std::string> surfaces;
  std::string store;
  SurfaceSampleParameters sample;
  Compression compression = Compression::standard;
  std::vector<std::string> stored;  // --store
  StoreColumns columns = {.rows = RowKind::surfaces};
  HeightFieldOptions height_field;
  SettingOptions settings;  // refers to the members above
  bool fresh = false, json = false;
};

using StoreSettings = SettingList<SurfaceOptions>;

bool has_height_fields(const SurfaceOptions& options) {
  return std::any_of(options.surfaces.begin(), options.surfaces.end(), [](const std::string& surface) {
    return surface_kind(surface) == SurfaceKind::height_field;
  });
}
constexpr const char* of_height_fields = "applies to height fields, and no surface is a .png file";

// The settings of the store and of height fields.
const StoreSettings& store_settings() {
  static const StoreSettings list = [] {
    StoreSettings made;
    made.number(
            "height_scale", "--height-scale", [](auto& o) -> auto& { return o.height_field.scale; }, 0, 0,
            "Height of white in a PNG height field")
        .acting(has_height_fields, of_height_fields);
    made.number(
            "height_extent_x", "--height-width", [](auto& o) -> auto& { return o.height_field.extent_x; }, 0,
            0, "Extent of a height field in x, > 0")
        .acting(has_height_fields, of_height_fields);
    made.number(
            "height_extent_y", "--height-depth", [](auto& o) -> auto& { return o.height_field.extent_y; }, 0,
            0, "Extent of a height field in y, > 0")
        .acting(has_height_fields, of_height_fields);
    made.word(
        "compress", "--compress", [](auto& o) -> auto& { return o.compression; }, compression_words,
        "shuffle + deflate + checksum, or checksum only");
    // Its option is added by add_store_columns_option.
    made.constant("store", [](const SurfaceOptions& o) { return stored_words(o.columns); })
        .only_recorded([](const SurfaceOptions& o) { return !o.columns.left_out.empty(); });
    return made;
  }();
  return list;
}

void resolve(SurfaceOptions& options) {
  std::vector<std::string> problems;
  options.settings.finish(problems);
  if (problems.empty()) problems = validate(options.sample);
  options.columns.left_out = parse_left_out(options.stored, options.columns, problems);
  if (!problems.empty()) throw UsageError(joined_texts(problems, "\n"));
}

std::string recorded_parameters(const SurfaceOptions& options) {
  RecordedSettings recorded;
  record(surface_settings(), options.sample, recorded);
  record(store_settings(), options, recorded);
  return json_of(std::move(recorded));
}

struct SurfaceRun {
  std::string id;
  Row row;
  std::uint64_t patches = 0, leaves = 0, unresolved_patches = 0, bound_violations = 0;
  double seconds = 0;
  bool done_before = false;  // by an earlier process; patches and leaves are then unknown
};

// Samples a surface; one that cannot be sampled becomes a row with its status, as in `meander run`.
SurfaceRun sample_one(const std::string& argument, const SurfaceOptions& options,
                      const std::atomic<bool>& stop) {
  SurfaceRun run;
  run.id = surface_id(argument);
  const auto start = std::chrono::steady_clock::now();
  try {
    const SurfaceSource source = open_surface(argument, options.height_field);
    run.row.report.content_sha256 = source.content_sha256;
    SurfaceSamples samples = sample_surface(*source.surface, options.sample, {.canceled = &stop});
    run.patches = samples.patches;
    run.leaves = samples.leaves;
    run.unresolved_patches = samples.unresolved_patches;
    run.bound_violations = samples.bound_violations;
    run.row = surface_row(*source.surface, std::move(samples));
    run.row.report.content_sha256 = source.content_sha256;
  } catch (const RunCanceled&) {
    throw;
  } catch (...) {
    Failure failure = current_failure("sample_surface");
    run.row.report.status = failure.status;
    run.row.report.reason = std::move(failure.reason);
    run.row.samples = {};
  }
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run;
}

void print_runs(const std::vector<SurfaceRun>& runs, const SurfaceOptions& options) {
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("store", options.store);
                 json.member("samples", options.sample.samples);
                 json.list("surfaces", runs, [&](const SurfaceRun& run) {
                   json.member("id", run.id);
                   json.member("status", name_of(run.row.report.status));
                   json.member("reason", run.row.report.reason);
                   json.member("area", run.row.report.area);
                   json.member("measure", run.row.report.measure);
                   json.member("notes", run.row.report.note_text);
                   if (run.done_before) {
                     json.member("done_before", true);
                   } else {
                     json.member("patches", run.patches);
                     json.member("leaves", run.leaves);
                     json.member("unresolved_patches", run.unresolved_patches);
                     json.member("bound_violations", run.bound_violations);
                     json.member("seconds", run.seconds);
                   }
                 });
               }));
    return;
  }
  for (const SurfaceRun& run : runs) {
    const ItemReport& report = run.row.report;
    if (run.unresolved_patches + run.bound_violations > 0)
      fmt::print(stderr,
                 "{}: --tolerance was not met: {} of {} patches are too coarse and {} draws exceeded their "
                 "bound, so parts of the surface may have larger errors\n",
                 run.id, run.unresolved_patches, run.patches, run.bound_violations);
    if (!report.note_text.empty()) fmt::print(stderr, "{}: {}\n", run.id, report.note_text);
    if (report.status == Status::ok && run.done_before)
      fmt::print("{}: {} points, area {:.9g}, measure {:.9g}, done before\n", run.id, options.sample.samples,
                 report.area, report.measure);
    else if (report.status == Status::ok)
      fmt::print("{}: {} points, area {:.9g}, measure {:.9g}, {} patches, {} leaves, {:.2f} s\n", run.id,
                 options.sample.samples, report.area, report.measure, run.patches, run.leaves, run.seconds);
    else
      fmt::print("{}: {}: {}\n", run.id, name_of(report.status), report.reason);
  }
}

void check_output(const SurfaceOptions& options) {
  OutputGuard guard;
  for (const std::string& surface : options.surfaces) {
    if (surface_kind(surface) == SurfaceKind::formula) continue;
    if (!fs::exists(surface)) throw UsageError("there is no `" + surface + "`");
    guard.protect(surface);
  }
  check_store_output(options.store, options.fresh, guard);
  if (!options.fresh) refuse_finished_store(options.store, RunPurpose::surfaces);
}

// Samples the rows that an earlier process has not done, several at once, and writes each when it is done.
// False when it was asked to stop; the rows written until then are kept.
bool sample_rows(const SurfaceOptions& options, const StoreHeader& header, const std::atomic<bool>& stop,
                 RunDirectory& directory, std::vector<SurfaceRun>& runs) {
  using tbb::filter_mode;
  // Rows in work are held in memory with their pictures, so few large ones are in work at once; while samples
  // are relaxed they take nine times as much.
  const std::uint64_t max_points_held = options.sample.finish == FinishKind::none ? 1 << 22 : 1 << 19;
  require_task_memory();
  const auto threads = static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
  const std::uint64_t at_once =
      has_height_fields(options)
          ? 1
          : std::clamp<std::uint64_t>(max_points_held / options.sample.samples, 1, threads);
  std::uint64_t next = 0;
  const auto next_row = [&](tbb::flow_control& control) {
    while (next < runs.size() && runs[next].done_before) ++next;
    if (next == runs.size()) control.stop();
    return next++;
  };
  const auto sample = [&](std::uint64_t row) {
    runs[row] = sample_one(options.surfaces[row], options, stop);
    return row;
  };
  const auto write = [&](std::uint64_t row) {
    directory.begin_item(row);
    directory.end_item(encode_row(header, row, runs[row].row));
    runs[row].row.samples = {};
  };
  try {
    tbb::parallel_pipeline(
        at_once, tbb::make_filter<void, std::uint64_t>(filter_mode::serial_in_order, next_row) &
                     tbb::make_filter<std::uint64_t, std::uint64_t>(filter_mode::parallel, sample) &
                     tbb::make_filter<std::uint64_t, void>(filter_mode::serial_out_of_order, write));
  } catch (const RunCanceled&) {
    return false;
  }
  return true;
}

int sample_surfaces(SurfaceOptions& options) {
  resolve(options);
  std::vector<std::pair<std::string, std::string>> by_id;
  for (const std::string& surface : options.surfaces) {
    check_surface_name(surface);
    by_id.emplace_back(surface_id(surface), surface);
  }
  std::ranges::sort(by_id);
  StoreHeader header;
  header.columns = options.columns;
  header.samples = options.sample.samples;
  header.compression = options.compression;
  header.seed = options.sample.seed;
  header.order = text_of(order_words, options.sample.order);
  header.parameters_json = recorded_parameters(options);
  options.surfaces.clear();
  for (auto& [id, surface] : by_id) {
    header.ids.push_back(id);
    header.labels.push_back(-1);
    options.surfaces.push_back(std::move(surface));
    if (header.ids.size() > 1 && header.ids.back() == header.ids[header.ids.size() - 2])
      throw UsageError("two surfaces have the id `" + header.ids.back() + "`: leave one out");
  }
  check_output(options);
  const std::atomic<bool>& stop = catch_stop_signals();
  if (options.fresh) discard_run(options.store);
  RunDirectory directory(options.store, RunPlan{header, RunPurpose::surfaces});
  std::vector<SurfaceRun> runs(options.surfaces.size());
  for (std::uint64_t row = 0; row < runs.size(); ++row) {
    runs[row].id = header.ids[row];
    runs[row].done_before = directory.done(row);
  }
  if (!sample_rows(options, header, stop, directory, runs)) {
    directory.sync();
    std::size_t done = 0;
    for (std::uint64_t row = 0; row < runs.size(); ++row) done += directory.done(row) ? 1 : 0;
    fmt::print(stderr, "meander: stopped with {} of {} surfaces done; the same command continues{}\n", done,
               runs.size(), options.fresh ? " without --fresh" : "");
    return exit_stopped;
  }
  bool failed = false;
  directory.finish();
  const StoreReader store(options.store, StoreCheck::none);
  for (std::uint64_t row = 0; row < runs.size(); ++row) {
    if (runs[row].done_before) runs[row].row.report = store.report(row);
    failed = failed || runs[row].row.report.status != Status::ok;
  }
  print_runs(runs, options);
  return failed ? exit_some_failed : exit_done;
}

void add_surface_options(Command& command, SurfaceOptions& options) {
  std::string names;
  for (const std::string_view name : surface_names())
    names += (names.empty() ? "" : ", ") + std::string(name);
  command
      .add_option("SURFACE", options.surfaces,
                  "Names (" + names +
                      "), formulas for x, y, z in u and v of [0, 1], as \"u, v, sin(6*u)\", FILE.nurbs "
                      "(control net as text), FILE.png (height field)")
      .required();
  command.add_option("-o,--output", options.store, "The store to write (HDF5)").required();
  options.settings.add(command, surface_settings(), options.sample);
  options.settings.add(command, store_settings(), options);
  add_store_columns_option(command, RowKind::surfaces, options.stored);
  command.add_flag("--fresh", options.fresh, "Replace the store if it exists");
  command.add_flag("--json", options.json, "The summary as JSON");
}

}  // namespace

JobFunction add_surface_job(Command& program) {
  Command command =
      program.add_subcommand("surface", "Sample parametric surfaces into one store (/uv instead of /face)");
  command.example("meander surface torus -o torus.h5 -n 4096", "One of the named surfaces");
  command.example("meander surface \"u, v, sin(6*u)/6\" -o waves.h5 -n 4096 --density mean",
                  "A formula for x, y, z in u and v of [0, 1], with more points where the surface bends");
  auto options = std::make_shared<SurfaceOptions>();
  add_surface_options(command, *options);
  return with_failures_option(command, [options] { return sample_surfaces(*options); });
}

}  // namespace meander
