#include "jobs/stored_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "io/parameters_text.h"
#include "jobs/command_line.h"
#include "jobs/descriptor_choice.h"
#include "jobs/run_options.h"

namespace meander {

namespace {

using Members = std::map<std::string, std::string>;
using Arguments = std::vector<std::string>;

// What does not change the samples of a row.
constexpr std::string_view not_of_samples[] = {
    "attributes",      "certify",          "colors",           "compress", "describe",
    "descriptor_bins", "descriptor_scale", "geodesic_sources", "store",    "texcoord"};

Members of_samples(const std::string& parameters_json) {
  Members members = split_members(parameters_json);
  for (const std::string_view name : not_of_samples) members.erase(std::string(name));
  return members;
}

// The options of `run` as a command line of these arguments sets them.
class RepeatedRun {
 public:
  explicit RepeatedRun(const Arguments& arguments) : line_("meander", "", "", "") {
    add_run_command(program_, options_, texts_, shard_);
    Arguments all = {"meander", "run", "INPUT", "-o", "STORE"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& argument : all) pointers.push_back(argument.data());
    line_.parse(static_cast<int>(pointers.size()), pointers.data());
    resolve_run_options(options_, texts_, nullptr);
  }
  const RunOptions& options() const { return options_; }
  Members parameters() const { return of_samples(options_.parameters_json); }
  Arguments arguments(const Members& members) const {
    ParameterTable all = texts_.table;
    all.append(texts_.tensor_table);
    return all.arguments(members);
  }

 private:
  CommandLine line_;
  Command program_ = line_.program();
  RunOptions options_;
  RunOptionTexts texts_;
  ShardOptions shard_;
};

SampleParameters sample_parameters(const std::string& path, const std::string& parameters_json) {
  const Members stored = of_samples(parameters_json);
  const auto refuse = [&](const std::string& why) {
    return UsageError(
        fmt::format("`{}` was made with parameters that cannot be repeated here: {}", path, why));
  };
  try {
    // Defaults depend on other options: what still differs is given in the next round.
    std::optional<RepeatedRun> repeated;
    repeated.emplace(Arguments{});
    Members given;
    for (Members made = repeated->parameters(); made != stored; made = repeated->parameters()) {
      const std::size_t before = given.size();
      std::set_difference(stored.begin(), stored.end(), made.begin(), made.end(),
                          std::inserter(given, given.end()));
      if (given.size() == before)
        throw refuse(parameter_differences(join_members(stored), join_members(made)));
      const Arguments arguments = repeated->arguments(given);
      try {
        repeated.emplace(arguments);
      } catch (const UsageError& error) {  // of the options, which nobody gave
        throw refuse(error.what());
      }
    }
    const SampleParameters& sample = repeated->options().sample;
    if (method_of(sample).follows_tensor && sample.tensor.kind == TensorKind::table)
      throw refuse("the tensors of `--tensor file:` belong to its own models");
    return sample;
  } catch (const RunError& error) {
    throw refuse(error.what());
  }
}

// A parameter of a descriptor: one value for all, or an object by descriptor.
std::string value_for(const Members& members, const char* name, std::string_view descriptor) {
  const auto at = members.find(name);
  if (at == members.end()) return {};
  if (!at->second.starts_with('{')) return at->second;
  const Members values = split_members(at->second);
  const auto value = values.find(std::string(descriptor));
  return value == values.end() ? std::string() : value->second;
}

std::uint32_t number_for(const Members& members, const char* name, std::string_view descriptor,
                         std::uint32_t otherwise) {
  const std::string text = value_for(members, name, descriptor);
  return text.empty() ? otherwise : static_cast<std::uint32_t>(std::stoul(text));
}

DescribeParameters describe_parameters(const std::string& path, const std::string& parameters_json,
                                       const DescriptorSchema& schema) {
  const auto group =
      std::find_if(descriptor_groups.begin(), descriptor_groups.end(),
                   [&](const DescriptorGroup& g) { return makes_row(g.descriptor, schema.name); });
  if (group == descriptor_groups.end())
    throw UsageError(fmt::format("the descriptor {} of `{}` is not one that this program makes ({})",
                                 schema.name, path, fmt::join(descriptor_names, ", ")));
  if (schema.name == group->name && version_of(schema) != group->version)
    throw UsageError(
        fmt::format("the descriptor {} of `{}` is version {}, this program makes version {}: `meander "
                    "describe --replace`",
                    schema.name, path, version_of(schema), group->version));
  const Members members = split_members(parameters_json);
  DescribeParameters describe;
  describe.descriptors = {group->descriptor};
  describe.bins = number_for(members, "descriptor_bins", group->name, describe.bins);
  describe.geodesic_sources = number_for(members, "geodesic_sources", group->name, describe.geodesic_sources);
  if (value_for(members, "descriptor_scale", group->name) == "\"largest\"")
    describe.scale = HistogramScale::largest;
  return describe;
}

}  // namespace

SampleParameters parameters_of_run(const std::vector<std::string>& options) {
  return RepeatedRun(options).options().sample;
}

StoredParameters stored_parameters(const StoreReader& store, const std::string& path,
                                   std::span<const DescriptorSchema> wanted) {
  if (store.columns().rows == RowKind::surfaces)
    throw UsageError(
        fmt::format("`{}` is a store of parametric surfaces: no mesh is sampled as they were", path));
  StoredParameters result;
  result.sample = sample_parameters(path, store.parameters_json());
  result.sample.describe.descriptors.clear();
  for (const DescriptorSchema& schema : wanted)
    result.describe.push_back(describe_parameters(path, store.parameters_json(), schema));
  return result;
}

}  // namespace meander
