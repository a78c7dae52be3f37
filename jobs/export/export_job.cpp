// meander export: points of a store as files that other programs read.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "io/file/atomic_file.h"
#include "io/file/file_error.h"
#include "io/item_id.h"
#include "io/json_writer.h"
#include "io/store/pointnet_export.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/working_process.h"
#include "jobs/export/export_arrays.h"
#include "jobs/export/export_descriptors.h"
#include "jobs/export/export_format.h"
#include "jobs/export/export_page.h"
#include "jobs/export/training_schema.h"
#include "jobs/inputs/store_items.h"
#include "meander_version.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  std::string store, output;
  std::vector<std::string> items;
  std::string format;  // empty: that of the ending of the output, else PLY
  std::string frame;   // empty: that of the format
  bool pointnet = false;
  std::uint32_t shard_rows = 2048;
  DescriptorExport descriptors;
  ArrayExport arrays;
  PageExport page;
  bool fresh = false;

  Existing existing() const { return fresh ? Existing::replace : Existing::keep; }
  ExportContent content() const { return export_format(format).content; }
  // Point files have the coordinates of the model's file, arrays for training those of the store.
  PointFrame point_frame() const {
    if (!frame.empty()) return value_of(frame_words, frame);
    return pointnet || content() == ExportContent::arrays ? PointFrame::stored : PointFrame::file;
  }
  StoreCheck check = StoreCheck::every_byte;
  std::uint64_t store_bytes = 0;  // facts of the store before it was opened
  std::int64_t store_modified_ns = 0;
};

// The format that the ending of an output gives, which then names a file; null: a folder, or any name.
const ExportFormat* file_format(const fs::path& output) {
  std::error_code none;
  return fs::is_directory(output, none) ? nullptr
                                        : format_of_ending(lower_ascii(output.extension().string()));
}

// Takes the format from the ending of the output where none was asked for.
void settle_format(ExportOptions& options) {
  const ExportFormat* const file = options.pointnet ? nullptr : file_format(options.output);
  if (options.format.empty() && !options.arrays.schema.empty()) options.format = "npz";
  if (options.format.empty()) {
    options.format = file != nullptr ? file->word : "ply";
    return;
  }
  const ExportFormat& asked = export_format(options.format);
  if (file != nullptr && file != &asked && asked.content != ExportContent::descriptors)
    throw UsageError(fmt::format(
        "-o: `{}` ends in {}, but --format {} was asked for: give {}", options.output, file->ending,
        asked.word,
        asked.ending.empty() ? "a folder" : fmt::format("a name in {}, or a folder", asked.ending)));
}

// The rows asked for, or all ok rows.
std::vector<std::uint64_t> chosen_rows(const StoreReader& store, const std::vector<std::string>& items) {
  std::vector<std::uint64_t> rows;
  for (const std::string& item : items) {
    rows.push_back(find_item(store, item));
    const ItemReport report = store.report(rows.back());
    if (report.status != Status::ok)
      throw UsageError(
          fmt::format("`{}` has no points: {}: {}", item, name_of(report.status), report.reason));
  }
  if (items.empty())
    for (std::uint64_t row = 0; row < store.rows(); ++row)
      if (store.report(row).status == Status::ok) rows.push_back(row);
  return rows;
}

// Ids come from a file that anybody may have made: none leads out of the folder.
fs::path path_below(const fs::path& folder, const std::string& id, const std::string& extension) {
  const fs::path relative(id);
  if (id.empty() || relative.is_absolute() || id.find('\0') != std::string::npos ||
      std::find(relative.begin(), relative.end(), "..") != relative.end())
    throw UsageError(
        fmt::format("the item `{}` names a file outside `{}`: nothing is exported; name the items "
                    "to export without it",
                    id, folder.string()));
  return folder / shortened_parts(id + extension);
}

