#include "jobs/descriptor_choice.h"

#include <fmt/format.h>

#include <algorithm>
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

DescriptorSchema schema_of(Descriptor descriptor, const DescribeParameters& parameters) {
  constexpr std::array<const char*, descriptor_names.size()> values = {
      "distance of all pairs of samples (Osada et al. 2002, D2)",
      "angle at three random samples (A3)",
      "distance of the samples from their centroid (D1)",
      "square root of the area of three random samples' triangle (D3)",
      "cube root of the volume of four random samples' tetrahedron (D4)",
      "distance along the surface from the first samples to all (heat method)",
      "area, volume, moments and bounding box of the mesh, lengths over the diagonal of the box"};
  DescriptorSchema schema{std::string(name_of(descriptor)),
                          parameters.bins,
                          {{"value", values[static_cast<std::size_t>(descriptor)]}},
                          "descriptors"};
  if (descriptor == Descriptor::basics) {
    schema.width = basics_count;
    schema.attributes.emplace_back(columns_attribute, fmt::format("{}", fmt::join(basics_names, ",")));
    return schema;
  }
  const bool scaled = descriptor == Descriptor::d2 || descriptor == Descriptor::geodesic;
  const char* const range = descriptor == Descriptor::a3 ? "pi"
                            : scaled && parameters.scale == HistogramScale::largest
                                ? "the largest value"
                                : "3 x the mean; larger values count in the last bin";
  schema.attributes.emplace_back("bins",
                                 fmt::format("shares in {} equal bins from 0 to {}", parameters.bins, range));
  return schema;
}

bool is_histogram(const DescriptorSchema& schema) {
  return std::none_of(schema.attributes.begin(), schema.attributes.end(),
                      [](const auto& attribute) { return attribute.first == columns_attribute; });
}

bool is_described(const DescriptorSchema& schema, std::span<const float> values) {
  if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) return false;
  const bool explained =
      std::any_of(schema.attributes.begin(), schema.attributes.end(), [](const auto& attribute) {
        return attribute.first == "bins" || attribute.first == columns_attribute;
      });
  return !explained || std::any_of(values.begin(), values.end(), [](float v) { return v != 0; });
}

}  // namespace meander
