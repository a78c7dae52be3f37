#include "jobs/describe/describe_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "io/json_writer.h"
#include "jobs/rows/descriptor_choice.h"

namespace meander {

void RowProblems::add(std::uint64_t row, Failure problem) {
  const std::lock_guard lock(mutex_);
  by_row_.try_emplace(row, std::move(problem));
}

std::optional<Failure> RowProblems::of(std::uint64_t row) const {
  const std::lock_guard lock(mutex_);
  const auto at = by_row_.find(row);
  return at == by_row_.end() ? std::nullopt : std::optional(at->second);
}

namespace {

// Nothing failed where the status is ok: the model has no such descriptor.
std::string_view kind_of(const Failure& problem) {
  return problem.status == Status::ok ? "incomplete" : name_of(problem.status);
}

}  // namespace

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
      json.member("status", kind_of(problem));
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
  fmt::print("{} {} could not be described completely; missing values are NaN:\n", summary.problems.size(),
             summary.problems.size() == 1 ? "row" : "rows");
  constexpr std::size_t most_shown = 100;
  std::size_t shown = 0;
  for (const auto& [row, problem] : summary.problems) {
    if (shown++ == most_shown) break;
    fmt::print("  {}: {}: {}\n", summary.ids[row], kind_of(problem), problem.reason);
  }
  if (summary.problems.size() > most_shown)
    fmt::print("  and {} more (--json lists all)\n", summary.problems.size() - most_shown);
}

void add_earlier_problems(const StoreReader& store, const Describer& describer,
                          std::span<const std::uint64_t> rows, RowProblems& problems) {
  if (rows.empty()) return;
  for (const DescriptorSchema& schema : store.descriptors()) {
    if (schema.group != "descriptors" || !describer.makes(schema.name)) continue;
    constexpr std::uint64_t block = 4096;
    for (auto row = rows.begin(); row != rows.end();) {
      const std::uint64_t begin = *row, count = std::min(block, store.rows() - begin);
      const std::vector<float> values = store.read_descriptor(schema.name, begin, count);
      for (; row != rows.end() && *row < begin + count; ++row)
        if (!is_described(schema, std::span(values).subspan((*row - begin) * schema.width, schema.width)))
          problems.add(*row, {Status::ok, fmt::format("`{}` could not be made before the job was interrupted",
                                                      schema.name)});
    }
  }
}

}  // namespace meander