// All that decides the files of an export and what they hold.
std::string parameters_of(const StoreReader& store, const ExportOptions& options,
                          const std::vector<std::string>& arrays = {}) {
  JsonWriter json;
  json.begin_object();
  json.member("store", escape_id(fs::weakly_canonical(options.store).string()));
  json.member("store_bytes", options.store_bytes);
  json.member("store_modified_ns", options.store_modified_ns);
  json.member("rows", store.rows());
  const auto list = [&json](const char* name, const std::vector<std::string>& texts) {
    json.key(name);
    json.begin_array();
    for (const std::string& text : texts) json.value(text);
    json.end_array();
  };
  list("items", options.items);
  json.member("program", std::string(meander_version));
  json.member("format", options.pointnet ? std::string("pointnet") : options.format);
  list("arrays", arrays);
  json.member("frame", name_of(options.point_frame()));
  if (options.pointnet) json.member("shard_rows", options.shard_rows);
  if (options.format == "webdataset") {
    json.member("stem", escape_id(fs::path(options.store).stem().string()));  // of the names of the shards
    json.member("shard_bytes", options.arrays.shard_bytes);
  }
  json.end_object();
  return json.text();
}

int say_stopped(const ExportOptions& options, const std::string& how_far) {
  fmt::print(stderr, "meander: stopped {}; the same command{} continues\n", how_far,
             options.fresh ? " without --fresh" : "");
  return exit_stopped;
}

// A file of an export: what is written there of which row.
struct PlannedFile {
  fs::path path;
  std::uint64_t row = 0;
  std::size_t number = 0;  // among the files of the row
};

// Calls write(put, file) for all files that an earlier process has not made, in their order, and ends the
// export. False where a signal stopped it, which it says.
template <class Write>
bool write_planned(const std::vector<PlannedFile>& files, const ExportOptions& options,
                   UnfinishedExport& unfinished, const Write& write) {
  if (unfinished.begin()) {
    std::set<std::string> names;
    for (const PlannedFile& file : files) names.insert(file.path.lexically_relative(options.output).string());
    remove_temporaries(options.output, names);
  }
  const std::atomic<bool>& stop = catch_stop_signals();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const PlannedFile& file = files[i];
    if (stop) {
      say_stopped(options, fmt::format("with {} of {} files written", i, files.size()));
      return false;
    }
    if (unfinished.has_made(file.path)) continue;
    std::error_code error;
    fs::create_directories(file.path.parent_path(), error);
    if (error) throw_file_error(error.value(), "create", file.path.parent_path(), FullDisk::stops_run);
    AtomicFile out(file.path, FullDisk::stops_run);
    write([&out](std::string_view bytes) { out.append(bytes); }, file);
    out.commit();
  }
  unfinished.end();
  return true;
}

int export_points(const StoreReader& store, const std::vector<std::uint64_t>& rows,
                  const ExportOptions& options, OutputGuard& guard) {
  const std::vector<std::string> arrays = chosen_arrays(store, options.arrays);
  if (options.format == "xyz") store.require(&Samples::normals, "--format xyz");
  const auto write_row = [&](const PutBytes& put, std::uint64_t row) {
    const Row content = store.read_row(row);
    if (options.format == "npz")
      return write_npz(put, store.columns(), arrays, options.point_frame(), content, store.id(row));
    write_points(put, export_format(options.format).points, content.samples, content.report,
                 options.point_frame());
  };
  if (options.output == standard_output) {
    if (rows.size() != 1)
      throw UsageError(
          fmt::format("-o - takes the points of one item, not of {}: name the item", rows.size()));
    write_row(print_bytes, rows.front());
    return exit_done;
  }
  if (file_format(options.output) != nullptr) {
    if (rows.size() != 1)
      throw UsageError(fmt::format(
          "-o: `{}` is one file, but {} items {}: name the item behind the store, or give a folder",
          options.output, rows.size(), options.items.empty() ? "of the store have points" : "are named"));
    guard.check(options.output, {export_format(options.format).kind}, "-o", options.existing());
    AtomicFile file(options.output, FullDisk::ends_command);
    write_row([&file](std::string_view bytes) { file.append(bytes); }, rows.front());
    file.commit();
    fmt::print("{}: {} points of `{}`\n", options.output, store.samples(), store.id(rows.front()));
    return exit_done;
  }
  UnfinishedExport unfinished(options.output, parameters_of(store, options, arrays), options.fresh, guard);
  std::vector<PlannedFile> files;
  for (const std::uint64_t row : rows) {
    files.push_back(
        {path_below(options.output, store.id(row), std::string(export_format(options.format).ending)), row});
    if (*fs::path(store.id(row)).begin() == UnfinishedExport::description_name)
      throw UsageError(
          fmt::format("the item `{}` has the name of the description of the export, `{}`: name the "
                      "items to export without it",
                      store.id(row), UnfinishedExport::description_name));
    guard.check(files.back().path, {export_format(options.format).kind}, "-o", unfinished.existing(), true);
  }
  if (!write_planned(files, options, unfinished,
                     [&](const PutBytes& put, const PlannedFile& file) { write_row(put, file.row); }))
    return exit_stopped;
  fmt::print("{} files in {}\n", rows.size(), options.output);
  return exit_done;
}

