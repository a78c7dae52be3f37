#include "jobs/describe/describe_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <system_error>

#include "io/parameters_text.h"
#include "io/store/run_plan.h"
#include "io/store/store_reader.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/settings.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"
#include "kernels/core/joined_texts.h"
#include "kernels/model/sample_settings.h"
#include "meander_version.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

bool has(const std::vector<Descriptor>& list, Descriptor descriptor) {
  return std::find(list.begin(), list.end(), descriptor) != list.end();
}

struct Described {
  Descriptor descriptor;
  bool now;  // by this job; else it is in the store already
};

// Merges a parameter that matters to some descriptors: one value if these agree, else one for each.
void merge_parameter(std::map<std::string, std::string>& members, const char* name, const std::string& value,
                     const std::vector<Described>& described, bool (*matters)(Descriptor)) {
  std::map<std::string, std::string> values, before;
  const std::string old = members.contains(name) ? members[name] : value;
  if (old.starts_with('{')) before = split_members(old);
  for (const Described& d : described) {
    if (!matters(d.descriptor)) continue;
    const std::string key(name_of(d.descriptor));
    values[key] = d.now ? value : before.contains(key) ? before[key] : old;
  }
  const bool one = std::all_of(values.begin(), values.end(),
                               [&](const auto& v) { return v.second == values.begin()->second; });
  members[name] = values.empty() ? value : one ? values.begin()->second : join_members(values);
}

// The parameters of `meander run --describe`, with the present descriptors added.
std::string described_parameters(const StoreReader& store, const std::vector<DescriptorSchema>& schemas,
                                 const DescribeParameters& describe) {
  std::map<std::string, std::string> members = split_members(store.parameters_json());
  std::vector<Described> described;
  std::string names;
  for (const DescriptorSchema& schema : schemas) {
    if (schema.group != "descriptors") continue;
    if (is_companion(schema.name)) continue;
    names += (names.empty() ? "" : ",") + schema.name;
    const auto at = std::find(descriptor_names.begin(), descriptor_names.end(), schema.name);
    if (at == descriptor_names.end()) continue;  // made by a later version
    const auto descriptor = static_cast<Descriptor>(at - descriptor_names.begin());
    described.push_back({descriptor, has(describe.descriptors, descriptor)});
  }
  members["describe"] = "\"" + names + "\"";
  merge_parameter(members, "descriptor_bins", fmt::format("{}", describe.bins), described,
                  [](Descriptor d) { return group_of(d).has_bins; });
  merge_parameter(members, "descriptor_scale",
                  describe.scale == HistogramScale::mean ? "\"mean\"" : "\"largest\"", described,
                  [](Descriptor d) { return group_of(d).takes_scale; });
  merge_parameter(members, "geodesic_sources", fmt::format("{}", describe.geodesic_sources), described,
                  [](Descriptor d) { return group_of(d).takes_sources; });
  return join_members(members);
}

// The header of a job that died after it had replaced the store and before it removed its run, which is then
// finished again; else empty.
std::optional<StoreHeader> done_before(const StoreReader& store, const DescribeOptions& options) {
  const fs::path output = described_output(options);
  if (options.fresh || options.replace || output != fs::path(options.store)) return std::nullopt;
  std::optional<RunPlan> begun = read_run_plan(output);
  if (!begun || begun->purpose != RunPurpose::describe ||
      begun->header.parameters_json != store.parameters_json())
    return std::nullopt;
  const std::vector<DescriptorSchema>& there = store.descriptors();
  const std::vector<DescriptorSchema> wanted = schemas_of(options.describe);
  const bool has_all = std::all_of(wanted.begin(), wanted.end(), [&](const DescriptorSchema& schema) {
    return std::any_of(there.begin(), there.end(), [&](const auto& d) { return d.name == schema.name; });
  });
  const bool same_shape = described_parameters(store, there, options.describe) == store.parameters_json();
  return has_all && same_shape ? std::optional(std::move(begun->header)) : std::nullopt;
}

std::string described_by_meshes() {
  return descriptors_with([](const DescriptorGroup& group) { return group.needs_mesh; });
}

}  // namespace

StoreHeader described_header(const StoreReader& store, const DescribeOptions& options) {
  if (std::optional<StoreHeader> done = done_before(store, options)) return *std::move(done);
  StoreHeader header = store.header();
  header.descriptors.clear();
  std::vector<DescriptorSchema> added = schemas_of(options.describe);
  if (store.tool_version() != meander_version)
    for (DescriptorSchema& schema : added) schema.attributes.emplace_back("tool_version", meander_version);
  // The descriptors of the store keep their places; measures of the samples come last.
  std::vector<DescriptorSchema> measures;
  for (const DescriptorSchema& old : store.descriptors()) {
    if (old.group != "descriptors") {
      measures.push_back(old);
      continue;
    }
    const auto again = std::find_if(added.begin(), added.end(),
                                    [&](const DescriptorSchema& schema) { return schema.name == old.name; });
    if (again != added.end() && !options.replace)
      throw UsageError(fmt::format("`{}` already has the descriptor {} (--replace computes it again)",
                                   options.store, old.name));
    header.descriptors.push_back(again == added.end() ? old : *again);
    if (again != added.end()) added.erase(again);
  }
  header.descriptors.insert(header.descriptors.end(), added.begin(), added.end());
  header.descriptors.insert(header.descriptors.end(), measures.begin(), measures.end());
  header.parameters_json = described_parameters(store, header.descriptors, options.describe);
  return header;
}

