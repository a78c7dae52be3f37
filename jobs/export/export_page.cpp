#include "jobs/export/export_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "io/json_writer.h"
#include "io/page/model_page.h"
#include "io/store/schema.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/units.h"
#include "jobs/rows/descriptor_choice.h"
#include "jobs/rows/sample_colorings.h"
#include "kernels/retrieve/nearest_rows.h"

namespace meander {

namespace {

constexpr std::size_t shown_neighbors = 8;

// Six significant digits are what a reader looks at.
double six_digits(double value) {
  const std::string text = fmt::format("{:.6g}", value);
  double rounded = value;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

std::uint64_t spread(std::uint64_t i, std::uint64_t kept, std::uint64_t all) {
  return kept == all ? i : (2 * i + 1) * all / (2 * kept);
}

// The text of an attribute of a descriptor; empty where it has none of that name.
std::string attribute_of(const DescriptorSchema& schema, std::string_view wanted) {
  for (const auto& [name, text] : schema.attributes)
    if (name == wanted) return text;
  return {};
}

template <class Values>
void number_list(JsonWriter& json, const Values& values) {
  json.begin_array();
  for (const auto& value : values) json.value(value);
  json.end_array();
}

// A histogram of all models of the page, row by row, and which models have it.
struct PageHistogram {
  DescriptorSchema schema;
  std::vector<float> values;            // of the models that have it
  std::vector<std::uint64_t> position;  // of these, on the page
};

// Bytes of a sample for a coloring that the page has beside those of PackedPoints.
std::size_t coloring_bytes_each(ColoringKind kind) {
  return kind == ColoringKind::number ? 1 : kind == ColoringKind::classes ? 2 : 3;
}
constexpr std::string_view page_kind(ColoringKind kind) {
  return kind == ColoringKind::number ? "number" : kind == ColoringKind::classes ? "classes" : "colors";
}
constexpr std::size_t most_class_keys = 12;  // in a legend

// Everything of the page but the points: filled model by model.
class PageFacts {
 public:
  PageFacts(const StoreReader& store, const std::string& store_name, const PageExport& options)
      : store_(store) {
    store.require(&Samples::normals, "--html");
    store.require(&Samples::density, "--html");
    store.require(&Samples::curve_rank, "--html");
    choose_rows(options);
    for (const DescriptorSchema& schema : store.descriptors())
      if (schema.group == "descriptors" && schema.width > 1 && is_histogram(schema))
        histograms_.push_back({schema, {}, {}});
    // What the run was asked for; of the other columns the packed points have those that a page shows.
    for (const SampleColoring& coloring : colorings_of(store))
      if (coloring.attribute || (coloring.column && sample_columns[*coloring.column].is_asked_for()))
        colorings_.push_back(coloring);
    choose_points(options);
    json_.begin_object();
    json_.member("store", store_name);
    write_provenance();
    write_names();
    write_failures(options.models);
    json_.key("models");
    json_.begin_array();
  }

  const std::vector<std::uint64_t>& rows() const { return rows_; }
  std::uint64_t points() const { return chosen_.size(); }
  // Models that were wanted and are not there, and failures that are not listed.
  std::uint64_t models_left_out() const { return wanted_ - rows_.size(); }
  std::uint64_t failures_left_out() const { return failed_.size() - listed_; }

  // Adds the model to the facts and gives the bytes of its block: points, the values of each coloring (one
  // byte of the range, 255: none; two bytes of a class, little-endian, 65535: none; or three of a color),
  // then a byte for every bin of its histograms, over the largest of each.
  std::vector<std::byte> add_model(std::uint64_t position) {
    const std::uint64_t row = rows_[position];
    const Row content = store_.read_row(row);
    PackedPoints packed = pack_points(content.samples, chosen_);
    json_.begin_object();
    json_.member("id", store_.id(row));
    json_.member("row", row);
    json_.member("label", store_.label(row));
    if (store_.split(row) != Split::none) json_.member("split", name_of(store_.split(row)));
    write_geometry(content.report, packed);
    write_notes(content.report);
    write_values(content);
    json_.key("paint");
    json_.begin_array();
    for (const SampleColoring& coloring : colorings_) add_coloring(coloring, content, packed.bytes);
    json_.end_array();
    json_.key("peaks");
    json_.begin_array();
    for (PageHistogram& histogram : histograms_) add_histogram(histogram, content, position, packed.bytes);
    json_.end_array();
    json_.end_object();
    return packed.bytes;
  }

  // After the last model.
  const std::string& finish() {
    json_.end_array();
    write_neighbors();
    json_.end_object();
    return json_.text();
  }

 private:
  void choose_rows(const PageExport& options) {
    std::vector<std::uint64_t> wanted = options.rows;
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    named_ = !wanted.empty();
    for (std::uint64_t row = 0; row < store_.rows(); ++row) {
      const Status status = store_.report(row).status;
      if (status != Status::ok)
        failed_.push_back(row);
      else if (++ok_rows_; !named_)
        wanted.push_back(row);
    }
    wanted_ = wanted.size();
    const std::uint64_t kept = std::min<std::uint64_t>(options.models, wanted.size());
    for (std::uint64_t i = 0; i < kept; ++i) rows_.push_back(wanted[spread(i, kept, wanted.size())]);
  }

  void choose_points(const PageExport& options) {
    constexpr std::uint64_t fewest = 128;
    std::uint64_t each = packed_point_bytes;
    for (const SampleColoring& coloring : colorings_) each += coloring_bytes_each(coloring.kind);
    const std::uint64_t usual =
        std::max(fewest, page_points * packed_point_bytes / each / std::max<std::uint64_t>(1, rows_.size()));
    const std::uint64_t all = store_.samples();
    const std::uint64_t kept = std::min(all, options.points > 0 ? options.points : usual);
    const bool progressive = store_.order() == "progressive";
    for (std::uint64_t i = 0; i < kept; ++i)
      chosen_.push_back(static_cast<std::uint32_t>(progressive ? i : spread(i, kept, all)));
  }

  void write_provenance() {
    json_.member("content", store::content_name(store_.columns()));
    json_.member("rows", store_.rows());
    json_.member("ok", ok_rows_);
    json_.member("named", named_);
    json_.member("wanted", wanted_);
    json_.member("samples", store_.samples());
    json_.member("points", points());
    json_.member("order", store_.order());
    json_.member("seed", store_.seed());
    json_.member("tool_version", store_.tool_version());
    json_.member("method_version", store_.method_version());
    json_.member("format_version", store_.format_version());
    json_.member("parameters", store_.parameters_json());
  }

  void write_names() {
    json_.key("labels");
    number_list(json_, store_.label_names());
    json_.key("colorings");
    json_.begin_array();
    for (const SampleColoring& coloring : colorings_) {
      json_.begin_object();
      json_.member("word", coloring.word);
      json_.member("title", coloring.title);
      json_.member("kind", page_kind(coloring.kind));
      json_.member("bytes", std::uint64_t{coloring_bytes_each(coloring.kind)});
      json_.end_object();
    }
    json_.end_array();
    json_.key("histograms");
    json_.begin_array();
    for (const PageHistogram& histogram : histograms_) {
      json_.begin_object();
      json_.member("name", histogram.schema.name);
      json_.member("width", histogram.schema.width);
      json_.member("value", attribute_of(histogram.schema, "value"));
      json_.member("bins", attribute_of(histogram.schema, "bins"));
      json_.end_object();
    }
    json_.end_array();
    json_.key("values");
    json_.begin_array();
    for (const DescriptorSchema& schema : store_.descriptors()) {
      if (!is_single_values(schema)) continue;
      json_.begin_object();
      json_.member("group", schema.group);
      json_.member("name", schema.name);
      json_.member("value", attribute_of(schema, "value"));
      json_.member("columns", attribute_of(schema, columns_attribute));
      json_.member("width", schema.width);
      json_.end_object();
    }
    json_.end_array();
  }

  void write_failures(std::uint64_t most) {
    listed_ = std::min<std::uint64_t>(most, failed_.size());
    json_.member("failed", std::uint64_t{failed_.size()});
    json_.key("failures");
    json_.begin_array();
    for (std::size_t i = 0; i < listed_; ++i) {
      const ItemReport report = store_.report(failed_[i]);
      json_.begin_array();
      json_.value(store_.id(failed_[i]));
      json_.value(name_of(report.status));
      json_.value(report.reason);
      json_.end_array();
    }
    json_.end_array();
  }

  void write_geometry(const ItemReport& report, const PackedPoints& packed) {
    json_.member("method", name_of(report.method));
    json_.member("vertices", report.vertices);
    json_.member("faces", report.faces);
    json_.member("components", report.components);
    json_.member("genus", report.genus);
    json_.member("boundaries", report.boundaries);
    json_.member("area", six_digits(report.area));
    // A sample of density d among k stands for measure / (k d): a disc of radius reach / sqrt(k d), in the
    // units of the points.
    json_.member("reach", six_digits(std::sqrt(report.measure / 3.14159265358979) / report.scale));
    json_.key("size");
    json_.begin_array();
    for (std::size_t axis = 0; axis < 3; ++axis)
      json_.value(six_digits(report.bbox[axis + 3] - report.bbox[axis]));
    json_.end_array();
    json_.key("low");
    number_list(json_, packed.low);
    json_.key("high");
    number_list(json_, packed.high);
    json_.key("density");
    number_list(json_, std::array{packed.density_low, packed.density_high});
  }

  void write_notes(const ItemReport& report) {
    if (!report.note_text.empty()) json_.member("notes", report.note_text);
    if (!store_.columns().has(&Samples::rgb)) return;
    json_.member("color_source", name_of(report.color_source));
    json_.member("color_fills", report.color_fills);
  }

  void add_coloring(const SampleColoring& coloring, const Row& row, std::vector<std::byte>& bytes) {
    if (coloring.kind == ColoringKind::number)
      add_numbers(coloring_numbers(coloring, row.samples, row.samples.count()), bytes);
    else if (coloring.kind == ColoringKind::classes)
      add_classes(coloring, row, bytes);
    else
      add_colors(coloring_bytes(coloring, row.samples, row.samples.count()), bytes);
  }

  // The range; empty where there are no values.
  void add_numbers(const std::vector<float>& numbers, std::vector<std::byte>& bytes) {
    constexpr double most = 254, none = 255;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::uint32_t i : chosen_)
      if (std::isfinite(numbers[i])) {
        low = std::min(low, double{numbers[i]});
        high = std::max(high, double{numbers[i]});
      }
    for (const std::uint32_t i : chosen_) {
      const double share = high > low ? std::clamp((numbers[i] - low) / (high - low), 0.0, 1.0) : 0;
      bytes.push_back(static_cast<std::byte>(std::isnan(numbers[i]) ? none : std::lround(most * share)));
    }
    json_.begin_array();
    for (const double end : {low, high})
      if (low <= high) json_.value(six_digits(end));
    json_.end_array();
  }

  // The classes with their names where they are few.
  void add_classes(const SampleColoring& coloring, const Row& row, std::vector<std::byte>& bytes) {
    constexpr std::int64_t none = 65535;
    const std::vector<std::int64_t> classes = coloring_classes(coloring, row.samples, row.samples.count());
    std::set<std::int64_t> used;
    for (const std::uint32_t i : chosen_) {
      const std::int64_t number = classes[i] < 0 ? none : classes[i] % none;
      bytes.push_back(static_cast<std::byte>(number & 0xFF));
      bytes.push_back(static_cast<std::byte>(number >> 8));
      if (number != none && used.size() <= most_class_keys) used.insert(number);
    }
    const std::vector<std::string> names = class_names(coloring, store_.columns(), row.names);
    json_.begin_array();
    for (const std::int64_t number : used) {
      if (used.size() > most_class_keys) break;
      json_.begin_array();
      json_.value(static_cast<std::uint64_t>(number));
      const auto n = static_cast<std::size_t>(number);
      json_.value(n < names.size() ? names[n] : std::to_string(number));
      json_.end_array();
    }
    json_.end_array();
  }

  void add_colors(const std::vector<std::uint8_t>& colors, std::vector<std::byte>& bytes) {
    for (const std::size_t i : chosen_)
      for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) bytes.push_back(std::byte{colors[k]});
    json_.begin_array();
    json_.end_array();
  }

