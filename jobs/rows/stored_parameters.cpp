#include "jobs/rows/stored_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "io/parameters_text.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/usage_error.h"
#include "jobs/rows/descriptor_choice.h"
#include "jobs/rows/run_options.h"
#include "kernels/core/joined_texts.h"
#include "kernels/model/sample_settings.h"

namespace meander {

namespace {

using Members = std::map<std::string, std::string>;

// Without what does not change the samples of a row.
Members of_samples(const std::string& parameters_json) {
  Members members = split_members(parameters_json);
  for (const char* const name : {"certify", "compress", "describe", "store"}) members.erase(name);
  for (const SampleSettings* const list : {&value_settings(), &column_settings(), &training_settings()})
    for (const auto& setting : list->items()) members.erase(setting.name);
  for (const auto& setting : describe_settings().items()) members.erase(setting.name);
  return members;
}

SampleParameters sample_parameters(const std::string& path, const std::string& parameters_json) {
  const Members stored = of_samples(parameters_json);
  const auto refuse = [&](const std::string& why) {
    return UsageError(
        fmt::format("`{}` was made with parameters that cannot be repeated here: {}", path, why));
  };
  RunOptions options;
  SampleParameters& sample = options.sample;
  GivenSettings given;
  for (const SampleSettings* const list : {&point_settings(), &collection_settings()})
    if (const std::string problem = take_recorded(*list, stored, sample, given); !problem.empty())
      throw refuse(problem);
  settle(sample, given);
  sample.columns[&Samples::rgb] = reads_textures(sample.density.kind);
  if (const std::vector<std::string> problems = validate(sample); !problems.empty())
    throw refuse(joined_texts(problems, "; "));
  if (const Members made = of_samples(recorded_parameters(options)); made != stored)
    throw refuse(parameter_differences(join_members(stored), join_members(made)));
  if (method_of(sample).follows_tensor && sample.tensor.kind == TensorKind::table)
    throw refuse("the tensors of `--tensor file:` belong to its own models");
  return sample;
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
                                 schema.name, path, joined_texts(descriptor_names)));
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

SampleParameters parameters_of_run(const std::vector<std::string>& words) {
  CommandLine line("meander", "", "", "");
  Command program = line.program();
  RunOptions options;
  RunOptionTexts texts;
  ShardOptions shard;
  add_run_command(program, options, texts, shard);
  std::vector<std::string> all = {"meander", "run", "INPUT", "-o", "STORE"};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> pointers;
  for (std::string& word : all) pointers.push_back(word.data());
  line.parse(static_cast<int>(pointers.size()), pointers.data());
  resolve_run_options(options, texts, nullptr);
  return options.sample;
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