void resolve_describe_options(DescribeOptions& options) {
  std::vector<std::string> problems;
  DescribeParameters& describe = options.describe;
  if (const std::string problem = take_descriptors(options.descriptors, describe.descriptors);
      !problem.empty())
    problems.push_back("--descriptors: " + problem);
  if (options.descriptors.empty())
    problems.push_back(fmt::format("--descriptors is required: one or more of {}, separated by commas",
                                   joined_texts(descriptor_names)));
  const bool meshes = std::any_of(describe.descriptors.begin(), describe.descriptors.end(), needs_mesh);
  if (problems.empty() && meshes && options.inputs.empty())
    problems.push_back(
        fmt::format("{} need the meshes, whose paths a store does not keep: give the inputs of the run after "
                    "the store (meander describe STORE INPUT... --descriptors ...)",
                    described_by_meshes()));
  if (problems.empty() && !meshes && !options.inputs.empty())
    problems.push_back(
        fmt::format("{} needs no meshes: leave `{}` out", options.descriptors, options.inputs.front()));
  if (problems.empty()) options.settings.finish(problems);
  if (!options.shard.empty()) {
    try {
      options.rows = parse_shard(options.shard);
    } catch (const UsageError& error) {
      problems.emplace_back(error.what());
    }
    if (options.output.empty())
      problems.push_back("--shard describes a part of the rows: name another store for it with -o");
  }
  resolve_work_options(options);
  if (!problems.empty()) throw UsageError(joined_texts(problems, "\n"));
}

// The columns that a descriptor is made from, beside the points.
ColumnSet columns_for(Descriptor descriptor) {
  ColumnSet columns;
  columns[&Samples::face] = columns[&Samples::corners] = needs_mesh(descriptor);
  columns[&Samples::barycentric] = group_of(descriptor).needs_triangles;
  columns[&Samples::curve_rank] = descriptor == Descriptor::shapedna;
  columns[&Samples::normals] = descriptor == Descriptor::pairs_unsigned;
  return columns;
}

std::unique_ptr<StoreReader> open_described_store(const DescribeOptions& options) {
  const fs::path unfinished = options.store + ".run";
  if (!fs::exists(options.store) && fs::exists(unfinished))
    throw UsageError("`" + options.store + "` is not finished: repeat the `meander` command that began it");
  auto store = std::make_unique<StoreReader>(options.store, options.check, options.rows);
  if (store->columns().rows == RowKind::surfaces && !options.inputs.empty())
    throw UsageError("`" + options.store + "` is a store of parametric surfaces: there are no meshes for " +
                     described_by_meshes());
  for (const Descriptor descriptor : options.describe.descriptors)
    for (std::size_t c = 0; c < sample_columns.size(); ++c)
      if (columns_for(descriptor)[c])
        store->require(c, fmt::format("the descriptor {}", name_of(descriptor)));
  return store;
}

fs::path described_output(const DescribeOptions& options) {
  std::error_code none;
  const bool in_place = options.output.empty() || fs::equivalent(options.output, options.store, none);
  return in_place ? options.store : options.output;
}

void check_described_output(const DescribeOptions& options, std::span<const fs::path> files_read) {
  const fs::path output = described_output(options);
  const bool in_place = output == fs::path(options.store);
  if (in_place && !options.shard.empty())
    throw UsageError(
        fmt::format("--shard: a part of `{}` cannot replace the whole: give another -o", options.store));
  OutputGuard guard;
  guard.protect(files_read);
  if (!in_place) guard.protect(options.store, "the store itself");
  check_store_output(output, options.fresh, guard);
  if (!in_place && !options.fresh) refuse_finished_store(output, RunPurpose::describe);
}

Command add_describe_command(Command& program, DescribeOptions& options) {
  Command command =
      program.add_subcommand("describe", "Add descriptors to a finished store without sampling again");
  command.example("meander describe store.h5 models/ --descriptors pairs,d2",
                  "Two descriptors of every model");
  command.example("meander describe store.h5 --descriptors d1 -o described.h5", "Into another store");
  command.add_option("STORE", options.store, "The store; it is replaced as a whole at the end").required();
  command.add_option("INPUT", options.inputs,
                     fmt::format("The inputs of `meander run`, for {}; files are found by their ids",
                                 described_by_meshes()));
  command
      .add_option("--descriptors", options.descriptors,
                  fmt::format("One or more of {}, separated by commas; required",
                              joined_texts(descriptor_names, ",")))
      .common();
  command.add_option("-o,--output", options.output, "Write to this store instead").common();
  options.settings.add(command, describe_settings(), options.describe);
  command.add_option(
      "--shard", options.shard,
      "Describe part i of n of the rows, from 0/n, into the store of -o; `meander merge` joins the parts");
  command.add_flag("--replace", options.replace, "Recompute descriptors that the store already has").common();
  add_list_options(command, options.collect);
  Command running = command.under("Running");
  running.add_flag("--fresh", options.fresh,
                   "Discard the unfinished work of an earlier describe (and OUTPUT)");
  add_trust_option(running, options.check);
  add_budget_options(running, options);
  add_progress_options(command.under("Report"), options);
  return command;
}

}  // namespace meander
