#include "jobs/rows/descriptor_choice.h"
#include "kernels/core/joined_texts.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace meander {

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
    schema.attributes.emplace_back(columns_attribute, joined_texts(group.columns, ","));
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
      schemas.push_back(
          {std::string(row.name),
           static_cast<std::uint32_t>(row.columns.size()),
           {{"value", std::string(row.value)}, {columns_attribute, joined_texts(row.columns, ",")}},
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
  return schema.group == "descriptors" && is_histogram(schema) &&
         (group == nullptr || group->fixed_bins.dimensions <= 1);
}

bool is_described(const DescriptorSchema& schema, std::span<const float> values) {
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) return false;
  const DescriptorGroup* const group = group_named(schema.name);
  return group == nullptr || group->may_be_zero ||
         std::any_of(values.begin(), values.end(), [](float v) { return v != 0; });
}

}  // namespace meander