// A schema, and the rows that it has anything of.
struct SchemaRows {
  SchemaChoice schema;
  std::vector<std::uint64_t> rows;
  std::uint64_t left_out = 0, dropped = 0;  // models, and points of the others

  void say_left_out() const {
    if (dropped > 0) fmt::print("{} points without a certain side were left out\n", dropped);
    if (left_out > 0)
      fmt::print("{} {} left out: no point has a certain side (--uncertain keep)\n", left_out,
                 left_out == 1 ? "model was" : "models were");
  }
};

SchemaRows schema_rows(const StoreReader& store, const std::vector<std::uint64_t>& rows,
                       const ArrayExport& options) {
  SchemaRows chosen;
  chosen.schema = {value_of(schema_words, options.schema), value_of(uncertain_words, options.uncertain)};
  require_schema(store, chosen.schema.kind);
  const std::uint32_t queries = store.columns().points_of(PointSet::queries, 0);
  for (const std::uint64_t row : rows) {
    const ItemReport report = store.report(row);
    if (!has_sides(report, queries, chosen.schema.uncertain)) {
      ++chosen.left_out;
      continue;
    }
    chosen.rows.push_back(row);
    chosen.dropped += chosen.schema.uncertain == UncertainChoice::drop ? report.uncertain : 0;
  }
  return chosen;
}

// In place of the names of arrays.
std::vector<std::string> schema_parameters(const ArrayExport& options) {
  return {"schema " + options.schema, options.uncertain};
}

// The files of a schema for every row, in a folder.
int export_schema(const StoreReader& store, const std::vector<std::uint64_t>& rows,
                  const ExportOptions& options, OutputGuard& guard) {
  const SchemaRows chosen = schema_rows(store, rows, options.arrays);
  UnfinishedExport unfinished(
      options.output, parameters_of(store, options, schema_parameters(options.arrays)), options.fresh, guard);
  std::vector<PlannedFile> files;
  for (const std::uint64_t row : chosen.rows) {
    const std::vector<std::string> names = schema_files(chosen.schema.kind, store.id(row));
    for (std::size_t number = 0; number < names.size(); ++number) {
      files.push_back({path_below(options.output, names[number], ""), row, number});
      const FileKind kind = files.back().path.extension() == ".npy" ? FileKind::npy : FileKind::zip;
      guard.check(files.back().path, {kind}, "-o", unfinished.existing(), true);
    }
  }
  std::optional<Row> content;  // of the row of the file before
  std::uint64_t row_of_content = 0;
  if (!write_planned(files, options, unfinished, [&](const PutBytes& put, const PlannedFile& file) {
        if (!content || row_of_content != file.row) {
          content.reset();
          content = store.read_row(file.row);
          row_of_content = file.row;
        }
        write_schema_file(put, store.columns(), chosen.schema, file.number, *content, store.id(file.row));
      }))
    return exit_stopped;
  fmt::print("{} files of {} models in {}\n", files.size(), chosen.rows.size(), options.output);
  chosen.say_left_out();
  return exit_done;
}