  static bool is_single_values(const DescriptorSchema& schema) {
    return !is_histogram(schema) || schema.width == 1;
  }

  const std::vector<float>* values_of(const Row& row, const std::string& name) const {
    for (const DescriptorRow& descriptor : row.descriptors)
      if (descriptor.name == name) return &descriptor.values;
    return nullptr;
  }

  void write_values(const Row& row) {
    json_.key("values");
    json_.begin_array();
    for (const DescriptorSchema& schema : store_.descriptors()) {
      if (!is_single_values(schema)) continue;
      const std::vector<float>* values = values_of(row, schema.name);
      for (std::uint32_t i = 0; i < schema.width; ++i)
        json_.value(values ? six_digits((*values)[i]) : std::numeric_limits<double>::quiet_NaN());
    }
    json_.end_array();
  }

  void add_histogram(PageHistogram& histogram, const Row& row, std::uint64_t position,
                     std::vector<std::byte>& bytes) {
    const std::vector<float>* values = values_of(row, histogram.schema.name);
    if (!values || !is_described(histogram.schema, *values)) {
      json_.value(std::numeric_limits<double>::quiet_NaN());
      bytes.resize(bytes.size() + histogram.schema.width);
      return;
    }
    const float peak = *std::max_element(values->begin(), values->end());
    json_.value(six_digits(peak));
    for (const float value : *values)
      bytes.push_back(
          static_cast<std::byte>(peak > 0 ? std::lround(255 * std::clamp(value / peak, 0.0f, 1.0f)) : 0));
    histogram.values.insert(histogram.values.end(), values->begin(), values->end());
    histogram.position.push_back(position);
  }

