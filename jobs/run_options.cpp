#include "jobs/run_options.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>

#include "io/store/run_array.h"
#include "jobs/attribute_types.h"
#include "jobs/column_options.h"
#include "jobs/descriptor_choice.h"
#include "jobs/input_options.h"
#include "jobs/inputs.h"
#include "jobs/laboratory.h"
#include "jobs/option_words.h"
#include "jobs/sequence_options.h"
#include "jobs/store_items.h"
#include "jobs/tensor_options.h"
#include "jobs/units.h"

namespace meander {

StoreColumns columns_of(const RunOptions& options) {
  StoreColumns columns;
  columns.tensors = method_of(options.sample).follows_tensor;
  columns.colors = options.sample.colors;
  columns.texcoord = options.sample.texcoord;
  columns.attributes = options.sample.attributes;
  columns.left_out = options.left_out;
  return columns;
}

namespace {

// A word, "attribute:NAME" or "face-attribute:NAME", or a formula.
void resolve_density(const std::string& text, DensityParameters& density,
                     std::vector<std::string>& problems) {
  constexpr std::string_view vertex = "attribute:", face = "face-attribute:";
  if (text.starts_with(vertex) || text.starts_with(face)) {
    density.kind = text.starts_with(vertex) ? DensityKind::vertex_attribute : DensityKind::face_attribute;
    density.attribute = text.substr(text.find(':') + 1);
    return;
  }
  if (take_formula(text, density)) return;
  for (const auto& word : density_words)
    if (text == word.text) {
      density.kind = word.value;
      return;
    }
  problems.push_back("--density: `" + text +
                     "` is not one of uniform|mean|gaussian|max|texture|texture-inverse|attribute:NAME|"
                     "face-attribute:NAME|formula:TEXT|unit-formula:TEXT");
}

// "all", or the names of notes separated by commas, in their order.
std::string words_of(NoteSet notes) {
  if (notes == every_note) return "all";
  std::string words;
  for (std::size_t n = 0; n < note_count; ++n)
    if ((notes >> n & 1) != 0) words += (words.empty() ? "" : ",") + std::string(note_names[n]);
  return words;
}

NoteSet parse_strict(const std::vector<std::string>& words, std::vector<std::string>& problems) {
  NoteSet notes = 0;
  for (const std::string& word : words) {
    const auto at = std::find(note_names.begin(), note_names.end(), word);
    if (word == "all")
      notes = every_note;
    else if (at != note_names.end())
      notes |= set_of(static_cast<Note>(at - note_names.begin()));
    else
      problems.push_back(
          fmt::format("--strict: `{}` is neither `all` nor a note ({})", word, fmt::join(note_names, ", ")));
  }
  return notes;
}

// "none" or "d2,geodesic,..."; each once.
void resolve_descriptors(const RunOptionTexts& texts, DescribeParameters& describe,
                         std::vector<std::string>& problems) {
  if (texts.describe != "none")
    describe.descriptors = parse_descriptors("--describe", texts.describe, problems);
  const DescriptorShapeOptions& shape = texts.descriptor_shape;
  if (!describe.descriptors.empty())
    check_descriptor_shape(shape, describe, problems);
  else if (shape.bins_given || shape.scale_given || shape.sources_given)
    problems.push_back(
        "--bins, --descriptor-scale and --geodesic-sources apply to descriptors: see --describe");
}

void add_collection_options(Command collection, RunOptions& options, RunOptionTexts& texts) {
  ParameterTable& table = texts.table;
  DescribeParameters& describe = options.sample.describe;
  collection
      .add_option("--describe", texts.describe,
                  fmt::format("Descriptors to store: none, or one or more of {}, separated by commas",
                              fmt::join(descriptor_names, ",")))
      .show_default();
  table.compute("describe", "--describe", [&describe] {
    std::string names;
    for (const Descriptor d : describe.descriptors)
      names += (names.empty() ? "" : ",") + std::string(name_of(d));
    return names.empty() ? "none" : names;
  });
  add_descriptor_shape_options(collection, table, texts.descriptor_shape, describe);
  table.add(collection, "certify", "--certify", options.certify,
            "Measure the samples of every model: error over rotated boxes, rho (/certificate)");
  add_value_options(collection, options, texts, "Store", "at the points");
  collection
      .add_option("--strict", texts.strict,
                  fmt::format("Fail models with these notes, what a file asks for and does not get, with the "
                              "status incomplete: all, or one or more of {}",
                              fmt::join(note_names, ", ")))
      .separator(',');
  table.compute(
      "strict", "--strict", [&options] { return words_of(options.sample.strict); },
      [&options] { return options.sample.strict != 0; });
  add_store_columns_option(collection, RowKind::meshes, texts.stored);
  table.compute(
      "store", "--store", [&options] { return stored_words(columns_of(options)); },
      [&options] { return options.left_out != 0; });
  add_list_options(collection, options.collect);
  add_label_options(collection, options.collect);
  table.add(collection, "compress", "--compress", options.compression, compression_words,
            "shuffle + deflate + checksum, or checksum only");
}

void add_running_options(Command running, RunOptions& options, RunOptionTexts& texts) {
  add_budget_options(running, options, texts);
  running
      .add_option("--retry", texts.retry,
                  "Redo rows of a finished store: statuses, `changed` (the file has changed), `vanished` "
                  "(remove the rows)")
      .separator(',');
  add_older_store_options(running, options);
  running.add_flag(
      "--dry-run", options.dry_run,
      "Print the inputs, the memory and space they need, and what would be done with a store that is there; "
      "write nothing");
}

void add_report_options(Command report, RunOptions& options) {
  add_progress_options(report, options);
  report.add_flag("--stats", options.statistics, "Print items, time and bytes of each node of the graph");
}

// Parameters of the method that no option changes directly.
void record_constants(const SampleParameters& sample, ParameterTable& table) {
  table.constant("curve_max_depth", sample.locator.curve.max_depth);
  table.constant("density_quantile", sample.density.quantile);
  table.derive("elements_per_sample", [&sample] { return elements_per_sample(sample); });
  table.constant("extremity_seams", sample.cut.extremity_seams);
  table.constant("jitter", sample.place.jitter);
  table.constant("leaves_per_sample", sample.locator.curve.leaves_per_sample);
  table.constant("max_extra_seams", sample.flatten.max_extra_seams);
  table.constant("max_mean_distortion", sample.flatten.max_mean_distortion);
  table.constant("max_sheets", sample.locator.max_sheets);
  table.constant("min_component_samples", sample.locator.min_component_samples);
  table.constant("min_log_scale", sample.flatten.min_log_scale);
  table.constant("min_sheet_samples", sample.locator.min_sheet_samples);
}

// Of the charts of the method conformal.
void record_coarse_charts(const SampleParameters& sample, ParameterTable& table) {
  table.constant("coarse_mean_distortion", coarse_mean_distortion);
  table.derive("coarse_elements_per_sample",
               [&sample] { return coarse_elements_per_sample(sample.place.samples); });
  table.constant("coarse_least_of_component", sample.coarsen.least_of_component);
  table.constant("coarse_least_triangles", sample.coarsen.least_triangles);
  table.constant("coarse_triangles_per_sample", sample.coarsen.triangles_per_sample);
}

// Members that only some runs record.
std::string parameters_json(const RunOptions& options, const RunOptionTexts& texts) {
  ParameterTable table = texts.table;
  if (options.sample.method == MethodChoice::conformal) record_coarse_charts(options.sample, table);
  if (method_of(options.sample).follows_tensor) table.append(texts.tensor_table);
  return table.json();
}

// The place of samples, and what depends on several options.
void resolve_sampling(SampleParameters& sample, const RunOptionTexts& texts) {
  const bool first_hit = sample.locate == LocatorKind::first_hit;
  if (!texts.chooses_place) sample.place.place = first_hit ? PlaceKind::vertex : PlaceKind::element;
  // A sample at a curve vertex needs many vertices per sample, or the pattern is quantised (docs/METHODS.md
  // 7.4).
  if (first_hit) sample.locator.curve.leaves_per_sample = 64;
  if (!first_hit && sample.place.place == PlaceKind::vertex) sample.elements.elements_per_sample = 64;
  if (!texts.curve.empty()) sample.order = value_of(order_of_elements_words, texts.curve);
  sample.topology = texts.topology == "full";
  set_samples(sample, texts.samples);
}

void resolve_budgets(RunOptions& options, const RunOptionTexts& texts, std::vector<std::string>& problems) {
  const Budgets budgets = parse_budgets(texts.memory, texts.timeout, problems);
  options.memory_bytes = budgets.memory_bytes;
  options.timeout_seconds = budgets.timeout_seconds;
}

void choose_threads(RunOptions& options) {
  if (options.threads == 0) options.threads = std::max(1, oneapi::tbb::info::default_concurrency());
}

void resolve_retry(RunOptions& options, const RunOptionTexts& texts, std::vector<std::string>& problems) {
  for (const std::string& word : texts.retry)
    if (!add_retry_word(word, options.retry))
      problems.push_back("--retry: `" + word + "` is neither a status of a failed item (" +
                         fmt::format("{}", fmt::join(status_names.begin() + 1, status_names.end(), ", ")) +
                         ") nor `changed` nor `vanished`");
}

}  // namespace

void add_value_options(Command command, RunOptions& options, RunOptionTexts& texts, const std::string& verb,
                       const std::string& where) {
  ParameterTable& table = texts.table;
  const bool stores = verb == "Store";
  command.add_flag("--colors", options.sample.colors,
                   fmt::format("{} the colours of the models {}{}: of vertices, faces, materials or textures",
                               verb, where, stores ? " (/rgb)" : ""));
  table.compute(
      "colors", "--colors", [&options] { return options.sample.colors; },
      [&options] { return options.sample.colors; });
  command
      .add_option(
          "--attribute", texts.attributes,
          fmt::format("{} an attribute of the models {}{}, NAME:2, NAME:3 or NAME:4 "
                      "a vector; of vertices interpolated, integers that of the nearest corner ({}"
                      "`NAME:linear` interpolates them), of faces that of the face. Repeat it for several",
                      verb, where, stores ? " (/attributes/NAME)" : "",
                      stores ? "as int32; `NAME:class` takes any for such, " : ""))
      .separator(',')
      .one_at_a_time();
  table.compute(
      "attributes", "--attribute", [&options] { return text_of(options.sample.attributes); },
      [&options] { return !options.sample.attributes.empty(); });
  command.add_flag("--texcoord", options.sample.texcoord,
                   fmt::format("{} the texture coordinates of the models {}{}", verb, where,
                               stores ? " (/texcoord)" : ""));
  table.compute(
      "texcoord", "--texcoord", [&options] { return options.sample.texcoord; },
      [&options] { return options.sample.texcoord; });
}

void add_point_options(Command points, RunOptions& options, RunOptionTexts& texts) {
  ParameterTable& table = texts.table;
  SampleParameters& sample = options.sample;
  const auto shapes_density = [&texts] { texts.shapes_density = true; };
  table.add(points, "samples", "-n,--samples", texts.samples, "Points per model, 1 to 2^31")
      .range(1.0, 2147483648.0);
  table.add(
      points, "method", "--method", sample.method, method_words,
      "How the surface is ordered: auto, the order that measures best (balanced bisection in space); a "
      "curve over a conformal chart; a curve in space; or a curve over a chart conformal in the metric of "
      "a tensor field");
  table.add(
      points, "density", "--density", texts.density,
      "uniform, mean|gaussian|max curvature, attribute:NAME of vertices, face-attribute:NAME; texture: the "
      "luminance of the model's textures, more samples where they are bright, texture-inverse: where they "
      "are dark (with --colors); formula:TEXT in x, y, z, nx, ny, nz, mean, gaussian, u, v, as "
      "`formula:1 + z^2`, unit-formula: with lengths of the unit box");
  table
      .add(points, "density_floor", "--density-floor", sample.density.floor,
           "Density of flat parts for curvature densities, of dark ones for textures, 1e-6 to 1")
      .on_given(shapes_density);
  table
      .add(points, "density_exponent", "--density-exponent", sample.density.exponent,
           "Exponent of curvature and texture densities, 0.25 to 4")
      .on_given(shapes_density);
  table.add(points, "locate", "--locate", sample.locate, locate_words,
            "Point location: Embree rays with sheets, elements alone, the survey's first hit");
  table
      .add(points, "place", "--place", sample.place.place, place_words,
           "Where samples lie in a curve element (default element; vertex for first-hit)")
      .show_default("")
      .on_given([&texts] { texts.chooses_place = true; });
  table.add(points, "sequence", "--sequence", sample.place.sequence, sequence_words, sequence_help);
  add_spacing_option(points, sample.place.spacing, texts.spacing_given);
  table.add(points, "order", "--order", sample.place.order, order_words,
            "Order in the file: every prefix well spread, or along the curve");
  points
      .add_option("--curve", texts.curve,
                  "Order of a named method: a curve, or balanced bisection (default hilbert); direct: "
                  "hilbert or balanced")
      .one_of(all_words(order_of_elements_words));
  table.compute("curve", "--curve", [&sample] { return text_of(order_of_elements_words, order_of(sample)); });
  table.compute(
      "curved", "--curved", [&sample] { return sample.curved; }, [&sample] { return sample.curved; });
  table.compute(
      "spacing", "--spacing", [&sample] { return text_of(spacing_words, sample.place.spacing); },
      [&sample] { return sample.place.sequence == SequenceKind::spaced; });
  table.add(points, "seed", "--seed", sample.seed, "Seed, 0 to 2^64 - 1").whole_number();
  table.add(points, "normalize", "--normalize", sample.place.normalize, normalize_words,
            "Stored coordinates; loc and scale undo it. none: those of the file; unit-sphere: the centre of "
            "the box at 0, the farthest vertex of a face with an area at distance 1; unit-box: that centre "
            "at 0, the longest "
            "side of the box 1; unit-diagonal: that centre at 0, the diagonal of the box 1, as in ShapeNet; "
            "pointnet: the mean of the samples at 0, the farthest sample at distance 1");
  add_tensor_options(points, texts.tensor_table, texts.tensor, sample);
  points.add_flag(
      "--curved", sample.curved,
      "Lift the points from the flat triangles to the smooth surface that the vertex normals define");
}

void add_budget_options(Command running, RunOptions& options, RunOptionTexts& texts) {
  running.add_option("-j,--threads", options.threads, "Threads, up to 1024 (0: all available)")
      .show_default()
      .range(0, 1024);
  running.add_option("--memory", texts.memory, "Memory budget of the whole process").show_default();
  running.add_flag("--allow-oversize", options.allow_oversize,
                   "Process a model that exceeds the memory budget, on its own");
  running
      .add_option("--timeout", texts.timeout,
                  "Time limit for work on one model, waiting excluded (ms, s, m, h); 0: none")
      .show_default();
  running
      .add_option("--max-failures", options.max_failures, "Stop once more than this many items have failed")
      .show_default("no limit");
}

void add_progress_options(Command report, RunOptions& options) {
  report
      .add_option("--progress", options.progress,
                  "Progress on standard error; auto: a bar on a terminal, plain lines otherwise")
      .show_default()
      .one_of({"auto", "bar", "plain", "json", "none"});
  report.add_flag("--json", options.json, "The summary as JSON on standard output");
}

void add_older_store_options(Command running, RunOptions& options) {
  running.add_option("--reuse", options.reuse,
                     "Copy rows of equal content and parameters from this older store");
  add_trust_option(running, options.check);
  running.add_flag("--fresh", options.fresh,
                   "Start anew: discard an unfinished run; a store of this name is replaced at the end");
}

void add_topology_option(Command points, RunOptions& options, RunOptionTexts& texts) {
  points
      .add_option("--topology", texts.topology,
                  "full: find components, boundaries and one orientation of every surface; none: take the "
                  "triangles as they are, faster and in less memory (auto and direct)")
      .show_default()
      .one_of({"full", "none"});
  texts.table.compute(
      "topology", "--topology", [&texts] { return texts.topology; },
      [&options] { return !options.sample.topology; });
}

void add_store_options(Command& command, RunOptions& options, RunOptionTexts& texts) {
  command
      .add_option("INPUT", options.inputs,
                  "Mesh files, folders, @list.txt, - (paths on standard input), .cla files")
      .required();
  command.add_option("-o,--output", options.store, "The store to write (HDF5)");
  add_point_options(command.under("Points"), options, texts);
  add_topology_option(command.under("Points"), options, texts);
  add_collection_options(command.under("Collection"), options, texts);
  record_constants(options.sample, texts.table);
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
  add_store_options(command, options, texts);
  add_running_options(command.under("Running"), options, texts);
  Command array = command.under("Array (run STORE.run, see `meander plan`)");
  array.add_option("--shard", shard.shard,
                   "i/n: the shard to work on, 0 to n - 1 (default: those of the task)");
  array.add_option("--task", shard.task,
                   "The number of the task (default: what the scheduler's variables say)");
  add_task_options(array, shard.offset, shard.shards_a_task);
  array.add_option("--scratch", shard.scratch, "A folder of this machine for work that is not finished");
  add_report_options(command.under("Report"), options);
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

void resolve_budget_options(RunOptions& options, const RunOptionTexts& texts) {
  std::vector<std::string> problems;
  resolve_budgets(options, texts, problems);
  choose_threads(options);
  if (!problems.empty()) throw UsageError(fmt::format("{}", fmt::join(problems, "\n")));
}

void resolve_run_options(RunOptions& options, const RunOptionTexts& texts, const Laboratory* laboratory) {
  std::vector<std::string> problems;
  SampleParameters& sample = options.sample;
  resolve_descriptors(texts, sample.describe, problems);
  resolve_sampling(sample, texts);
  resolve_tensor_options(texts.tensor, sample, problems);
  sample.attributes = parse_attributes(texts.attributes, problems);
  sample.strict = parse_strict(texts.strict, problems);
  options.left_out = parse_left_out(texts.stored, columns_of(options), problems);
  resolve_density(texts.density, sample.density, problems);
  // What the images are is then in the store too: rows of another image are other rows.
  if (reads_textures(sample.density.kind)) sample.colors = true;
  if (texts.shapes_density && !has_shape(sample.density.kind))
    problems.push_back(
        "--density-floor and --density-exponent apply to densities of curvature and textures only");
  if (!method_of(sample).makes_charts && sample.locate != LocatorKind::embree)
    problems.push_back(
        fmt::format("--method {} has no location step: leave --locate out, or name a method with charts",
                    method_of(sample).name));
  if (!sample.colors && sample.strict != every_note && (sample.strict & color_notes) != 0)
    problems.push_back(fmt::format("--strict {}: notes on colours are taken with --colors only",
                                   words_of(sample.strict & color_notes)));
  check_spacing_option(sample.place.sequence, texts.spacing_given, problems);
  for (const std::string& problem : validate(sample)) problems.push_back(problem);
  if (options.certify)
    for (const std::string& problem :
         require_laboratory(laboratory, "--certify").certificate_problems(sample))
      problems.push_back(problem);
  resolve_budgets(options, texts, problems);
  resolve_retry(options, texts, problems);
  if (!options.reuse.empty() && sample.tensor.kind == TensorKind::table)
    problems.push_back("--reuse identifies rows by their mesh alone, not by the tensors of `--tensor file:`");
  if (options.fresh && !texts.retry.empty()) problems.push_back("--fresh discards what --retry would keep");
  choose_threads(options);
  if (!problems.empty()) throw UsageError(fmt::format("{}", fmt::join(problems, "\n")));
  options.parameters_json = parameters_json(options, texts);
}

void choose_attribute_kinds(RunOptions& options, const RunOptionTexts& texts, const StoreColumns* known,
                            std::span<const PlanItem> items) {
  choose_kinds(options.sample.attributes, known, items);
  options.parameters_json = parameters_json(options, texts);
}

}  // namespace meander
