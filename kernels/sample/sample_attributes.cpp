#include "kernels/sample/sample_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "kernels/mesh/polygon_corners.h"

namespace meander {

namespace {

constexpr std::size_t attribute_samples_between_checks = 65536;

using AttributeNames = std::array<std::string, 4>;  // of the first `width` numbers

// The attribute of each number of a column; empty where one is missing.
using AttributeSources = std::vector<const ScalarAttribute*>;

AttributeSources sources_in(std::span<const ScalarAttribute> attributes, const AttributeNames& names,
                            std::uint32_t width) {
  AttributeSources sources;
  for (std::uint32_t k = 0; k < width; ++k) {
    for (const ScalarAttribute& attribute : attributes)
      if (attribute.name == names[k] && sources.size() == k) sources.push_back(&attribute);
    if (sources.size() == k) return {};
  }
  return sources;
}

// The first spelling that the list has.
AttributeSources sources_of(std::span<const ScalarAttribute> attributes, const AttributeColumn& column) {
  if (column.width == 1) return sources_in(attributes, {column.name}, 1);
  for (const std::array<const char*, 4>& suffixes : attribute_suffixes) {
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

std::size_t nearest_corner(const Samples& samples, std::size_t i) {
  const std::array<double, 3> weights = corner_weights(samples, i);
  return static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
}

// What a column stores, and whether a number is one that it can hold.
struct FloatNumbers {
  using Value = float;
  static constexpr float none = std::numeric_limits<float>::quiet_NaN();
  static bool holds(double number) { return std::abs(number) <= double{std::numeric_limits<float>::max()}; }
};
struct ExactNumbers : FloatNumbers {
  static bool holds(double number) {
    return FloatNumbers::holds(number) && number == std::floor(number) &&
           double{static_cast<float>(number)} == number;
  }
};
struct ClassNumbers {
  using Value = std::int32_t;
  static constexpr std::int32_t none = no_sample_class;
  static bool holds(double number) {  // of NaN neither comparison is true
    using Limits = std::numeric_limits<std::int32_t>;
    return number >= Limits::min() && number <= Limits::max() && number == std::floor(number);
  }
};

// value(i, k): number k of sample i. Returns whether one sample or more has none.
template <class Numbers, class Value>
bool fill_values(const Samples& samples, std::uint32_t width, const CancelToken& cancel, const Value& value,
                 std::vector<typename Numbers::Value>& values) {
  values.resize(width * samples.count());
  bool lacks_some = false;
  for (std::size_t i = 0; i < samples.count(); ++i) {
    if (i % attribute_samples_between_checks == 0) cancel.check();
    typename Numbers::Value* const to = values.data() + width * i;
    bool is_held = true;
    for (std::uint32_t k = 0; k < width; ++k) {
      const double number = value(i, k);
      is_held = is_held && Numbers::holds(number);
      to[k] = is_held ? static_cast<typename Numbers::Value>(number) : 0;
    }
    if (is_held) continue;
    lacks_some = true;
    for (std::uint32_t k = 0; k < width; ++k) to[k] = Numbers::none;
  }
  return lacks_some;
}

// Finite numbers alone: others were counted when they were read.
template <class Numbers>
std::uint64_t count_bad(const AttributeSources& sources) {
  std::uint64_t bad = 0;
  for (const ScalarAttribute* const source : sources)
    for (const double number : source->values) bad += std::isfinite(number) && !Numbers::holds(number);
  return bad;
}

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

double number_at(const std::vector<double>& values, std::size_t at) {
  return at < values.size() ? values[at] : no_number;
}

}  // namespace

SampleValues sample_attribute(const PolygonMesh& mesh, const AttributeColumn& column, const Samples& samples,
                              const CancelToken& cancel) {
  AttributeSources sources;
  for (const std::vector<ScalarAttribute>* const list : {&mesh.vertex_attributes, &mesh.asked_attributes})
    if (sources.empty()) sources = sources_of(*list, column);
  const bool of_vertices = !sources.empty();
  for (const std::vector<ScalarAttribute>* const list : {&mesh.face_attributes, &mesh.asked_face_attributes})
    if (sources.empty()) sources = sources_of(*list, column);
  const bool integers =
      std::all_of(sources.begin(), sources.end(), [](const auto* s) { return s->integers; });
  SampleValues made;
  made.is_missing = sources.empty();
  made.is_nearest = column.is_classes() || (integers && column.kind != AttributeKind::linear);
  const auto make = [&](const auto& value) {
    if (column.is_classes()) {
      made.lacks_some = fill_values<ClassNumbers>(samples, column.width, cancel, value, made.classes);
      made.bad_values = count_bad<ClassNumbers>(sources);
    } else if (made.is_nearest) {
      made.lacks_some = fill_values<ExactNumbers>(samples, column.width, cancel, value, made.values);
      made.bad_values = count_bad<ExactNumbers>(sources);
    } else {
      made.lacks_some = fill_values<FloatNumbers>(samples, column.width, cancel, value, made.values);
    }
  };
  if (made.is_missing) {
    make([](std::size_t, std::uint32_t) { return no_number; });
  } else if (!of_vertices) {
    make([&](std::size_t i, std::uint32_t k) { return number_at(sources[k]->values, samples.face[i]); });
  } else if (made.is_nearest) {
    make([&](std::size_t i, std::uint32_t k) {
      return number_at(sources[k]->values, samples.corners[3 * i + nearest_corner(samples, i)]);
    });
  } else {
    make([&](std::size_t i, std::uint32_t k) {
      const std::array<double, 3> weights = corner_weights(samples, i);
      double sum = 0;
      for (std::size_t c = 0; c < 3; ++c)
        sum += weights[c] * number_at(sources[k]->values, samples.corners[3 * i + c]);
      return sum;
    });
  }
  return made;
}

SampleValues sample_coordinates(const PolygonMesh& mesh, const Samples& samples, const CancelToken& cancel) {
  const CornerCoordinates& coordinates = mesh.coordinates;
  PolygonCorners corners(mesh);
  std::array<std::size_t, 3> at{};  // of the sample that is asked for its first number
  const auto value = [&](std::size_t i, std::uint32_t k) {
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
  };
  SampleValues made;
  made.is_missing = coordinates.values.empty();
  made.lacks_some = fill_values<FloatNumbers>(samples, 2, cancel, value, made.values);
  return made;
}

}  // namespace meander
