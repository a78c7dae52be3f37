// meander info shows what a store holds, as a whole or for one item.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "io/digest.h"
#include "io/file/file_error.h"
#include "io/file_kind.h"
#include "io/item_json.h"
#include "io/json/json_tree.h"
#include "io/json_writer.h"
#include "io/store/schema.h"
#include "io/store/store_reader.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/terminal.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/descriptor_choice.h"
#include "jobs/rows/run_summary.h"
#include "kernels/core/joined_texts.h"
#include "kernels/sample/sample_colors.h"

namespace meander {

namespace {

struct InfoOptions {
  std::string store;
  std::string item;
  bool failed = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
};

// Writes the count of each name as an object.
template <class Names, class Counts>
void write_counts(JsonWriter& json, const char* name, const Names& names, const Counts& counts) {
  json.object(name, [&] {
    for (std::size_t i = 0; i < names.size(); ++i) json.member(names[i], counts[i]);
  });
}

// Prints the counts that are not zero, a line each.
template <class Names, class Counts>
void print_counts(std::string_view what, const Names& names, const Counts& counts, std::size_t first = 0) {
  for (std::size_t i = first; i < names.size(); ++i)
    if (counts[i] > 0) fmt::print("  {}{:<{}}{:>10}\n", what, names[i], 20 - what.size(), counts[i]);
}

// The attributes and texture coordinates that the item lacks.
std::vector<std::string> lacking_columns(const StoreColumns& columns, const ItemReport& report) {
  std::vector<std::string> lacking;
  for (std::size_t bit = 0; bit < columns.chosen_count(); ++bit)
    if ((report.lacks >> bit & 1) != 0) lacking.push_back(columns.chosen_name(bit));
  return lacking;
}

// The names of the item's classes by attribute; empty if they cannot be read.
std::vector<std::pair<std::string, std::vector<std::string>>> class_names(const StoreReader& store,
                                                                          std::uint64_t row) {
  std::vector<std::pair<std::string, std::vector<std::string>>> all;
  const std::string text = store.names(row);
  if (text.empty()) return all;
  try {
    const JsonTree json(text);
    for (const JsonValue& list : json.root().items()) {
      std::vector<std::string>& names =
          all.emplace_back(std::string(list.name()), std::vector<std::string>{}).second;
      for (const JsonValue& name : list.items()) names.emplace_back(name.text().value_or(""));
    }
  } catch (const ItemError&) {
    all.clear();
  }
  return all;
}

int show_item(const StoreReader& store, const InfoOptions& options) {
  const std::uint64_t row = find_item(store, options.item);
  const ItemReport r = store.report(row);
  const std::int32_t label = store.label(row);
  const std::string label_name = label >= 0 ? store.label_names()[static_cast<std::size_t>(label)] : "";
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("row", row);
                 json.member("id", store.id(row));
                 json.member("status", name_of(r.status));
                 json.member("reason", r.reason);
                 json.member("label", label);
                 json.member("label_name", label_name);
                 json.member("split", name_of(store.split(row)));
                 for (const ItemColumn& column : item_columns)
                   if (column.is_in_info() && store.columns().has(column))
                     write_item(json, column, r, [&](double number) { json.value(number); });
                 if (store.columns().chosen_count() > 0)
                   json.list("lacks", lacking_columns(store.columns(), r));
                 if (store.columns().has_names()) {
                   json.object("names", [&] {
                     for (const auto& [attribute, names] : class_names(store, row))
                       json.list(attribute, names);
                   });
                 }
               }));
    return exit_done;
  }
  fmt::print("{} (row {})\n", store.id(row), row);
  fmt::print("  status            {}{}{}\n", name_of(r.status), r.reason.empty() ? "" : ": ", r.reason);
  if (label >= 0) fmt::print("  label             {} ({})\n", label_name, label);
  if (store.split(row) != Split::none) fmt::print("  split             {}\n", name_of(store.split(row)));
  fmt::print("  method            {}\n", name_of(r.method));
  if (r.order_reason != OrderReason::as_asked)
    fmt::print("  order             {}\n", name_of(r.order_reason));
  const bool is_mesh = store.columns().rows == RowKind::meshes;  // less is known of a parametric surface
  if (is_mesh) {
    fmt::print("  vertices, faces   {}, {}\n", r.vertices, r.faces);
    if (r.status == Status::ok && r.components == 0)
      fmt::print("  topology          not computed (--topology none)\n");
    else
      fmt::print("  topology          {} component(s), genus {}, {} boundary loop(s)\n", r.components,
                 r.genus, r.boundaries);
  }
  fmt::print("  area, measure     {:.9g}, {:.9g}\n", r.area, r.measure);
  fmt::print("  box               [{:.6g}, {:.6g}] x [{:.6g}, {:.6g}] x [{:.6g}, {:.6g}]\n", r.bbox[0],
             r.bbox[3], r.bbox[1], r.bbox[4], r.bbox[2], r.bbox[5]);
  if (is_mesh)
    fmt::print(
        "  chart             {} flips, overlap {:.2g}, area scale range {:.3g}, mean distortion {:.4f}\n",
        r.flips, r.overlap, r.area_scale_range, r.distortion);
  for (std::size_t i = 0; i < repair_count; ++i)
    if (r.repairs.counts[i] > 0)
      fmt::print("  repaired          {} {}\n", repair_names[i], r.repairs.counts[i]);
  for (std::size_t n = 0; n < note_count; ++n)
    if (r.notes[n] > 0)
      fmt::print("  note              {} {}: {}\n", note_names[n], r.notes[n],
                 clause_of(r.note_text, static_cast<Note>(n)));
  if (store.columns().has(&Samples::rgb))
    fmt::print("  colors            {}, {} of {} samples have the fill {}\n", name_of(r.color_source),
               r.color_fills, store.samples(), color_fill);
  if (r.lacks != 0) fmt::print("  lacks             {}\n", joined_texts(lacking_columns(store.columns(), r)));
  for (const auto& [attribute, names] : class_names(store, row)) {
    constexpr std::size_t max_shown = 20;
    const std::span<const std::string> shown = std::span(names).first(std::min(names.size(), max_shown));
    fmt::print("  {:<18}{}{}\n", attribute, joined_texts(shown),
               names.size() > max_shown ? fmt::format(", ... ({} in all; --json)", names.size()) : "");
  }
  for (const DescriptorRow& descriptor : store.read_row(row).descriptors)
    if (descriptor.values.size() == 1)
      fmt::print("  {:<18}{:.4g}\n", descriptor.name, descriptor.values.front());
  fmt::print("  content           {}\n", hex_text(r.content_sha256));
  return exit_done;
}

