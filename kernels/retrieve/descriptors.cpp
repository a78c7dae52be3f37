#include "kernels/public/descriptors.h"

#include <algorithm>
#include <stdexcept>

#include "kernels/retrieve/descriptor_distance.h"

namespace meander {

namespace {

DescriptorBase base_of(std::span<const std::span<const float>> rows, DistanceKind kind) {
  std::vector<float> values;
  for (const std::span<const float> row : rows) {
    if (row.empty() || row.size() != rows.front().size())
      throw std::invalid_argument("descriptors of different lengths, or without numbers, have no distance");
    values.insert(values.end(), row.begin(), row.end());
  }
  const DescriptorBlock block{values, static_cast<std::uint32_t>(rows.front().size())};
  return make_descriptor_base({&block, 1}, kind);
}

}  // namespace

float descriptor_distance(std::span<const float> a, std::span<const float> b, DistanceKind kind) {
  const std::span<const float> rows[] = {a, b};
  return descriptor_distance(base_of(rows, kind), 0, 1);
}

std::vector<float> descriptor_distances(std::span<const std::vector<float>> rows, DistanceKind kind) {
  if (rows.empty()) throw std::invalid_argument("no descriptors were given");
  const std::vector<std::span<const float>> spans(rows.begin(), rows.end());
  std::vector<float> distances;
  distances.reserve(rows.size() * rows.size());
  visit_distances(base_of(spans, kind), [&](std::size_t, std::span<const float> block) {
    distances.insert(distances.end(), block.begin(), block.end());
  });
  return distances;
}

}  // namespace meander
