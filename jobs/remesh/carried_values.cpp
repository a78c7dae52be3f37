#include "jobs/remesh/carried_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/sample/sample_attributes.h"
#include "kernels/sample/sample_colors.h"

namespace meander {

namespace {

// Vertices of a surface as samples at corners of its triangles.
class SurfaceVertices {
 public:
  explicit SurfaceVertices(const Model& model) : model_(model) {}

  // The number of that vertex among `places`.
  std::uint32_t place_of(std::uint32_t vertex) {
    const PreparedMesh& surface = model_.surface;
    if (half_edge_.empty()) {
      half_edge_.assign(surface.vertex_count(), no_index);
      place_.assign(surface.vertex_count(), no_index);
      for (std::size_t h = surface.triangles.size(); h-- > 0;)
        half_edge_[surface.triangles[h]] = static_cast<std::uint32_t>(h);
    }
    std::uint32_t& place = place_[vertex];
    if (place != no_index) return place;
    place = static_cast<std::uint32_t>(places.face.size());
    const std::uint32_t h = half_edge_[vertex], t = h / 3, k = h % 3;
    places.face.push_back(surface.polygon[t]);
    for (std::size_t c = 0; c < 3; ++c)
      places.corners.push_back(model_.file.corners[surface.corner_slot[3 * std::size_t{t} + c]]);
    places.barycentric.insert(places.barycentric.end(), {k == 1 ? 1.f : 0.f, k == 2 ? 1.f : 0.f});
    places.points.insert(places.points.end(), 3, 0.f);
    return place;
  }

  Samples places;

 private:
  const Model& model_;
  std::vector<std::uint32_t> half_edge_, place_;
};

// Numbers of one column: those of samples, then of the other vertices.
template <class Value, class Between>
std::vector<Value> all_values(const RemeshedSurface& mesh, std::size_t width,
                              std::span<const Value> of_samples, std::span<const Value> of_places,
                              SurfaceVertices& surface, const Between& between) {
  std::vector<Value> values(of_samples.begin(), of_samples.end());
  const std::size_t samples = of_samples.size() / width;
  std::size_t cut = 0;
  for (std::size_t e = 0; e < mesh.origin.size(); ++e) {
    if (mesh.origin[e] != no_index) {
      const auto at = of_places.subspan(width * surface.place_of(mesh.origin[e]), width);
      values.insert(values.end(), at.begin(), at.end());
      continue;
    }
    while (cut < mesh.between.size() && mesh.between[cut].vertex < samples + e) ++cut;
    const BetweenVertices& of = mesh.between[cut];
    for (std::size_t k = 0; k < width; ++k) {
      const Value first = of.first_of_surface ? of_places[width * surface.place_of(of.first) + k]
                                              : values[width * std::size_t{of.first} + k];
      const Value second = of.second_of_surface ? of_places[width * surface.place_of(of.second) + k]
                                                : values[width * std::size_t{of.second} + k];
      values.push_back(between(first, second, of.share));
    }
  }
  return values;
}

float between_numbers(float a, float b, double share) {
  return static_cast<float>((1 - share) * double{a} + share * double{b});
}

float of_nearer(float a, float b, double share) { return share <= 0.5 ? a : b; }

std::uint8_t between_bytes(std::uint8_t a, std::uint8_t b, double share) {
  return static_cast<std::uint8_t>(std::lround((1 - share) * a + share * b));
}

bool has_nan(std::span<const float> values) {
  for (const float value : values)
    if (std::isnan(value)) return true;
  return false;
}

// Whether they are whole numbers within int32, all of them.
bool fit_int(std::span<const float> values) {
  constexpr double limit = 0x1p31;
  return std::all_of(values.begin(), values.end(), [](float value) {
    return double{value} >= -limit && double{value} < limit && value == std::floor(value);
  });
}

}  // namespace

std::vector<std::string> attribute_properties(std::span<const AttributeColumn> attributes) {
  std::vector<std::string> names;
  for (const AttributeColumn& column : attributes)
    for (std::uint32_t k = 0; k < column.width; ++k)
      names.push_back(column.width == 1 ? column.name : fmt::format("{}_{}", column.name, k));
  return names;
}

WrittenValues CarriedValues::view() const {
  WrittenValues values{rgb, texcoord, {}};
  for (std::size_t i = 0; i < names.size(); ++i)
    values.attributes.push_back({names[i], attributes[i], integers[i]});
  return values;
}

CarriedValues carried_values(const Model& model, const RemeshedSurface& mesh, const CarriedColumns& columns) {
  CarriedValues made;
  const Samples& samples = model.row.samples;
  SurfaceVertices surface(model);
  for (const std::uint32_t origin : mesh.origin)
    if (origin != no_index) surface.place_of(origin);
  for (const BetweenVertices& of : mesh.between) {
    if (of.first_of_surface) surface.place_of(of.first);
    if (of.second_of_surface) surface.place_of(of.second);
  }
  if (columns.colors) {
    const SampleColors places = sample_colors(model.file, surface.places, model.cancel);
    made.rgb = all_values<std::uint8_t>(mesh, 3, samples.rgb, places.rgb, surface, between_bytes);
    made.lacks_colors = model.row.report.color_fills > 0 || places.fills > 0;
  }
  made.names = attribute_properties(columns.attributes);
  for (std::size_t i = 0; i < columns.attributes.size(); ++i) {
    const AttributeColumn& column = columns.attributes[i];
    const SampleValues places = sample_attribute(model.file, column, surface.places, model.cancel);
    const std::vector<float> values =
        all_values<float>(mesh, column.width, samples.attributes[i], places.values, surface,
                          places.is_nearest ? of_nearer : between_numbers);
    if (has_nan(values)) made.lacks |= std::uint32_t{1} << i;
    for (std::size_t k = 0; k < column.width; ++k) {
      made.integers.push_back(places.is_nearest && fit_int(values));
      std::vector<float>& one = made.attributes.emplace_back();
      for (std::size_t at = k; at < values.size(); at += column.width) one.push_back(values[at]);
    }
  }
  if (columns.texcoord) {
    const SampleValues places = sample_coordinates(model.file, surface.places, model.cancel);
    made.texcoord = all_values<float>(mesh, 2, samples.texcoord, places.values, surface, between_numbers);
    if (has_nan(made.texcoord)) made.lacks |= std::uint32_t{1} << columns.attributes.size();
  }
  return made;
}

std::string lacking_text(const CarriedValues& values, const CarriedColumns& columns) {
  std::string text;
  const auto add = [&](const std::string& word) { text += (text.empty() ? "" : ",") + word; };
  if (values.lacks_colors) add("colors");
  for (std::size_t i = 0; i < columns.attributes.size(); ++i)
    if ((values.lacks >> i & 1) != 0) add(columns.attributes[i].name);
  if ((values.lacks >> columns.attributes.size() & 1) != 0) add("texcoord");
  return text;
}

}  // namespace meander