// All files of an earlier export, whatever their number: those that are not written again are removed.
void check_pointnet_files(const ExportOptions& options, Existing existing, OutputGuard& guard) {
  for (const fs::path& file : pointnet_files(options.output)) {
    const fs::path extension = file.extension();
    if (extension == ".h5")
      guard.check(file, {FileKind::hdf5}, "-o", existing);
    else if (extension == ".json")
      guard.check(file, {FileKind::json}, "-o", existing);
    else
      guard.check(file, {FileKind::text, FileKind::csv}, "-o", existing);
  }
}

int export_shards(const StoreReader& store, const ExportOptions& options, OutputGuard& guard) {
  require_pointnet_rows(store);
  UnfinishedExport unfinished(options.output, parameters_of(store, options), options.fresh, guard);
  check_pointnet_files(options, unfinished.existing(), guard);
  if (unfinished.begin())
    remove_temporaries(options.output, [](const std::string& name) { return is_pointnet_file(name); });
  const PointnetCounts counts = export_pointnet(store, options.output, options.shard_rows,
                                                &catch_stop_signals(), options.point_frame());
  unfinished.end();
  fmt::print("PointNet shards in {}: {} rows for training, {} for tests, {} for validation\n", options.output,
             counts.train, counts.test, counts.validation);
  if (counts.unlabeled > 0) fmt::print("{} rows without a class were left out\n", counts.unlabeled);
  return exit_done;
}

int export_arrays(const StoreReader& store, const std::vector<std::uint64_t>& rows,
                  const ExportOptions& options, OutputGuard& guard) {
  WebdatasetExport wanted{.stem = fs::path(options.store).stem().string(),
                          .folder = options.output,
                          .arrays = {},
                          .most_bytes = parse_bytes(options.arrays.shard_bytes),
                          .frame = options.point_frame(),
                          .schema = {}};
  SchemaRows chosen;
  if (options.arrays.schema.empty()) {
    wanted.arrays = chosen_arrays(store, options.arrays);
    chosen.rows = rows;
  } else {
    chosen = schema_rows(store, rows, options.arrays);
    wanted.schema = chosen.schema;
  }
  UnfinishedExport unfinished(
      options.output,
      parameters_of(store, options, wanted.schema ? schema_parameters(options.arrays) : wanted.arrays),
      options.fresh, guard);
  const std::vector<fs::path> earlier = webdataset_files(wanted);
  for (const fs::path& file : earlier) guard.check(file, {FileKind::tar}, "-o", unfinished.existing());
  if (unfinished.begin())
    remove_temporaries(options.output,
                       [&](const std::string& name) { return is_webdataset_file(name, wanted.stem); });
  if (!export_webdataset(store, chosen.rows, wanted, catch_stop_signals()))
    return say_stopped(options, "before all shards were written");
  unfinished.end();
  chosen.say_left_out();
  return exit_done;
}

int export_store(ExportOptions& options) {
  std::error_code error;  // opening it says what is wrong
  options.store_bytes = fs::file_size(options.store, error);
  options.store_modified_ns = fs::last_write_time(options.store, error).time_since_epoch().count();
  const StoreReader store(options.store, options.check);
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  if (!options.page.output.empty()) {
    PageExport wanted = options.page;
    if (!options.items.empty()) wanted.rows = chosen_rows(store, options.items);
    wanted.existing = options.existing();
    return export_page(store, fs::path(options.store).filename().string(), wanted, guard);
  }
  if (options.content() == ExportContent::descriptors) {
    DescriptorExport wanted = options.descriptors;
    wanted.store = options.store;
    wanted.format = options.format;
    wanted.output = options.output;
    if (!options.items.empty()) wanted.rows = chosen_rows(store, options.items);
    wanted.existing = options.existing();
    return export_descriptors(store, wanted, guard);
  }
  if (options.pointnet) return export_shards(store, options, guard);
  std::vector<std::uint64_t> rows = chosen_rows(store, options.items);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  if (options.format == "webdataset") return export_arrays(store, rows, options, guard);
  if (!options.arrays.schema.empty()) return export_schema(store, rows, options, guard);
  return export_points(store, rows, options, guard);
}

}  // namespace