// The version of the program that computed a descriptor: that of the samples, unless another one added it.
std::string made_by(const StoreReader& store, const DescriptorSchema& descriptor) {
  for (const auto& [name, text] : descriptor.attributes)
    if (name == "tool_version") return text;
  return store.tool_version();
}

// The parameters as one line of JSON, on a terminal broken between its members.
std::string shown_parameters(const std::string& json) {
  if (isatty(STDOUT_FILENO) == 0) return json;
  const auto width = static_cast<std::size_t>(terminal_width(STDOUT_FILENO));
  std::string text;
  std::size_t column = std::string_view("parameters ").size();
  for (std::size_t begin = 0; begin < json.size();) {
    // A comma before a quotation mark: within texts this is escaped.
    const std::size_t comma = json.find(",\"", begin), end = comma == json.npos ? json.size() : comma + 1;
    if (begin > 0 && column + (end - begin) > width) {
      text += "\n  ";
      column = 2;
    }
    text.append(json, begin, end - begin);
    column += end - begin;
    begin = end;
  }
  return text;
}

void show_counts(const StoreReader& store, const StoreSummary& summary) {
  fmt::print("{} x {}, format {}, method version {}, made by meander {}\n", counted(store.rows(), "model"),
             counted(store.samples(), "point"), store.format_version(), store.method_version(),
             store.tool_version());
  fmt::print("parameters {}\n", shown_parameters(store.parameters_json()));
  print_counts("", status_names, summary.by_status);
  print_counts("method ", method_names, summary.by_method, 1);
  print_counts("order: ", order_reason_names, summary.by_order_reason, 1);
  if (summary.has_colors) print_counts("colors: ", color_source_names, summary.by_color_source);
  if (summary.rows_with_fills > 0) fmt::print("  {:<20}{:>10}\n", "color fills", summary.rows_with_fills);
  print_sets(summary);
  if (store.columns().are_chosen())
    fmt::print("  columns {}\n", joined_texts(store::column_list(store.columns())));
  print_lacking(summary);
  print_tallies(summary);
  std::vector<std::uint64_t> members(store.label_names().size(), 0);
  std::array<std::uint64_t, split_names.size()> of_split{};
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    if (store.label(row) >= 0) ++members[static_cast<std::size_t>(store.label(row))];
    ++of_split[static_cast<std::size_t>(store.split(row))];
  }
  for (std::size_t c = 0; c < members.size(); ++c)
    fmt::print("  class {:<14}{:>10}\n", store.label_names()[c], members[c]);
  print_counts("split ", split_names, of_split, 1);
  for (const DescriptorSchema& descriptor : store.descriptors())
    fmt::print("  descriptor {} ({} {}), version {}, made by meander {}\n", descriptor.name, descriptor.width,
               descriptor.width == 1 ? "value" : "values", version_of(descriptor),
               made_by(store, descriptor));
}

