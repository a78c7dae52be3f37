#include "jobs/rows/run_summary.h"

#include <fmt/format.h>
#include <oneapi/tbb/version.h>
#include <sys/resource.h>
#include <sys/utsname.h>

#include <cstdio>
#include <ctime>

#include "io/file/atomic_file.h"
#include "io/file/directory.h"
#include "io/item_id.h"
#include "io/json_writer.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/units.h"
#include "jobs/inputs/input_options.h"
#include "jobs/rows/described_rows.h"
#include "kernels/core/instruction_set.h"
#include "kernels/core/joined_texts.h"
#include "kernels/sample/sample_colors.h"
#include "meander_version.h"

namespace meander {

namespace {

double busy_seconds(const NodeStatistics& node) {
  return static_cast<double>(node.busy_nanoseconds.load()) * 1e-9;
}

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void write_nodes(JsonWriter& json, const std::vector<NodeStatistics>& nodes) {
  for (const NodeStatistics& node : nodes)
    if (node.name == "describe_shape" && node.items.load() > 0)
      json.member(
          "describe_microseconds",
          static_cast<std::uint64_t>(busy_seconds(node) * 1e6 / static_cast<double>(node.items.load())));
  json.key("nodes");
  json.begin_array();
  for (const NodeStatistics& node : nodes) {
    json.begin_object();
    json.member("name", node.name);
    json.member("items", node.items.load());
    json.member("busy_seconds", busy_seconds(node));
    json.member("bytes", node.bytes.load());
    json.end_object();
  }
  json.end_array();
}

template <std::size_t N>
void write_counts(JsonWriter& json, const char* name, const std::array<std::string_view, N>& names,
                  const std::array<std::uint64_t, N>& counts) {
  json.key(name);
  json.begin_object();
  for (std::size_t i = 0; i < N; ++i)
    if (counts[i] > 0) json.member(names[i], counts[i]);
  json.end_object();
}

// The reason, when the models that got as far as their density or tensors all lack the attribute for it: one
// mistake of the command and not many of the files.
std::string lacking_attribute(const StoreSummary& summary) {
  const auto count = [&](Status status) { return summary.by_status[static_cast<std::size_t>(status)]; };
  if (count(Status::missing_attribute) == 0 || count(Status::ok) > 0 || count(Status::zero_density) > 0)
    return {};
  for (const StoreSummary::FailedRow& failure : summary.failures)
    if (failure.status == Status::missing_attribute)
      return fmt::format("no model has what the command names: {} ({})", failure.reason, failure.id);
  return {};
}

// Models that show no image at any sample, of a run whose density is that of their images: theirs is 1.
std::uint64_t untextured(const StoreSummary& summary, const RunOptions& options) {
  if (!reads_textures(options.sample.density.kind)) return 0;
  return summary.by_status[static_cast<std::size_t>(Status::ok)] -
         summary.by_color_source[static_cast<std::size_t>(ColorSource::texture)];
}

void write_ids(JsonWriter& json, const char* name, const std::vector<std::string>& ids) {
  json.key(name);
  json.begin_array();
  for (const std::string& id : ids) json.value(id);
  json.end_array();
}

std::string summary_json(const RunOutcome& outcome, const RunOptions& options) {
  const StoreSummary& summary = outcome.summary;
  JsonWriter json;
  json.begin_object();
  json.member("store", options.store);
  json.member("items", summary.rows);
  json.member("samples", options.sample.samples);
  json.member("seconds", outcome.seconds);
  json.member("done_now", outcome.done_now);
  json.member("added", outcome.added);
  write_ids(json, "changed", outcome.changed);
  write_ids(json, "vanished", outcome.vanished);
  write_notes(json, outcome.inputs);
  write_counts(json, "status", status_names, summary.by_status);
  write_counts(json, "method", method_names, summary.by_method);
  write_counts(json, "order_reason", order_reason_names, summary.by_order_reason);
  write_tallies(json, summary);
  if (summary.has_colors) {
    write_counts(json, "color_source", color_source_names, summary.by_color_source);
    json.member("items_with_color_fills", summary.rows_with_fills);
  }
  write_sets(json, summary);
  write_lacking(json, summary, outcome.near);
  if (reads_textures(options.sample.density.kind))
    json.member("items_without_texture", untextured(summary, options));
  if (const std::string lacking = lacking_attribute(summary); !lacking.empty())
    json.member("notice", lacking);
  json.key("failed");
  json.begin_array();
  for (const StoreSummary::FailedRow& failure : summary.failures) {
    json.begin_object();
    json.member("id", failure.id);
    json.member("status", name_of(failure.status));
    json.member("reason", failure.reason);
    json.end_object();
  }
  json.end_array();
  if (options.statistics) write_nodes(json, outcome.nodes);
  json.end_object();
  return json.text();
}

void print_ids(const std::vector<std::string>& ids, const char* what, const std::string& total) {
  constexpr std::size_t most = 20;
  if (ids.empty()) return;
  for (std::size_t i = 0; i < std::min(ids.size(), most); ++i) fmt::print(stderr, "{}: {}\n", ids[i], what);
  if (ids.size() > most) fmt::print(stderr, "... and {} more (all with --json)\n", ids.size() - most);
  fmt::print(stderr, "meander: {}\n", total);
}

// Advice on statuses that a larger limit or another machine may avoid.
void print_advice(const StoreSummary& summary) {
  std::string words;
  std::uint64_t rows = 0;
  for (const Status status : {Status::too_large, Status::timeout, Status::out_of_memory, Status::crashed}) {
    const std::uint64_t count = summary.by_status[static_cast<std::size_t>(status)];
    if (count > 0) words += (words.empty() ? "" : ",") + std::string(name_of(status));
    rows += count;
  }
  if (rows == 0) return;
  const char* const what = rows == 1 ? "row" : "rows";
  if (rows == summary.by_status[static_cast<std::size_t>(Status::crashed)])  // whatever the limits
    fmt::print(stderr, "meander: {} {} crashed; repeat the command with `--retry {}` to try again\n", rows,
               what, words);
  else
    fmt::print(stderr,
               "meander: {} {} failed because of a limit of this run or machine; repeat the command with a "
               "larger --timeout or --memory and `--retry {}` to redo {}\n",
               rows, what, words, rows == 1 ? "it" : "them");
}

void print_nodes(const std::vector<NodeStatistics>& nodes) {
  double total = 0;
  for (const NodeStatistics& node : nodes) total += busy_seconds(node);
  fmt::print("\n{:<18}{:>10}{:>12}{:>8}\n", "node", "items", "busy s", "share");
  for (const NodeStatistics& node : nodes)
    fmt::print("{:<18}{:>10}{:>12.3f}{:>7.1f}%\n", node.name, node.items.load(), busy_seconds(node),
               total > 0 ? 100 * busy_seconds(node) / total : 0.0);
}

}  // namespace

StoreSummary summarize(const StoreReader& store, bool count_descriptors) {
  StoreSummary summary;
  summary.rows = store.rows();
  summary.has_colors = store.columns().has(&Samples::rgb);
  summary.has_sharp = store.columns().has(&Samples::sharp_points);
  summary.has_sides = store.columns().has(&Samples::query_inside);
  summary.queries = store.columns().points_of(PointSet::queries, 0);
  for (std::size_t bit = 0; bit < store.columns().chosen_count(); ++bit)
    summary.lacking.emplace_back(store.columns().chosen_text(bit), 0);
  std::uint32_t missing = ~std::uint32_t{0};  // in all rows that are ok
  for (std::uint64_t row = 0; row < summary.rows; ++row) {
    ItemReport report = store.report(row);
    ++summary.by_status[static_cast<std::size_t>(report.status)];
    if (report.status == Status::ok) {
      ++summary.by_method[static_cast<std::size_t>(report.method)];
      ++summary.by_order_reason[static_cast<std::size_t>(report.order_reason)];
      ++summary.by_color_source[static_cast<std::size_t>(report.color_source)];
      if (report.color_fills > 0) ++summary.rows_with_fills;
      if (summary.has_sharp && report.sharp_edges == 0) ++summary.rows_without_sharp;
      ++summary.by_sign[static_cast<std::size_t>(report.sign_rule)];
      summary.uncertain += report.uncertain;
      missing &= report.missing;
      for (std::size_t bit = 0; bit < summary.lacking.size(); ++bit)
        summary.lacking[bit].second += report.lacks >> bit & 1;
    }
    for (std::size_t r = 0; r < repair_count; ++r)
      if (report.repairs.counts[r] > 0) summary.by_repair[r].add(report.repairs.counts[r], store.id(row));
    for (std::size_t n = 0; n < note_count; ++n) {
      if (report.notes[n] == 0) continue;
      StoreSummary::Tally& tally = summary.by_note[n];
      if (tally.models == 0) tally.example_text = clause_of(report.note_text, static_cast<Note>(n));
      tally.add(report.notes[n], store.id(row));
    }
    if (report.status != Status::ok)
      summary.failures.push_back({row, store.id(row), report.status, std::move(report.reason)});
  }
  for (std::size_t i = 0; summary.failed() < summary.rows && i < store.columns().attributes.size(); ++i)
    if ((missing >> i & 1) != 0) summary.absent.push_back(store.columns().attributes[i].name);
  if (count_descriptors) summary.undescribed = count_undescribed(store);
  return summary;
}

void StoreSummary::Tally::add(std::uint64_t more, const std::string& id) {
  if (models == 0) example = id;
  count += more;
  ++models;
}

std::string_view clause_of(std::string_view note_text, Note note) {
  const std::string name = std::string(name_of(note)) + " ";
  std::size_t begin = note_text.starts_with(name) ? 0 : note_text.find("; " + name);
  if (begin == std::string_view::npos) return {};
  if (begin > 0) begin += 2;
  std::string_view clause = note_text.substr(begin);
  clause.remove_prefix(std::min(clause.find(": "), clause.size()));
  clause.remove_prefix(std::min<std::size_t>(2, clause.size()));
  for (const std::string_view next : note_names)
    clause = clause.substr(0, clause.find("; " + std::string(next) + " "));
  return clause;
}

void print_tallies(const StoreSummary& summary) {
  const auto models = [](std::uint64_t count) { return counted(count, "model"); };
  for (std::size_t r = 0; r < repair_count; ++r)
    if (const StoreSummary::Tally& tally = summary.by_repair[r]; tally.models > 0)
      fmt::print("  repaired: {:<18}{:>12} in {}, as {}\n", repair_names[r], tally.count,
                 models(tally.models), tally.example);
  for (std::size_t n = 0; n < note_count; ++n)
    if (const StoreSummary::Tally& tally = summary.by_note[n]; tally.models > 0)
      fmt::print("  note: {:<22}{:>12} in {}, as {}{}{}\n", note_names[n], tally.count, models(tally.models),
                 tally.example, tally.example_text.empty() ? "" : ": ", tally.example_text);
}

void write_tallies(JsonWriter& json, const StoreSummary& summary) {
  json.key("repairs");
  json.begin_object();
  for (std::size_t r = 0; r < repair_count; ++r)
    if (summary.by_repair[r].models > 0) json.member(repair_names[r], summary.by_repair[r].count);
  json.end_object();
  json.key("notes");
  json.begin_object();
  for (std::size_t n = 0; n < note_count; ++n) {
    const StoreSummary::Tally& tally = summary.by_note[n];
    if (tally.models == 0) continue;
    json.key(note_names[n]);
    json.begin_object();
    json.member("count", tally.count);
    json.member("models", tally.models);
    json.member("example", tally.example);
    json.member("text", tally.example_text);
    json.end_object();
  }
  json.end_object();
}

void print_sets(const StoreSummary& summary) {
  if (summary.rows_without_sharp > 0)
    fmt::print("  {:<20}{:>10}   {} no edge as sharp as --sharp-angle; --sharp-fill stands in\n",
               "no sharp edge", summary.rows_without_sharp,
               summary.rows_without_sharp == 1 ? "this model has" : "these models have");
  for (std::size_t s = 0; summary.has_sides && s < sign_rule_names.size(); ++s)
    if (summary.by_sign[s] > 0) fmt::print("  sign: {:<14}{:>10}\n", sign_rule_names[s], summary.by_sign[s]);
  const std::uint64_t ok = summary.by_status[static_cast<std::size_t>(Status::ok)];
  if (summary.has_sides && summary.uncertain > 0)
    fmt::print("  {:<20}{:>10}   points of queries, {:.3g} % of them, have no certain side\n",
               "uncertain signs", summary.uncertain,
               100 * static_cast<double>(summary.uncertain) /
                   (static_cast<double>(ok) * static_cast<double>(summary.queries)));
}

void write_sets(JsonWriter& json, const StoreSummary& summary) {
  if (summary.has_sharp) json.member("items_without_sharp_edge", summary.rows_without_sharp);
  if (!summary.has_sides) return;
  write_counts(json, "sign_rule", sign_rule_names, summary.by_sign);
  json.member("uncertain_points", summary.uncertain);
}

void print_lacking(const StoreSummary& summary, const NearAttributes& near) {
  for (const std::string& name : summary.absent) {
    const std::vector<std::string> names = near ? near(name) : std::vector<std::string>();
    fmt::print("  no model has the attribute `{}`{}\n", name,
               names.empty() ? std::string() : fmt::format("; they have `{}`", joined_texts(names, "`, `")));
  }
  for (const auto& [column, rows] : summary.lacking)
    if (rows > 0)
      fmt::print("  {} {} {}, at some or all points, which have no value\n", rows,
                 rows == 1 ? "model lacks" : "models lack", column);
  for (const auto& [name, rows] : summary.undescribed)
    if (rows > 0)
      fmt::print("  {} {} the descriptor `{}`: it could not be made, its values are NaN\n", rows,
                 rows == 1 ? "model lacks" : "models lack", name);
}

void write_lacking(JsonWriter& json, const StoreSummary& summary, const NearAttributes& near) {
  if (!summary.absent.empty()) {
    json.key("attributes_of_no_model");
    json.begin_object();
    for (const std::string& name : summary.absent)
      write_ids(json, name.c_str(), near ? near(name) : std::vector<std::string>());
    json.end_object();
  }
  const auto write = [&](const char* name, const auto& counts) {
    if (counts.empty()) return;
    json.key(name);
    json.begin_object();
    for (const auto& [what, rows] : counts) json.member(what, rows);
    json.end_object();
  };
  write("items_that_lack", summary.lacking);
  write("items_without_descriptor", summary.undescribed);
}

int RunOutcome::exit_code() const {
  return summary.failed() > 0 || !summary.absent.empty() || !changed.empty() || !vanished.empty() ||
                 !inputs.unread.empty()
             ? exit_some_failed
             : exit_done;
}

void print_summary(const RunOutcome& outcome, const RunOptions& options) {
  const StoreSummary& summary = outcome.summary;
  print_ids(outcome.changed, "the file changed after it was sampled",
            fmt::format("changed inputs: {}; `--retry changed` samples them again", outcome.changed.size()));
  print_ids(outcome.vanished, "no input has this id now",
            fmt::format("vanished inputs: {}; their rows were kept, `--retry vanished` removes them",
                        outcome.vanished.size()));
  print_advice(summary);
  if (options.json) {
    fmt::print("{}\n", summary_json(outcome, options));
    return;
  }
  fmt::print("{}: {} x {}\n", options.store, counted(summary.rows, "model"),
             counted(options.sample.samples, "point"));
  if (const std::string lacking = lacking_attribute(summary); !lacking.empty()) fmt::print("  {}\n", lacking);
  for (std::size_t s = 0; s < status_names.size(); ++s) {
    if (summary.by_status[s] == 0) continue;
    fmt::print("  {:<20}{:>10}", status_names[s], summary.by_status[s]);
    if (s == 0)
      for (std::size_t m = 1; m < method_names.size(); ++m)
        if (summary.by_method[m] > 0) fmt::print("   {} {}", method_names[m], summary.by_method[m]);
    fmt::print("\n");
  }
  for (std::size_t r = 1; r < order_reason_names.size(); ++r)
    if (summary.by_order_reason[r] > 0)
      fmt::print("  order: {:<13}{:>10}\n", order_reason_names[r], summary.by_order_reason[r]);
  for (std::size_t c = 0; summary.has_colors && c < color_source_names.size(); ++c)
    if (summary.by_color_source[c] > 0)
      fmt::print("  colors: {:<12}{:>10}\n", color_source_names[c], summary.by_color_source[c]);
  if (summary.rows_with_fills > 0)
    fmt::print(
        "  {:<20}{:>10}   some of their samples have no color, or an image that is lost, and got the gray "
        "{}\n",
        "color fills", summary.rows_with_fills, color_fill);
  print_sets(summary);
  print_lacking(summary, outcome.near);
  print_tallies(summary);
  if (const std::uint64_t rows = untextured(summary, options); rows > 0)
    fmt::print("  {:<20}{:>10}   their density is 1: no image of theirs is there to follow\n", "no texture",
               rows);
  if (outcome.added > 0) fmt::print("  {:<20}{:>10}\n", "new inputs", outcome.added);
  if (!outcome.changed.empty()) fmt::print("  {:<20}{:>10}\n", "changed inputs", outcome.changed.size());
  if (!outcome.vanished.empty()) fmt::print("  {:<20}{:>10}\n", "vanished inputs", outcome.vanished.size());
  print_notes(outcome.inputs);
  if (outcome.done_now > 0)
    fmt::print("  {} in {:.2f} s ({:.1f} models/s)\n", counted(outcome.done_now, "model"), outcome.seconds,
               static_cast<double>(outcome.done_now) / std::max(outcome.seconds, 1e-9));
  if (options.statistics) print_nodes(outcome.nodes);
}

void write_run_report(const RunOptions& options, const RunOutcome& outcome) {
  utsname system{};
  uname(&system);
  JsonWriter json;
  json.begin_object();
  json.member("store", options.store);
  json.member("tool", std::string("meander ") + meander_version);
  json.key("builds");
  json.begin_array();
  for (const std::string& build : outcome.builds) json.value(build);
  json.end_array();
  json.member("instruction_set", name_of(best_instruction_set()));
  json.member("tbb", TBB_runtime_version());
  json.member("host", system.nodename);
  json.member("finished_unix_time", static_cast<std::int64_t>(std::time(nullptr)));
  if (!outcome.root.empty()) json.member("root", escape_id(outcome.root.string()));
  json.member("inputs_read_since_unix_ns", outcome.inputs_read_since_unix_ns);
  json.member("seconds", outcome.seconds);
  json.member("threads", options.threads);
  json.member("memory_budget_bytes", options.memory_bytes);
  json.member("peak_memory_bytes", peak_memory_bytes());
  json.member("peak_reserved_bytes", outcome.peak_reserved_bytes);
  json.member("items_done", outcome.done_now);
  json.member("items_requeued", outcome.requeued);
  json.member("longest_wait_seconds", outcome.longest_wait_seconds);
  json.member("items", outcome.summary.rows);
  json.member("items_failed", outcome.summary.failed());
  write_nodes(json, outcome.nodes);
  json.end_object();
  // A full disk here costs the report alone: the store is finished.
  replace_file(options.store + ".run.json", json.text() + "\n", FullDisk::stops_run);
}

namespace {

// A path as a line of a list; some paths cannot be written as a line. Empty: the input is gone.
std::string list_line(const std::string& path) {
  if (path.find('\n') != std::string::npos || path.ends_with('\r'))
    return "# the path of this item contains a line break: give it in a list with --null";
  return path.starts_with('#') ? "./" + path : path;
}

}  // namespace

void write_failed_list(const RunOptions& options, const StoreSummary& summary,
                       const std::function<std::filesystem::path(std::uint64_t row)>& path_of) {
  const std::string name = options.store + ".failed.txt";
  if (summary.failures.empty()) {
    remove_file(name);
    return;
  }
  std::string list;
  for (const StoreSummary::FailedRow& failure : summary.failures) {
    std::string reason = failure.reason;
    for (char& c : reason)
      if (c == '\n' || c == '\r') c = ' ';
    list += fmt::format("# {}: {}: {}\n{}\n", failure.id, name_of(failure.status), reason,
                        list_line(path_of(failure.row).string()));
  }
  replace_file(name, list, FullDisk::stops_run);
}

}  // namespace meander
