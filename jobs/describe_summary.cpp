#include "jobs/describe_summary.h"

#include <fmt/format.h>

#include "io/json_writer.h"

namespace meander {

void print_describe_summary(const DescribeSummary& summary, bool as_json) {
  std::string names;
  for (const Descriptor descriptor : summary.descriptors)
    names += (names.empty() ? "" : ",") + std::string(name_of(descriptor));
  const std::uint64_t described = summary.ids.size() - summary.not_ok - summary.problems.size();
  if (as_json) {
    JsonWriter json;
    json.begin_object();
    json.member("store", summary.store);
    json.member("descriptors", names);
    json.member("rows", std::uint64_t{summary.ids.size()});
    json.member("described", described);
    json.member("not_ok", summary.not_ok);
    json.member("seconds", summary.seconds);
    json.key("problems");
    json.begin_array();
    for (const auto& [row, problem] : summary.problems) {
      json.begin_object();
      json.member("id", summary.ids[row]);
      json.member("status", name_of(problem.status));
      json.member("reason", problem.reason);
      json.end_object();
    }
    json.end_array();
    json.end_object();
    fmt::print("{}\n", json.text());
    return;
  }
  fmt::print("{}: {} rows described with {} in {:.2f} s", summary.store, described, names, summary.seconds);
  if (summary.not_ok > 0) fmt::print(", {} without samples", summary.not_ok);
  fmt::print("\n");
  if (summary.problems.empty()) return;
  fmt::print("{} rows could not be described completely; missing values are 0:\n", summary.problems.size());
  constexpr std::size_t most_shown = 100;
  std::size_t shown = 0;
  for (const auto& [row, problem] : summary.problems) {
    if (shown++ == most_shown) break;
    fmt::print("  {}: {}: {}\n", summary.ids[row], name_of(problem.status), problem.reason);
  }
  if (summary.problems.size() > most_shown)
    fmt::print("  and {} more (--json lists all)\n", summary.problems.size() - most_shown);
}

}  // namespace meander
