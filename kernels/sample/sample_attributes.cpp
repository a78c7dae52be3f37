#include "kernels/sample/sample_attributes.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "kernels/sample/polygon_corners.h"

namespace meander {

namespace {

constexpr std::size_t attribute_samples_between_checks = 65536;

using AttributeNames = std::array<std::string, 4>;  // of the first `width` numbers

// The values of each number of a column; empty where one is missing.
using AttributeSources = std::vector<const std::vector<double>*>;

AttributeSources sources_in(std::span<const ScalarAttribute> attributes, const AttributeNames& names,
                            std::uint32_t width) {
  AttributeSources sources;
  for (std::uint32_t k = 0; k < width; ++k) {
    for (const ScalarAttribute& attribute : attributes)
      if (attribute.name == names[k] && sources.size() == k) sources.push_back(&attribute.values);
    if (sources.size() == k) return {};
  }
  return sources;
}

// The first spelling that the list has.
AttributeSources sources_of(std::span<const ScalarAttribute> attributes, const AttributeColumn& column) {
  if (column.width == 1) return sources_in(attributes, {column.name}, 1);
  for (const std::array<const char*, 4>& suffixes :
       {std::array<const char*, 4>{"_0", "_1", "_2", "_3"}, {"_x", "_y", "_z", "_w"}}) {
    AttributeNames names;
    for (std::size_t k = 0; k < names.size(); ++k) names[k] = column.name + suffixes[k];
    AttributeSources sources = sources_in(attributes, names, column.width);
    if (!sources.empty()) return sources;
  }
  return {};
}

std::array<double, 3> corner_weights(const Samples& samples, std::size_t i) {
  const double b1 = samples.barycentric[2 * i], b2 = samples.barycentric[2 * i + 1];
  return {1 - b1 - b2, b1, b2};
}

// value(i, k): number k of sample i.
template <class Value>
SampleValues values_at(const Samples& samples, std::uint32_t width, const CancelToken& cancel,
                       const Value& value) {
  SampleValues made;
  made.values.resize(width * samples.count());
  for (std::size_t i = 0; i < samples.count(); ++i) {
    if (i % attribute_samples_between_checks == 0) cancel.check();
    float* const to = made.values.data() + width * i;
    bool is_finite = true;
    for (std::uint32_t k = 0; k < width; ++k) {
      const double number = value(i, k);
      is_finite = is_finite && std::abs(number) <= double{std::numeric_limits<float>::max()};
      to[k] = is_finite ? static_cast<float>(number) : 0;
    }
    if (is_finite) continue;
    made.lacks_some = true;
    for (std::uint32_t k = 0; k < width; ++k) to[k] = std::numeric_limits<float>::quiet_NaN();
  }
  return made;
}

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

double number_at(const std::vector<double>& values, std::size_t at) {
  return at < values.size() ? values[at] : no_number;
}

}  // namespace

SampleValues sample_attribute(const PolygonMesh& mesh, const AttributeColumn& column, const Samples& samples,
                              const CancelToken& cancel) {
  AttributeSources vertices = sources_of(mesh.vertex_attributes, column);
  if (vertices.empty()) vertices = sources_of(mesh.asked_attributes, column);
  if (!vertices.empty())
    return values_at(samples, column.width, cancel, [&](std::size_t i, std::uint32_t k) {
      const std::array<double, 3> weights = corner_weights(samples, i);
      double sum = 0;
      for (std::size_t c = 0; c < 3; ++c)
        sum += weights[c] * number_at(*vertices[k], samples.corners[3 * i + c]);
      return sum;
    });
  const AttributeSources faces = sources_of(mesh.face_attributes, column);
  return values_at(samples, column.width, cancel, [&](std::size_t i, std::uint32_t k) {
    return faces.empty() ? no_number : number_at(*faces[k], samples.face[i]);
  });
}

SampleValues sample_coordinates(const PolygonMesh& mesh, const Samples& samples, const CancelToken& cancel) {
  const CornerCoordinates& coordinates = mesh.coordinates;
  PolygonCorners corners(mesh);
  std::array<std::size_t, 3> at{};  // of the sample that is asked for its first number
  return values_at(samples, 2, cancel, [&](std::size_t i, std::uint32_t k) {
    if (coordinates.values.empty()) return no_number;
    for (std::size_t c = 0; k == 0 && c < 3; ++c) {
      const std::uint32_t corner = corners.find(samples.face[i], samples.corners[3 * i + c]);
      at[c] = corner < coordinates.corner.size() ? coordinates.corner[corner] : std::size_t{no_index};
    }
    const std::array<double, 3> weights = corner_weights(samples, i);
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t number = 2 * at[c] + k;
      sum +=
          weights[c] * (number < coordinates.values.size() ? double{coordinates.values[number]} : no_number);
    }
    return sum;
  });
}

}  // namespace meander