void show_counts_json(const StoreReader& store, const StoreSummary& summary) {
  fmt::print("{}\n", json_object([&](JsonWriter& json) {
               json.member("rows", store.rows());
               json.member("samples", store.samples());
               json.member("format_version", store.format_version());
               json.member("method_version", store.method_version());
               json.member("tool_version", store.tool_version());
               json.member("parameters", store.parameters_json());
               write_counts(json, "status", status_names, summary.by_status);
               write_counts(json, "method", method_names, summary.by_method);
               write_counts(json, "order_reason", order_reason_names, summary.by_order_reason);
               if (summary.has_colors) {
                 write_counts(json, "color_source", color_source_names, summary.by_color_source);
                 json.member("items_with_color_fills", summary.rows_with_fills);
               }
               write_sets(json, summary);
               json.list("columns", store::column_list(store.columns()));
               write_lacking(json, summary);
               write_tallies(json, summary);
               json.list("descriptors", store.descriptors(), [&](const DescriptorSchema& descriptor) {
                 json.member("name", descriptor.name);
                 json.member("values", descriptor.width);
                 json.member("version", version_of(descriptor));
                 json.member("made_by", made_by(store, descriptor));
               });
             }));
}

// The one store in the working folder. A pack (NAME.pack-00000.h5) belongs to its index, NAME.h5.
std::string only_store() {
  std::set<std::string> stores;
  for (const auto& entry : std::filesystem::directory_iterator(".")) {
    const std::string name = entry.path().filename().string();
    try {
      std::error_code error;
      if (entry.is_regular_file(error) && kind_of_file(name) == FileKind::store) stores.insert(name);
    } catch (const FileError&) {  // a file that cannot be read is no store to show
    }
  }
  std::erase_if(stores, [all = stores](const std::string& name) {
    const std::size_t pack = name.rfind(".pack-"), end = name.rfind('.');
    return pack != std::string::npos && pack < end && all.contains(name.substr(0, pack) + name.substr(end));
  });
  if (stores.empty()) throw UsageError("STORE is required: there is no store in this folder");
  if (stores.size() > 1)
    throw UsageError(fmt::format("STORE is required: there are {} stores in this folder, such as `{}`",
                                 stores.size(), *stores.begin()));
  fmt::print(stderr, "meander: the store of this folder is `{}`\n", *stores.begin());
  return *stores.begin();
}

int info(const InfoOptions& options) {
  warn_of_unfinished_run(options.store);
  const StoreReader store(options.store, options.check);
  if (!options.item.empty()) return show_item(store, options);
  const StoreSummary summary = summarize(store, !options.failed && options.check == StoreCheck::every_byte);
  if (options.failed) {
    for (const StoreSummary::FailedRow& failure : summary.failures)
      fmt::print("{}: {}: {}\n", failure.id, name_of(failure.status), failure.reason);
  } else if (options.json) {
    show_counts_json(store, summary);
  } else {
    show_counts(store, summary);
  }
  return exit_done;
}

}  // namespace

JobFunction add_info_job(Command& program) {
  Command command = program.add_subcommand("info", "Show what a store holds, as a whole or for one item");
  command.example("meander info store.h5", "Counts of models, statuses, classes and columns");
  command.example("meander info store.h5 chair/m12.off", "Everything about one model");
  auto options = std::make_shared<InfoOptions>();
  command.add_option("STORE", options->store, "The store (default: the one in this folder)");
  command.add_option("ITEM", options->item, "An id or a row number: show everything about this item");
  command.add_flag("--failed", options->failed, "One line per failed item: id: status: reason");
  command.add_flag("--json", options->json, "As JSON");
  add_trust_option(command, options->check);
  return [options] {
    if (options->failed && (options->json || !options->item.empty()))
      throw UsageError("--failed prints all failed items as text: leave ITEM and --json out");
    if (options->store.empty()) options->store = only_store();
    return info(*options);
  };
}

}  // namespace meander
