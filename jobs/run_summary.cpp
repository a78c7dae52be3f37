#include "jobs/run_summary.h"

#include <fmt/format.h>
#include <oneapi/tbb/version.h>
#include <sys/resource.h>
#include <sys/utsname.h>

#include <cerrno>
#include <cstdio>
#include <ctime>
#include <system_error>

#include "io/json_writer.h"
#include "io/store/posix_file.h"
#include "io/whole_file.h"
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
  for (const StoreSummary::Failure& failure : summary.failures)
    if (failure.status == Status::missing_attribute)
      return fmt::format("no model has the attribute that the command names: {} ({})", failure.reason,
                         failure.id);
  return {};
}

// A full disk here costs the report alone: the store is finished.
void write_beside(const std::string& name, const std::string& text) {
  try {
    write_whole_file(name, text);
  } catch (const std::system_error& error) {
    store::throw_file_error(error.code().value(), "write", name);
  }
}

std::string summary_json(const StoreSummary& summary, const RunOptions& options, double seconds,
                         std::uint64_t done_now, const std::vector<NodeStatistics>& nodes) {
  JsonWriter json;
  json.begin_object();
  json.member("store", options.store);
  json.member("items", summary.rows);
  json.member("samples", options.sample.place.samples);
  json.member("seconds", seconds);
  json.member("done_now", done_now);
  write_counts(json, "status", status_names, summary.by_status);
  write_counts(json, "method", method_names, summary.by_method);
  write_counts(json, "repairs", repair_names, summary.by_repair);
  if (const std::string lacking = lacking_attribute(summary); !lacking.empty())
    json.member("notice", lacking);
  json.key("failed");
  json.begin_array();
  for (const StoreSummary::Failure& failure : summary.failures) {
    json.begin_object();
    json.member("id", failure.id);
    json.member("status", name_of(failure.status));
    json.member("reason", failure.reason);
    json.end_object();
  }
  json.end_array();
  if (options.statistics) write_nodes(json, nodes);
  json.end_object();
  return json.text();
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

StoreSummary summarise(const StoreReader& store) {
  StoreSummary summary;
  summary.rows = store.rows();
  for (std::uint64_t row = 0; row < summary.rows; ++row) {
    ItemReport report = store.report(row);
    ++summary.by_status[static_cast<std::size_t>(report.status)];
    if (report.status == Status::ok) ++summary.by_method[static_cast<std::size_t>(report.method)];
    for (std::size_t r = 0; r < repair_count; ++r) summary.by_repair[r] += report.repairs.counts[r];
    if (report.status != Status::ok)
      summary.failures.push_back({row, store.id(row), report.status, std::move(report.reason)});
  }
  return summary;
}

void print_summary(const StoreSummary& summary, const RunOptions& options,
                   const std::map<std::string, std::uint64_t>& skipped, double seconds,
                   std::uint64_t done_now, const std::vector<NodeStatistics>& nodes) {
  if (options.json) {
    fmt::print("{}\n", summary_json(summary, options, seconds, done_now, nodes));
    return;
  }
  fmt::print("{}: {} models x {} points\n", options.store, summary.rows, options.sample.place.samples);
  if (const std::string lacking = lacking_attribute(summary); !lacking.empty()) fmt::print("  {}\n", lacking);
  for (std::size_t s = 0; s < status_names.size(); ++s) {
    if (summary.by_status[s] == 0) continue;
    fmt::print("  {:<20}{:>10}", status_names[s], summary.by_status[s]);
    if (s == 0)
      for (std::size_t m = 1; m < method_names.size(); ++m)
        if (summary.by_method[m] > 0) fmt::print("   {} {}", method_names[m], summary.by_method[m]);
    fmt::print("\n");
  }
  if (!skipped.empty()) {
    fmt::print("  other files skipped:");
    for (const auto& [extension, count] : skipped)
      fmt::print(" {} {}", extension.empty() ? "(no extension)" : extension, count);
    fmt::print("\n");
  }
  if (done_now > 0)
    fmt::print("  {} models in {:.2f} s ({:.1f} models/s)\n", done_now, seconds,
               static_cast<double>(done_now) / std::max(seconds, 1e-9));
  if (options.statistics) print_nodes(nodes);
}

void write_run_report(const RunOptions& options, const StoreSummary& summary, const GraphResult& result,
                      double seconds, const std::vector<NodeStatistics>& nodes) {
  utsname system{};
  uname(&system);
  JsonWriter json;
  json.begin_object();
  json.member("store", options.store);
  json.member("tool", std::string("meander ") + meander_version);
  json.member("compiler", meander_compiler);
  json.member("build_type", meander_build_type);
  json.member("instruction_set", "x86-64-v2");
  json.member("tbb", TBB_runtime_version());
  json.member("host", system.nodename);
  json.member("finished_unix_time", static_cast<std::int64_t>(std::time(nullptr)));
  json.member("seconds", seconds);
  json.member("threads", options.threads);
  json.member("memory_budget_bytes", options.memory_bytes);
  json.member("peak_memory_bytes", peak_memory_bytes());
  json.member("peak_reserved_bytes", result.peak_reserved_bytes);
  json.member("items_done", result.written);
  json.member("items_requeued", result.requeued);
  json.member("items", summary.rows);
  json.member("items_failed", summary.failed());
  write_nodes(json, nodes);
  json.end_object();
  write_beside(options.store + ".run.json", json.text() + "\n");
}

void write_failed_list(const RunOptions& options, const StoreSummary& summary,
                       const std::vector<PlanItem>& items) {
  const std::string name = options.store + ".failed.txt";
  if (summary.failures.empty()) {
    if (std::remove(name.c_str()) != 0 && errno != ENOENT) store::throw_file_error(errno, "remove", name);
    return;
  }
  std::string list;
  for (const StoreSummary::Failure& failure : summary.failures) {
    std::string reason = failure.reason;
    for (char& c : reason)
      if (c == '\n' || c == '\r') c = ' ';
    list += fmt::format("# {}: {}: {}\n{}\n", failure.id, name_of(failure.status), reason,
                        items[failure.row].path.string());
  }
  write_beside(name, list);
}

}  // namespace meander