JobFunction add_export_job(Command& program) {
  Command command = program.add_subcommand("export",
                                           "Points of a store as PLY, OFF, XYZ or npz files, WebDataset or "
                                           "PointNet shards, or an HTML page to turn "
                                           "models in; descriptors as CSV, fbin, npy or HDF5");
  command.example("meander export store.h5 -o points", "A PLY file of points for every model");
  command.example("meander export store.h5 --html page.html", "One page to turn the models in");
  auto options = std::make_shared<ExportOptions>();
  command.add_option("STORE", options->store, "The store").required();
  command.add_option("ITEM", options->items, "Ids or row numbers (default: all ok items)");
  const Option output =
      command
          .add_option("-o,--output", options->output,
                      "Output folder, created if missing; for one item also a file, as c.ply; with "
                      "--descriptors the output file; -: the points of one item, or the CSV of "
                      "descriptors, on standard output")
          .common();
  std::vector<std::string> words;
  for (const ExportFormat& known : export_formats) words.emplace_back(known.word);
  const Option format =
      command.add_option("--format", options->format, "Of the point files, or of the file of descriptors")
          .show_default("by the ending of -o, else ply")
          .common()
          .one_of(words);
  command
      .add_option(
          "--frame", options->frame,
          fmt::format(
              "Coordinates of the points: file, those of the model's file (the default of {}), or "
              "stored, those of the store, as --normalize of the run made them (the default of {} and "
              "--pointnet); each file says which it has",
              formats_with(ExportContent::points, "and"), formats_with(ExportContent::arrays)))
      .one_of(all_words(frame_words));
  const Option pointnet = command
                              .add_flag("--pointnet", options->pointnet,
                                        "HDF5 shards for PointNet-style loaders: all ok rows with a class, "
                                        "training and test rows in separate files")
                              .common()
                              .excludes(format);
  command.add_option("--shard-rows", options->shard_rows, "Rows per PointNet shard, 1 to 1000000")
      .show_default()
      .range(1, 1000000)
      .needs(pointnet);
  command.add_flag("--fresh", options->fresh, "Replace files of an earlier export").common();
  add_array_export_options(command, options->arrays);
  add_descriptor_export_options(command, options->descriptors);
  add_page_export_options(command, options->page).excludes(format).excludes(pointnet).excludes(output);
  add_trust_option(command, options->check);
  return [options] {
    settle_format(*options);
    check_descriptor_export(options->descriptors, options->format, options->output);
    check_array_export(options->arrays, options->format);
    if (options->page.shapes_page && options->page.output.empty())
      throw UsageError("--models and --points apply to --html only");
    if (!options->frame.empty() && (!options->page.output.empty() ||
                                    (!options->pointnet && options->content() == ExportContent::descriptors)))
      throw UsageError(
          "--frame applies to points in files and shards; the page of --html has stored points, descriptors "
          "have "
          "no frame");
    if (options->output.empty() && options->page.output.empty())
      throw UsageError("export needs -o FOLDER, or --html FILE");
    if (options->pointnet && options->output == standard_output)
      throw UsageError("PointNet shards are several files: -o FOLDER");
    if (options->format == "webdataset" && options->output == standard_output)
      throw UsageError("WebDataset shards are several files: -o FOLDER");
    if (!options->arrays.schema.empty() &&
        (options->output == standard_output || file_format(options->output) != nullptr))
      throw UsageError("the files of --schema have names of their own: -o FOLDER");
    if (!options->arrays.schema.empty() && !options->frame.empty())
      throw UsageError("--schema says what coordinates are: leave --frame out");
    if (options->pointnet && !options->items.empty())
      throw UsageError("--pointnet exports all ok rows: leave the items out");
    return export_store(*options);
  };
}

}  // namespace meander
