#include "jobs/run_options.h"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>

#include "io/json_writer.h"
#include "jobs/command_line.h"
#include "jobs/descriptor_choice.h"
#include "jobs/input_options.h"
#include "jobs/inputs.h"
#include "jobs/laboratory.h"
#include "jobs/option_words.h"
#include "jobs/store_items.h"
#include "jobs/tensor_options.h"
#include "jobs/units.h"

namespace meander {

namespace {

// "uniform|mean|gaussian|max|attribute:NAME|face-attribute:NAME"
void resolve_density(const std::string& text, DensityParameters& density,
                     std::vector<std::string>& problems) {
  constexpr std::string_view vertex = "attribute:", face = "face-attribute:";
  if (text.starts_with(vertex) || text.starts_with(face)) {
    density.kind = text.starts_with(vertex) ? DensityKind::vertex_attribute : DensityKind::face_attribute;
    density.attribute = text.substr(text.find(':') + 1);
    return;
  }
  for (const auto& word : density_words)
    if (text == word.text) {
      density.kind = word.value;
      return;
    }
  problems.push_back("--density: `" + text +
                     "` is not one of uniform|mean|gaussian|max|attribute:NAME|face-attribute:NAME");
}

// "none" or "d2,geodesic,..."; each once.
void resolve_descriptors(const RunOptionTexts& texts, DescribeParameters& describe,
                         std::vector<std::string>& problems) {
  if (texts.describe != "none")
    describe.descriptors = parse_descriptors("--describe", texts.describe, problems);
  const DescriptorShapeTexts& shape = texts.descriptor_shape;
  if (!describe.descriptors.empty())
    resolve_descriptor_shape(shape, describe, problems);
  else if (shape.bins_given || shape.scale_given || shape.sources_given)
    problems.push_back(
        "--bins, --descriptor-scale and --geodesic-sources apply to descriptors: see --describe");
}

std::string density_text(const DensityParameters& density) {
  if (density.kind == DensityKind::vertex_attribute) return "attribute:" + density.attribute;
  if (density.kind == DensityKind::face_attribute) return "face-attribute:" + density.attribute;
  return text_of(density_words, density.kind);
}

}  // namespace

void add_run_command(Command& program, RunOptions& options, RunOptionTexts& texts) {
  Command command = program.add_subcommand("run", "Sample every model of the input into one store");
  command
      .add_option("INPUT", options.inputs,
                  "Mesh files, folders, @list.txt, - (paths on standard input), .cla files")
      .required();
  command.add_option("-o,--output", options.store, "The store to write (HDF5)").required();
  const char* points = "Points";
  command.add_option("-n,--samples", texts.samples, "Points per model, 1 to 2^31")
      .show_default()
      .range(1.0, 2147483648.0)
      .group(points);
  command
      .add_option("--method", texts.method,
                  "Order of the surface: a curve over a conformal chart, 3-D Hilbert order, or a curve over "
                  "a chart conformal in the metric of a tensor field")
      .show_default()
      .one_of(all_words(method_words))
      .group(points);
  command
      .add_option("--density", texts.density,
                  "uniform, mean|gaussian|max curvature, attribute:NAME of vertices, face-attribute:NAME")
      .show_default()
      .group(points);
  command
      .add_option("--density-floor", options.sample.density.floor,
                  "Density of flat parts for curvature densities, 1e-6 to 1")
      .show_default()
      .on_given([&texts] { texts.shapes_density = true; })
      .group(points);
  command
      .add_option("--density-exponent", options.sample.density.exponent,
                  "Exponent of curvature densities, 0.25 to 4")
      .show_default()
      .on_given([&texts] { texts.shapes_density = true; })
      .group(points);
  command
      .add_option("--locate", texts.locate,
                  "Point location: Embree rays with sheets, elements alone, the survey's first hit")
      .show_default()
      .one_of(all_words(locate_words))
      .group(points);
  command
      .add_option("--place", texts.place,
                  "Where samples lie in a curve element (default element; vertex for first-hit)")
      .one_of(all_words(place_words))
      .group(points);
  command.add_option("--sequence", texts.sequence, "The 1-D sample set")
      .show_default()
      .one_of(all_words(sequence_words))
      .group(points);
  command
      .add_option("--order", texts.order, "Order in the file: every prefix well spread, or along the curve")
      .show_default()
      .one_of(all_words(order_words))
      .group(points);
  command.add_option("--curve", texts.curve, "The space-filling curve")
      .show_default()
      .one_of(all_words(curve_words))
      .group(points);
  command.add_option("--seed", options.sample.seed, "Seed, 0 to 2^64 - 1")
      .show_default()
      .whole_number()
      .group(points);
  command.add_option("--normalize", texts.normalize, "Stored coordinates (loc and scale undo it)")
      .show_default()
      .one_of(all_words(normalize_words))
      .group(points);
  add_tensor_options(command, texts.tensor, options.sample);
  command
      .add_flag(
          "--curved", options.sample.curved,
          "Lift the points from the flat triangles to the smooth surface that the vertex normals define")
      .group(points);
  const char* collection = "Collection";
  command
      .add_option(
          "--describe", texts.describe,
          "Descriptors to store: none, or one or more of d2,a3,d1,d3,d4,geodesic,basics, separated by commas")
      .show_default()
      .group(collection);
  add_descriptor_shape_options(command, texts.descriptor_shape, options.sample.describe, collection);
  command
      .add_flag("--certify", options.certify,
                "Measure the samples of every model: error over rotated boxes, rho (/certificate)")
      .group(collection);
  add_list_options(command, options.collect, collection);
  add_label_options(command, options.collect, collection);
  command.add_option("--compress", texts.compress, "shuffle + deflate + checksum, or checksum only")
      .show_default()
      .one_of({"default", "none"})
      .group(collection);
  const char* running = "Running";
  command.add_option("-j,--threads", options.threads, "Threads, up to 1024 (0: all available)")
      .show_default()
      .range(0, 1024)
      .group(running);
  command.add_option("--memory", texts.memory, "Memory budget of the whole process")
      .show_default()
      .group(running);
  command
      .add_flag("--allow-oversize", options.allow_oversize,
                "Process a model that exceeds the memory budget, on its own")
      .group(running);
  command
      .add_option("--timeout", texts.timeout,
                  "Time limit for work on one model, waiting excluded (ms, s, m, h); 0: none")
      .show_default()
      .group(running);
  command
      .add_option("--max-failures", options.max_failures, "Stop once more than this many items have failed")
      .show_default("no limit")
      .group(running);
  command
      .add_option("--retry", texts.retry,
                  "Redo rows of a finished store: statuses, `changed` (the file has changed), `vanished` "
                  "(remove the rows)")
      .separator(',')
      .group(running);
  command
      .add_option("--reuse", options.reuse, "Copy rows of equal content and parameters from this older store")
      .group(running);
  add_trust_option(command, options.check).group(running);
  command
      .add_flag("--fresh", options.fresh,
                "Start anew: discard an unfinished run; a store of this name is replaced at the end")
      .group(running);
  command.add_flag("--dry-run", options.dry_run, "Print what would be done; write nothing").group(running);
  const char* report = "Report";
  command
      .add_option("--progress", options.progress,
                  "Progress on standard error; auto: a bar on a terminal, plain lines otherwise")
      .show_default()
      .one_of({"auto", "bar", "plain", "json", "none"})
      .group(report);
  command.add_flag("--json", options.json, "The summary as JSON on standard output").group(report);
  command.add_flag("--stats", options.statistics, "Print items, time and bytes of each node of the graph")
      .group(report);
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
  resolve_descriptors(texts, sample.describe, problems);
  sample.method = value_of(method_words, texts.method);
  sample.locate = value_of(locate_words, texts.locate);
  const bool first_hit = sample.locate == LocatorKind::first_hit;
  sample.place.place = texts.place.empty() ? (first_hit ? PlaceKind::vertex : PlaceKind::element)
                                           : value_of(place_words, texts.place);
  // A sample at a curve vertex needs many vertices per sample, or the pattern is quantised (docs/METHODS.md
  // 7.4).
  if (first_hit) sample.locator.curve.leaves_per_sample = 64;
  if (!first_hit && sample.place.place == PlaceKind::vertex) sample.elements.elements_per_sample = 64;
  sample.place.sequence = value_of(sequence_words, texts.sequence);
  sample.place.order = value_of(order_words, texts.order);
  sample.place.normalize = value_of(normalize_words, texts.normalize);
  sample.locator.curve.kind = value_of(curve_words, texts.curve);
  sample.elements.curve = sample.locator.curve.kind;
  set_samples(sample, texts.samples);
  resolve_tensor_options(texts.tensor, sample, problems);
  resolve_density(texts.density, sample.density, problems);
  const DensityKind density = sample.density.kind;
  if (texts.shapes_density && density != DensityKind::mean && density != DensityKind::gaussian &&
      density != DensityKind::max)
    problems.push_back("--density-floor and --density-exponent apply to curvature densities only");
  if (sample.method == MethodChoice::direct && texts.locate != "embree")
    problems.push_back("--method direct has no location step: leave --locate out");
  if (sample.method == MethodChoice::direct && texts.curve != "hilbert")
    problems.push_back("--method direct uses the 3-D Hilbert curve: leave --curve out");
  for (const std::string& problem : validate(sample)) problems.push_back(problem);
  if (options.certify)
    for (const std::string& problem :
         require_laboratory(laboratory, "--certify").certificate_problems(sample))
      problems.push_back(problem);
  options.compression = texts.compress == "none" ? Compression::none : Compression::standard;
  try {
    options.memory_bytes = parse_bytes(texts.memory);
  } catch (const UsageError& error) {
    problems.push_back(std::string("--memory: ") + error.what());
  }
  try {
    options.timeout_seconds = parse_seconds(texts.timeout);
  } catch (const UsageError& error) {
    problems.push_back(std::string("--timeout: ") + error.what());
  }
  for (const std::string& word : texts.retry)
    if (!add_retry_word(word, options.retry))
      problems.push_back("--retry: `" + word + "` is neither a status of a failed item (" +
                         fmt::format("{}", fmt::join(status_names.begin() + 1, status_names.end(), ", ")) +
                         ") nor `changed` nor `vanished`");
  if (!options.reuse.empty() && sample.tensor.kind == TensorKind::table)
    problems.push_back("--reuse identifies rows by their mesh alone, not by the tensors of `--tensor file:`");
  if (options.fresh && !texts.retry.empty()) problems.push_back("--fresh discards what --retry would keep");
  if (options.threads == 0) options.threads = std::max(1, oneapi::tbb::info::default_concurrency());
  if (!problems.empty()) throw UsageError(fmt::format("{}", fmt::join(problems, "\n")));
}

std::string parameters_json(const RunOptions& options) {
  const SampleParameters& p = options.sample;
  JsonWriter json;
  json.begin_object();
  json.member("certify", options.certify);
  json.member("compress", options.compression == Compression::none ? "none" : "default");
  json.member("curve", text_of(curve_words, p.locator.curve.kind));
  if (p.curved) json.member("curved", true);
  json.member("curve_max_depth", p.locator.curve.max_depth);
  json.member("density", density_text(p.density));
  json.member("density_exponent", p.density.exponent);
  json.member("density_floor", p.density.floor);
  json.member("density_quantile", p.density.quantile);
  std::string descriptors;
  for (const Descriptor d : p.describe.descriptors)
    descriptors += (descriptors.empty() ? "" : ",") + std::string(name_of(d));
  json.member("describe", descriptors.empty() ? "none" : descriptors);
  json.member("descriptor_bins", p.describe.bins);
  json.member("descriptor_scale", p.describe.scale == HistogramScale::mean ? "mean" : "largest");
  json.member("elements_per_sample", elements_per_sample(p));
  json.member("extremity_seams", p.cut.extremity_seams);
  json.member("geodesic_sources", p.describe.geodesic_sources);
  json.member("jitter", p.place.jitter);
  json.member("leaves_per_sample", p.locator.curve.leaves_per_sample);
  json.member("locate", text_of(locate_words, p.locate));
  json.member("max_extra_seams", p.flatten.max_extra_seams);
  json.member("max_mean_distortion", p.flatten.max_mean_distortion);
  json.member("max_sheets", p.locator.max_sheets);
  json.member("method", text_of(method_words, p.method));
  json.member("min_component_samples", p.locator.min_component_samples);
  json.member("min_log_scale", p.flatten.min_log_scale);
  json.member("min_sheet_samples", p.locator.min_sheet_samples);
  json.member("normalize", text_of(normalize_words, p.place.normalize));
  json.member("order", text_of(order_words, p.place.order));
  json.member("place", text_of(place_words, p.place.place));
  json.member("samples", p.place.samples);
  json.member("seed", p.seed);
  json.member("sequence", text_of(sequence_words, p.place.sequence));
  if (p.method == MethodChoice::anisotropic) {
    json.member("tensor", tensor_text(p.tensor));
    json.member("tensor_bisections", p.tensor_charts.max_bisections);
    json.member("tensor_charts", p.tensor_charts.form == AlignmentForm::metric ? "metric" : "gradient");
    json.member("tensor_density", p.tensor.adaptive ? "follow" : "keep");
    json.member("tensor_epsilon", p.tensor.epsilon);
    json.member("tensor_form", p.tensor.form == TensorForm::metric ? "metric" : "spacing");
    json.member("tensor_ratio", p.tensor.max_ratio);
    json.member("tensor_segments", p.tensor_charts.segment.count);
    json.member("tensor_smoothing", p.tensor.smoothing);
  }
  json.end_object();
  return json.text();
}

}  // namespace meander