  // For every histogram a list for every model of the page: position, distance, position, distance ...
  void write_neighbors() {
    json_.key("near");
    json_.begin_array();
    for (const PageHistogram& histogram : histograms_) {
      std::vector<NearRow> near;
      const std::size_t count = histogram.position.size();
      const std::size_t each = count < 2 ? 0 : std::min(shown_neighbors, count - 1);
      if (each > 0) {
        const DescriptorBlock block{histogram.values, histogram.schema.width};
        near = nearest_rows_of_all(make_descriptor_base(std::span(&block, 1), DistanceKind::l1), each);
      }
      json_.begin_array();
      for (std::size_t position = 0, i = 0; position < rows_.size(); ++position) {
        json_.begin_array();
        if (i < count && histogram.position[i] == position) {
          for (std::size_t k = 0; k < each; ++k) {
            json_.value(histogram.position[near[i * each + k].row]);
            json_.value(six_digits(near[i * each + k].distance));
          }
          ++i;
        }
        json_.end_array();
      }
      json_.end_array();
    }
    json_.end_array();
  }

  const StoreReader& store_;
  JsonWriter json_;
  std::vector<std::uint64_t> rows_, failed_;
  std::vector<std::uint32_t> chosen_;  // samples of every model
  std::vector<SampleColoring> colorings_;
  std::vector<PageHistogram> histograms_;
  std::uint64_t ok_rows_ = 0, wanted_ = 0, listed_ = 0;
  bool named_ = false;
};

}  // namespace

