#include "jobs/descriptor_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "kernels/core/spelling.h"

namespace meander {

std::vector<Descriptor> parse_descriptors(std::string_view option, std::string_view text,
                                          std::vector<std::string>& problems) {
  std::vector<Descriptor> chosen;
  while (!text.empty()) {
    const std::string_view name = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), name.size() + 1));
    const auto at = std::find(descriptor_names.begin(), descriptor_names.end(), name);
    if (at == descriptor_names.end()) {
      const std::string near = nearest(name, descriptor_names);
      problems.push_back(fmt::format("{}: no descriptor `{}` ({}){}", option, name,
                                     fmt::join(descriptor_names, ", "),
                                     near.empty() ? "" : ", did you mean `" + near + "`?"));
      continue;
    }
    const auto descriptor = static_cast<Descriptor>(at - descriptor_names.begin());
    if (std::find(chosen.begin(), chosen.end(), descriptor) == chosen.end()) chosen.push_back(descriptor);
  }
  return chosen;
}

std::string descriptors_with(bool (*has)(const DescriptorGroup&)) {
  std::vector<std::string_view> names;
  for (const DescriptorGroup& group : descriptor_groups)
    if (has(group)) names.push_back(group.name);
  if (names.size() < 2) return names.empty() ? "none" : std::string(names.front());
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

namespace {

bool has_bins(const DescriptorGroup& group) { return group.has_bins; }
bool takes_scale(const DescriptorGroup& group) { return group.takes_scale; }
bool takes_sources(const DescriptorGroup& group) { return group.takes_sources; }

}  // namespace

void add_descriptor_shape_options(Command& command, ParameterTable& table, DescriptorShapeOptions& given,
                                  DescribeParameters& describe) {
  static constexpr Word<HistogramScale> scale_words[] = {{"mean", HistogramScale::mean},
                                                         {"largest", HistogramScale::largest}};
  table.add(command, "descriptor_bins", "--bins", describe.bins, "Bins of histograms, 8 to 1024")
      .on_given([&given] { given.bins_given = true; });
  table
      .add(command, "descriptor_scale", "--descriptor-scale", describe.scale, scale_words,
           fmt::format("Bins of {} up to 3 x the mean (Osada) or to the largest distance (the survey)",
                       descriptors_with(takes_scale)))
      .on_given([&given] { given.scale_given = true; });
  table
      .add(command, "geodesic_sources", "--geodesic-sources", describe.geodesic_sources,
           "Samples that geodesic distances start from (0: all)")
      .on_given([&given] { given.sources_given = true; });
}

void check_descriptor_shape(const DescriptorShapeOptions& given, const DescribeParameters& describe,
                            std::vector<std::string>& problems) {
  const auto check = [&](bool is_given, const char* option, bool (*shaped)(const DescriptorGroup&)) {
    if (is_given && std::none_of(describe.descriptors.begin(), describe.descriptors.end(),
                                 [&](Descriptor d) { return shaped(group_of(d)); }))
      problems.push_back(fmt::format("{} applies to {} only", option, descriptors_with(shaped)));
  };
  check(given.bins_given, "--bins", has_bins);
  check(given.scale_given, "--descriptor-scale", takes_scale);
  check(given.sources_given, "--geodesic-sources", takes_sources);
}

namespace {

DescriptorSchema schema_of(const DescriptorGroup& group, const DescribeParameters& parameters) {
  DescriptorSchema schema{
      std::string(group.name), parameters.bins, {{"value", std::string(group.value)}}, "descriptors"};
  if (group.fixed_bins.count > 0) {
    schema.width = group.fixed_bins.count;
    schema.attributes.emplace_back("bins", std::string(group.fixed_bins.text));
    return schema;
  }
  if (!group.has_bins) {
    schema.width = static_cast<std::uint32_t>(group.columns.size());
    schema.attributes.emplace_back(columns_attribute, fmt::format("{}", fmt::join(group.columns, ",")));
    return schema;
  }
  const std::string_view range = !group.range.empty() ? group.range
                                 : group.takes_scale && parameters.scale == HistogramScale::largest
                                     ? "the largest value"
                                     : "3 x the mean; larger values count in the last bin";
  schema.attributes.emplace_back("bins",
                                 fmt::format("shares in {} equal bins from 0 to {}", parameters.bins, range));
  return schema;
}

}  // namespace

std::vector<DescriptorSchema> schemas_of(const DescribeParameters& parameters) {
  std::vector<DescriptorSchema> schemas;
  for (const Descriptor descriptor : parameters.descriptors) {
    const DescriptorGroup& group = group_of(descriptor);
    schemas.push_back(schema_of(group, parameters));
    if (group.version > 1) schemas.back().attributes.emplace_back("version", std::to_string(group.version));
    for (const CompanionRow& row : group.companions)
      schemas.push_back({std::string(row.name),
                         static_cast<std::uint32_t>(row.columns.size()),
                         {{"value", std::string(row.value)},
                          {columns_attribute, fmt::format("{}", fmt::join(row.columns, ","))}},
                         "descriptors"});
  }
  return schemas;
}

std::uint32_t version_of(const DescriptorSchema& schema) {
  std::uint32_t version = 1;
  for (const auto& [name, text] : schema.attributes)
    if (name == "version") std::from_chars(text.data(), text.data() + text.size(), version);
  return version;
}

bool is_histogram(const DescriptorSchema& schema) {
  return std::none_of(schema.attributes.begin(), schema.attributes.end(),
                      [](const auto& attribute) { return attribute.first == columns_attribute; });
}

namespace {

// Null for a companion, and for a descriptor that this program does not make.
const DescriptorGroup* group_named(std::string_view name) {
  const auto at = std::find(descriptor_names.begin(), descriptor_names.end(), name);
  return at == descriptor_names.end()
             ? nullptr
             : &descriptor_groups[static_cast<std::size_t>(at - descriptor_names.begin())];
}

}  // namespace

bool has_bins_in_line(const DescriptorSchema& schema) {
  const DescriptorGroup* const group = group_named(schema.name);
  return is_histogram(schema) && (group == nullptr || group->fixed_bins.dimensions <= 1);
}

bool is_described(const DescriptorSchema& schema, std::span<const float> values) {
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) return false;
  const DescriptorGroup* const group = group_named(schema.name);
  return group == nullptr || group->may_be_zero ||
         std::any_of(values.begin(), values.end(), [](float v) { return v != 0; });
}

}  // namespace meander
