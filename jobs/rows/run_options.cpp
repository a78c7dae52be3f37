#include "jobs/rows/run_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "io/store/run_array.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/attribute_types.h"
#include "jobs/rows/column_options.h"
#include "jobs/rows/laboratory.h"
#include "kernels/core/joined_texts.h"
#include "kernels/model/sample_settings.h"

namespace meander {

StoreColumns columns_of(const RunOptions& options) {
  StoreColumns columns;
  columns.tensors = method_of(options.sample).follows_tensor;
  columns.asked = options.sample.columns;
  columns.attributes = options.sample.attributes;
  columns.left_out = options.left_out;
  columns.counts[static_cast<std::size_t>(PointSet::sharp)] = options.sample.sharp.samples;
  const QueryParameters& queries = options.sample.queries;
  columns.counts[static_cast<std::size_t>(PointSet::queries)] = query_count(queries.terms);
  if (queries.any()) {
    columns.sides = queries.sign != SignChoice::none;
    columns.nearest = queries.nearest;
    columns.halves = queries.halves;
    for (const QueryGroup& group : query_groups(queries.terms)) columns.query_groups.push_back(group.name);
  }
  return columns;
}

namespace {

using RunSettings = SettingList<RunOptions>;

// The settings of rows, beside those of their samples.
const RunSettings& row_settings() {
  static const RunSettings list = [] {
    RunSettings made;
    made.under("Collection");
    made.flag(
        "certify", "--certify", [](auto& options) -> auto& { return options.certify; },
        "Measure the samples of every model: error over rotated boxes beside the least possible, rho "
        "(/certificate)");
    made.word(
        "compress", "--compress", [](auto& options) -> auto& { return options.compression; },
        compression_words, "shuffle + deflate + checksum, or checksum only");
    // The option is one of columns: see add_store_columns_option.
    made.constant("store", [](const RunOptions& options) { return stored_words(columns_of(options)); })
        .only_recorded([](const RunOptions& options) { return !options.left_out.empty(); });
    return made;
  }();
  return list;
}

void check_tensor(const RunOptions& options, const std::string& folder, std::vector<std::string>& problems) {
  if (!method_of(options.sample).follows_tensor) return;
  const TensorParameters& tensor = options.sample.tensor;
  if (tensor.kind == TensorKind::table &&
      !std::filesystem::exists(std::filesystem::path(folder) / tensor.attribute))
    problems.push_back("--tensor: no such file or folder: `" + tensor.attribute + "`");
  const bool curved = tensor.kind == TensorKind::curvature;
  if (!curved && (tensor.adaptive || tensor.smoothing != TensorParameters{}.smoothing))
    problems.push_back("--tensor-density and --tensor-smoothing apply to --tensor curvature only");
  if ((curved || tensor.kind == TensorKind::isotropic) && tensor.form != TensorForm::spacing)
    problems.push_back(fmt::format("--tensor-form applies to given tensors; {} has none",
                                   curved ? "curvature" : "isotropic"));
}

void check_attributes(const RunOptions& options, std::vector<std::string>& problems) {
  for (const AttributeColumn& column : options.sample.attributes)
    if (const std::string problem = attribute_name_problem(column.name); !problem.empty())
      problems.push_back(fmt::format("--attribute: `{}` {}", column.name, problem));
}

void add_running_options(Command running, RunOptions& options, RunOptionTexts& texts) {
  add_limit_options(running, options);
  running
      .add_option("--retry", texts.retry,
                  "Redo rows of a finished store: statuses, `changed` (the file has changed), `vanished` "
                  "(remove the rows)")
      .separator(',');
  add_older_store_options(running, options);
  running
      .add_flag("--dry-run", options.dry_run,
                "Print the inputs, the memory and space they need, and what would be done with a store that "
                "is there; "
                "write nothing")
      .common();
}

void resolve_retry(RunOptions& options, const RunOptionTexts& texts, std::vector<std::string>& problems) {
  for (const std::string& word : texts.retry)
    if (!add_retry_word(word, options.retry))
      problems.push_back("--retry: `" + word + "` is neither a status of a failed item (" +
                         joined_texts(std::span(status_names).subspan(1)) + ") nor `changed` nor `vanished`");
}

}  // namespace

void add_limit_options(Command running, RunOptions& options) {
  add_budget_options(running, options);
  running
      .add_option("--max-failures", options.max_failures, "Stop once more than this many items have failed")
      .show_default("no limit");
}

void add_older_store_options(Command running, RunOptions& options) {
  running.add_option("--reuse", options.reuse,
                     "Copy rows of equal content and parameters from this older store");
  add_trust_option(running, options.check);
  running
      .add_flag("--fresh", options.fresh,
                "Start anew: discard an unfinished run; a store of this name is replaced at the end")
      .common();
}

void add_store_options(Command& command, RunOptions& options, RunOptionTexts& texts) {
  command
      .add_option("INPUT", options.inputs,
                  "Mesh files, folders, @list.txt, - (paths on standard input), .cla files")
      .required();
  command.add_option("-o,--output", options.store, "The store to write (HDF5)").common();
  texts.settings.add(command, point_settings(), options.sample);
  texts.settings.add(command, collection_settings(), options.sample);
  texts.settings.add(command, row_settings(), options);
  Command collection = command.under("Collection");
  texts.settings.add(collection, value_settings(), options.sample);
  texts.settings.add(collection, column_settings(), options.sample);
  add_store_columns_option(collection, RowKind::meshes, texts.stored);
  add_list_options(collection, options.collect);
  add_label_options(collection, options.collect);
  texts.settings.add(command, training_settings(), options.sample);
}

void add_task_options(Command& array, int& offset, std::uint64_t& shards_a_task) {
  array
      .add_option("--shard-offset", offset,
                  "Added to the number of the task: -1 where the tasks of an array are numbered from 1")
      .show_default()
      .range(-1000000000, 1000000000);
  array
      .add_option("--shards-per-task", shards_a_task,
                  "Shards of a task, one after the other (default: as many as planned)")
      .range(std::uint64_t{1}, max_shards);
}

Command add_run_command(Command& program, RunOptions& options, RunOptionTexts& texts, ShardOptions& shard) {
  Command command = program.add_subcommand(
      "run", "Sample every model of the input into one store, or a shard of a planned one");
  command.example(
      "meander run models/ -o store.h5 -n 2048",
      "2,048 points and normals on every mesh of a folder; the same command resumes an interrupted "
      "run, and samples what is new in the folder");
  command.example("meander run ModelNet40/ -o modelnet.h5 -n 2048 --layout modelnet --normalize pointnet",
                  "A data set with its classes and splits, centered and scaled as PointNet takes them");
  add_store_options(command, options, texts);
  add_running_options(command.under("Running"), options, texts);
  Command array = command.under("Array (run STORE.run, see `meander plan`)");
  array.add_option("--shard", shard.shard,
                   "i/n: the shard to work on, 0 to n - 1 (default: those of the task)");
  array.add_option("--task", shard.task,
                   "The number of the task (default: what the scheduler's variables say)");
  add_task_options(array, shard.offset, shard.shards_a_task);
  array.add_option("--scratch", shard.scratch, "A folder of this machine for work that is not finished");
  Command report = command.under("Report");
  add_progress_options(report, options);
  report.add_flag("--stats", options.statistics, "Print items, time and bytes of each node of the graph");
  return command;
}

bool add_retry_word(const std::string& word, RetryOptions& retry) {
  const auto at = std::find(status_names.begin(), status_names.end(), word);
  if (word == "changed")
    retry.changed = true;
  else if (word == "vanished")
    retry.vanished = true;
  else if (at == status_names.end() || at == status_names.begin())
    return false;
  else
    retry.statuses.push_back(static_cast<Status>(at - status_names.begin()));
  return true;
}

std::string words_of(const RetryOptions& retry) {
  std::string words;
  const auto add = [&](std::string_view word) { words += (words.empty() ? "" : ",") + std::string(word); };
  for (std::size_t status = 0; status < status_names.size(); ++status)
    if (std::find(retry.statuses.begin(), retry.statuses.end(), static_cast<Status>(status)) !=
        retry.statuses.end())
      add(status_names[status]);
  if (retry.changed) add("changed");
  if (retry.vanished) add("vanished");
  return words;
}

void resolve_run_options(RunOptions& options, const RunOptionTexts& texts, const Laboratory* laboratory) {
  std::vector<std::string> problems;
  SampleParameters& sample = options.sample;
  texts.settings.finish(problems);
  settle(sample, texts.settings.given());
  check_tensor(options, texts.folder, problems);
  check_attributes(options, problems);
  options.left_out = parse_left_out(texts.stored, columns_of(options), problems);
  // What the images are is then in the store too: rows of another image are other rows.
  if (reads_textures(sample.density.kind)) sample.columns[&Samples::rgb] = true;
  if (!method_of(sample).makes_charts && sample.locate != LocatorKind::embree)
    problems.push_back(
        fmt::format("--method {} has no location step: leave --locate out, or name a method with charts",
                    method_of(sample).text));
  if (!sample.columns[&Samples::rgb] && sample.strict != every_note && (sample.strict & color_notes) != 0)
    problems.push_back(fmt::format("--strict {}: notes on colors are taken with --colors only",
                                   words_of(sample.strict & color_notes)));
  for (const std::string& problem : validate(sample)) problems.push_back(problem);
  if (options.certify)
    for (const std::string& problem :
         require_laboratory(laboratory, "--certify").certificate_problems(sample))
      problems.push_back(problem);
  resolve_work_options(options);
  resolve_retry(options, texts, problems);
  if (!options.reuse.empty() && sample.tensor.kind == TensorKind::table)
    problems.push_back("--reuse identifies rows by their mesh alone, not by the tensors of `--tensor file:`");
  if (options.fresh && !texts.retry.empty()) problems.push_back("--fresh discards what --retry would keep");
  if (!problems.empty()) throw UsageError(joined_texts(problems, "\n"));
  options.parameters_json = recorded_parameters(options);
}

std::string recorded_parameters(const RunOptions& options) {
  RecordedSettings recorded;
  for (const SampleSettings* const list : sample_settings()) record(*list, options.sample, recorded);
  for (const SampleSettings* const list : {&sampling_constants(), &chart_constants()})
    record(*list, options.sample, recorded);
  record(row_settings(), options, recorded);
  return json_of(std::move(recorded));
}

void choose_attribute_kinds(RunOptions& options, const StoreColumns* known, std::span<const PlanItem> items) {
  choose_kinds(options.sample.attributes, known, items);
  options.parameters_json = recorded_parameters(options);
}

}  // namespace meander