Option add_page_export_options(const Command& whole, PageExport& options) {
  const auto given = [&options] { options.shapes_page = true; };
  Command command = whole.under("Page");
  Option html = command
                    .add_option("--html", options.output,
                                "Write one HTML page to turn the models in, as they are stored, with "
                                "failures, certificates, histograms and nearest models")
                    .common();
  command
      .add_option("--models", options.models,
                  "--html: models on the page at most, spread over the ids, and failures listed")
      .show_default()
      .range(std::uint64_t{1}, std::uint64_t{100000})
      .on_given(given);
  command
      .add_option("--points", options.points,
                  "--html: the first points of a model (default: all, within 42 MB: 4194304 on the page, "
                  "fewer with colors or attributes)")
      .range(std::uint64_t{1}, std::uint64_t{1000000000})
      .on_given(given);
  return html;
}

int export_page(const StoreReader& store, const std::string& store_name, const PageExport& options,
                OutputGuard& guard) {
  guard.check(options.output, {FileKind::html}, "--html", options.existing);
  PageFacts facts(store, store_name, options);
  ModelPageWriter page(options.output);
  for (std::uint64_t i = 0; i < facts.rows().size(); ++i) page.append_model(facts.add_model(i));
  const std::uint64_t bytes = page.finish(facts.finish());
  fmt::print("{} x {} in {}, {:.1f} MB", counted(facts.rows().size(), "model"),
             counted(facts.points(), "point"), options.output, static_cast<double>(bytes) / 1e6);
  if (facts.models_left_out() > 0)
    fmt::print("; {} left out (--models)", counted(facts.models_left_out(), "model"));
  if (facts.failures_left_out() > 0)
    fmt::print("; {} failures not listed (--models)", facts.failures_left_out());
  if (facts.points() < store.samples())
    fmt::print("; of every model {} of {} points (--points)", facts.points(), store.samples());
  fmt::print("\n");
  return exit_done;
}

}  // namespace meander
