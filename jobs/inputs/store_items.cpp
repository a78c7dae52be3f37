#include "jobs/inputs/store_items.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "io/item_id.h"
#include "io/parameters_text.h"
#include "io/run_error.h"
#include "io/store/run_array.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/spelling.h"

namespace meander {

void add_trust_option(Command& command, StoreCheck& check) {
  command.add_flag(
      "--trust", [&check] { check = StoreCheck::none; },
      "Do not verify the checksum of stores before reading them, which reads the whole file once; a damaged "
      "store may then give wrong values or crash");
}

namespace {

// The first id whose file has that name, with or without its extension; else the nearest in spelling among
// the first max_compared. Empty if there is none.
std::string near_id(const StoreReader& store, const std::string& item) {
  constexpr std::uint64_t max_compared = 10000;
  std::vector<std::string> ids;
  for (std::uint64_t row = 0; row < store.rows(); ++row) {
    std::string id = store.id(row);
    const std::filesystem::path path(id);
    if (path.filename() == item || path.stem() == item) return id;
    if (row < max_compared) ids.push_back(std::move(id));
  }
  return nearest(item, ids);
}

}  // namespace

std::uint64_t find_item(const StoreReader& store, const std::string& item) {
  if (const auto row = store.find(item)) return *row;
  if (const auto row = store.find(escape_id(item))) return *row;
  if (const auto row = number_in(item); row && *row < store.rows()) return *row;
  const std::string near = near_id(store, item);
  throw UsageError("no item `" + item + "` (neither an id nor a row number below " +
                   std::to_string(store.rows()) + ")" +
                   (near.empty() ? "" : ", did you mean `" + near + "`?"));
}

namespace {

// Columns that the samples of every row come with, as opposed to descriptors, which are added and taken away.
std::vector<std::string> measured_columns(const std::vector<DescriptorSchema>& columns) {
  std::vector<std::string> names;
  for (const DescriptorSchema& column : columns)
    if (column.group != DescriptorSchema{}.group) names.push_back(column.group + "/" + column.name);
  return names;
}

// "" or a sentence: programs before this one may have measured other things under the same options.
std::string column_differences(const StoreReader& store, const StoreHeader& header) {
  const std::vector<std::string> were = measured_columns(store.descriptors()),
                                 are = measured_columns(header.descriptors);
  if (were == are) return {};
  const auto list = [](const std::vector<std::string>& names) {
    return names.empty() ? std::string("none") : fmt::format("{}", fmt::join(names, ", "));
  };
  return fmt::format("the columns of measures were {}, now they are {}", list(were), list(are));
}

}  // namespace

std::string parameter_mismatch(const StoreReader& store, const StoreHeader& header) {
  std::string text;
  if (store.method_version() != store_method_version)
    text = "the method version was " + std::to_string(store.method_version()) + ", now it is " +
           std::to_string(store_method_version);
  const std::string differences = parameter_differences(store.parameters_json(), header.parameters_json);
  // With other parameters the columns follow from these.
  const std::string more = differences.empty() ? column_differences(store, header) : differences;
  return text + (text.empty() || more.empty() ? "" : "; ") + more;
}

namespace {

// A sentence about unfinished work; empty if there is none.
std::string unfinished_work(const std::string& store) {
  if (const std::optional<RunArray> array = read_run_array(store))
    return fmt::format("`{0}.run` is an array of {1} shards over {2} models: see `meander status {0}.run`",
                       store, array->shards.size(), array->rows);
  const std::optional<RunPlan> plan = read_run_plan(store);
  if (!plan) return {};
  return fmt::format(
      "`{}.run` holds an unfinished run over {} models, begun to {}: the command that began it continues it",
      store, plan->header.ids.size(), purpose_text(*plan));
}

}  // namespace

void warn_of_unfinished_run(const std::string& store) {
  if (!std::filesystem::exists(store)) {
    if (const std::string work = unfinished_work(store); !work.empty())
      throw UsageError(fmt::format("the store `{}` is not finished: {}", store, work));
    throw UsageError(fmt::format("the store `{}` does not exist", store));
  }
  if (std::filesystem::is_directory(store))
    throw UsageError(fmt::format("`{}` is a folder, not a store", store));
  try {
    if (const std::string work = unfinished_work(store); !work.empty())
      fmt::print(stderr, "meander: {}\n", work);
  } catch (const RunError&) {  // a damaged plan does not concern the store
  }
}

}  // namespace meander
