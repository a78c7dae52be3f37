#include "jobs/python/array_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "io/digest.h"
#include "jobs/python/sample_options.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/count_limit.h"
#include "kernels/model/model_sampler.h"

namespace meander {

namespace {

struct Corners {
  std::vector<std::uint32_t> number;  // those out of range: no_index
  std::size_t faces = 0, width = 3;
};

// `first_bad`: position of the first corner that names no vertex, and its number as text.
template <class Number>
void read_corners(const meander_arrays& arrays, Corners& corners, std::size_t& first_bad,
                  std::string& bad_number) {
  const std::span<const Number> numbers(static_cast<const Number*>(arrays.faces),
                                        corners.faces * corners.width);
  corners.number.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    bool known = static_cast<std::uint64_t>(numbers[i]) < arrays.vertex_count;
    if constexpr (std::is_signed_v<Number>) known = known && numbers[i] >= 0;
    corners.number[i] = known ? static_cast<std::uint32_t>(numbers[i]) : no_index;
    if (!known && first_bad == numbers.size()) {
      first_bad = i;
      bad_number = std::to_string(numbers[i]);
    }
  }
}

Corners corners_of(const meander_arrays& arrays) {
  Corners corners;
  if (arrays.face_count == 0) return corners;
  if (arrays.width < 3 || (arrays.corner_bytes != 4 && arrays.corner_bytes != 8))
    throw std::invalid_argument("faces have three corners or more, numbers of 4 or 8 bytes");
  check_count(arrays.face_count, "faces");
  check_count(arrays.width, "corners of a face");
  corners.faces = arrays.face_count;
  corners.width = arrays.width;
  check_count(corners.faces * corners.width, "corners");
  std::size_t bad = corners.faces * corners.width;
  std::string number;
  if (arrays.corner_bytes == 8 && arrays.corners_are_signed == 0)
    read_corners<std::uint64_t>(arrays, corners, bad, number);
  else if (arrays.corner_bytes == 8)
    read_corners<std::int64_t>(arrays, corners, bad, number);
  else if (arrays.corners_are_signed == 0)
    read_corners<std::uint32_t>(arrays, corners, bad, number);
  else
    read_corners<std::int32_t>(arrays, corners, bad, number);
  if (arrays.check != 0 && bad < corners.number.size())
    throw std::invalid_argument(fmt::format("faces[{}, {}] is {}: there are {} vertices, numbered from 0",
                                            bad / corners.width, bad % corners.width, number,
                                            arrays.vertex_count));
  return corners;
}

// The first row of three that is not finite; the number of rows where all are.
std::size_t first_infinite(std::span<const double> triples) {
  for (std::size_t i = 0; i < triples.size(); ++i)
    if (!std::isfinite(triples[i])) return i / 3;
  return triples.size() / 3;
}

// The digest of three counts, the positions as doubles and the corners: equal for equal meshes, whatever type
// and layout their arrays have.
Content content_of(std::span<const double> positions, const Corners& corners) {
  const std::array<std::uint64_t, 3> counts = {positions.size() / 3, corners.faces, corners.width};
  std::vector<std::byte> bytes;
  bytes.reserve(sizeof counts + positions.size_bytes() + std::span(corners.number).size_bytes());
  const auto append = [&bytes](std::span<const std::byte> part) {
    bytes.insert(bytes.end(), part.begin(), part.end());
  };
  append(std::as_bytes(std::span(counts)));
  append(std::as_bytes(positions));
  append(std::as_bytes(std::span(corners.number)));
  return sha256(bytes);
}

std::span<const float> color_values(const meander_arrays& arrays) {
  const std::uint64_t count = arrays.colors_of_faces != 0 ? arrays.face_count : arrays.vertex_count;
  const std::span<const float> numbers(arrays.colors, 3 * count);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] < 0 || numbers[i] > 1)
      throw std::invalid_argument(
          fmt::format("colors[{}, {}] is {}: colors are real numbers from 0 to 1, or of the type uint8",
                      i / 3, i % 3, numbers[i]));
  return numbers;
}

// One attribute for each of its numbers, as columns of attributes are made of them.
void add_attribute(const meander_attribute& given, std::uint64_t count, PolygonMesh& mesh) {
  if (given.width < 1 || given.width > attribute_suffixes[0].size())
    throw std::invalid_argument(fmt::format("the attribute `{}` has {} numbers of each, where 1 to {} may be",
                                            given.name, given.width, attribute_suffixes[0].size()));
  for (std::uint64_t k = 0; k < given.width; ++k) {
    ScalarAttribute attribute{
        given.width == 1 ? given.name : given.name + std::string(attribute_suffixes[0][k]),
        std::vector<double>(count), given.classes != 0};
    for (std::uint64_t i = 0; i < count; ++i) attribute.values[i] = given.values[given.width * i + k];
    (given.of_faces != 0 ? mesh.asked_face_attributes : mesh.asked_attributes)
        .push_back(std::move(attribute));
  }
}

}  // namespace

void set_density(PolygonMesh& mesh, std::span<const double> values, bool of_faces) {
  const std::size_t count = of_faces ? mesh.polygon_count() : mesh.vertex_count();
  if (values.size() != count)
    throw std::invalid_argument(fmt::format("density has {} values for {} {}", values.size(), count,
                                            of_faces ? "faces" : "vertices"));
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(values[i] >= 0) || std::isinf(values[i]))
      throw std::invalid_argument(
          fmt::format("density[{}] is {}: densities are finite and not negative", i, values[i]));
  (of_faces ? mesh.face_attributes : mesh.vertex_attributes)
      .push_back({density_attribute, {values.begin(), values.end()}});
}

void require_finite(std::span<const double> triples, const char* name) {
  const std::size_t bad = first_infinite(triples);
  if (bad < triples.size() / 3)
    throw std::invalid_argument(fmt::format("{}[{}] is ({}, {}, {}): not finite", name, bad, triples[3 * bad],
                                            triples[3 * bad + 1], triples[3 * bad + 2]));
}

ContentMesh mesh_of_arrays(const meander_arrays& arrays) {
  const std::size_t count = arrays.vertex_count;
  check_count(count, "vertices");
  const std::span<const double> positions(arrays.vertices, 3 * count);
  if (arrays.check != 0) require_finite(positions, "vertices");
  const Corners corners = corners_of(arrays);
  Mesh mesh{positions, corners.number, static_cast<std::uint32_t>(corners.width)};
  std::vector<float> normals;
  if (arrays.normals != nullptr)
    for (const double number : std::span(arrays.normals, 3 * count))
      normals.push_back(static_cast<float>(number));
  mesh.normals = normals;
  if (arrays.colors != nullptr)
    (arrays.colors_of_faces != 0 ? mesh.face_colors : mesh.vertex_colors) = color_values(arrays);
  ContentMesh result;
  if (arrays.content != nullptr)
    std::copy_n(arrays.content, result.content.size(), result.content.begin());
  else
    result.content = content_of(positions, corners);
  result.mesh = polygon_mesh_of(mesh);
  if (arrays.density != nullptr) {
    const bool of_faces = arrays.density_of_faces != 0;
    set_density(result.mesh, {arrays.density, of_faces ? arrays.face_count : arrays.vertex_count}, of_faces);
  }
  for (const meander_attribute& given : std::span(arrays.attributes, arrays.attribute_count))
    add_attribute(given, given.of_faces != 0 ? arrays.face_count : arrays.vertex_count, result.mesh);
  return result;
}

}  // namespace meander
