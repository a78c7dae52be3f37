#include "jobs/python/array_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "io/digest.h"
#include "jobs/python/sample_options.h"
#include "kernels/mesh/count_limit.h"

namespace py = pybind11;

namespace meander {

namespace {

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis)
    text += fmt::format("{}{}", axis > 0 ? ", " : "", array.shape(axis));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

py::array any_array(const py::object& object, const char* name) {
  if (object.is_none()) throw py::type_error(fmt::format("{} is None: an array is needed", name));
  py::array array = py::array::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(fmt::format("{} is no array of numbers", name));
  }
  return array;
}

// Of shape (n, 3) where `columns` is 3, (n,) where it is 0.
using Reals = py::array_t<double, py::array::c_style | py::array::forcecast>;
Reals real_array(const py::object& object, const char* name, int columns) {
  const py::array array = any_array(object, name);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw py::type_error(
        fmt::format("{} must be real numbers, not {}", name, std::string(py::str(array.dtype()))));
  const bool fits = columns > 0 ? array.ndim() == 2 && array.shape(1) == columns : array.ndim() == 1;
  if (!fits)
    throw py::value_error(fmt::format("{} must have the shape {}, not {}", name,
                                      columns > 0 ? "(n, 3)" : "(n,)", shape_text(array)));
  return Reals::ensure(array);
}

struct Corners {
  std::vector<std::uint32_t> number;  // those out of range: no_index
  std::size_t faces = 0, width = 3;
};

// `first_bad`: position of the first corner that names no vertex, and its number as text.
template <class Number>
void read_corners(const py::array& array, std::size_t vertices, Corners& corners, std::size_t& first_bad,
                  std::string& bad_number) {
  const auto exact = py::array_t<Number, py::array::c_style | py::array::forcecast>::ensure(array);
  const std::span<const Number> numbers(exact.data(), corners.faces * corners.width);
  const py::gil_scoped_release released;
  corners.number.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    bool known = static_cast<std::uint64_t>(numbers[i]) < vertices;
    if constexpr (std::is_signed_v<Number>) known = known && numbers[i] >= 0;
    corners.number[i] = known ? static_cast<std::uint32_t>(numbers[i]) : no_index;
    if (!known && first_bad == numbers.size()) {
      first_bad = i;
      bad_number = std::to_string(numbers[i]);
    }
  }
}

Corners corners_of(const py::object& object, std::size_t vertices, bool check) {
  const py::array array = any_array(object, "faces");
  const char kind = array.dtype().kind();
  const bool no_face = array.size() == 0;  // [] is an array of real numbers
  if (kind != 'i' && kind != 'u' && !(no_face && kind == 'f'))
    throw py::type_error(fmt::format("faces must be whole numbers (of vertices), not {}",
                                     std::string(py::str(array.dtype()))));
  Corners corners;
  if (no_face && array.ndim() <= 2) return corners;
  if (array.ndim() != 2 || array.shape(1) < 3)
    throw py::value_error(
        fmt::format("faces must have the shape (F, k) with k >= 3, not {}", shape_text(array)));
  corners.faces = static_cast<std::size_t>(array.shape(0));
  corners.width = static_cast<std::size_t>(array.shape(1));
  check_count(corners.faces * corners.width, "corners");
  std::size_t bad = corners.faces * corners.width;
  std::string number;
  if (kind == 'u' && array.itemsize() == 8)
    read_corners<std::uint64_t>(array, vertices, corners, bad, number);
  else if (array.itemsize() == 8)
    read_corners<std::int64_t>(array, vertices, corners, bad, number);
  else if (kind == 'u')
    read_corners<std::uint32_t>(array, vertices, corners, bad, number);
  else
    read_corners<std::int32_t>(array, vertices, corners, bad, number);
  if (check && bad < corners.number.size())
    throw py::value_error(fmt::format("faces[{}, {}] is {}: there are {} vertices, numbered from 0",
                                      bad / corners.width, bad % corners.width, number, vertices));
  return corners;
}

// The first row of three that is not finite; the number of rows where all are.
std::size_t first_infinite(std::span<const double> triples) {
  for (std::size_t i = 0; i < triples.size(); ++i)
    if (!std::isfinite(triples[i])) return i / 3;
  return triples.size() / 3;
}

void require_finite(std::span<const double> triples, const char* name) {
  const std::size_t bad = first_infinite(triples);
  if (bad < triples.size() / 3)
    throw py::value_error(fmt::format("{}[{}] is ({}, {}, {}): not finite", name, bad, triples[3 * bad],
                                      triples[3 * bad + 1], triples[3 * bad + 2]));
}

// The digest of three counts, the positions as doubles and the corners: equal for equal meshes, whatever type
// and layout their arrays have.
std::array<std::uint8_t, 32> content_of(std::span<const double> positions, const Corners& corners) {
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

std::vector<double> density_values(const MeshArrays& arrays, std::size_t vertices, std::size_t faces) {
  const Reals values = real_array(arrays.density, "density", 0);
  const std::size_t wanted = arrays.density_of_faces ? faces : vertices;
  const auto count = static_cast<std::size_t>(values.size());
  if (count != wanted)
    throw py::value_error(fmt::format("density has {} values for {} {}", count, wanted,
                                      arrays.density_of_faces ? "faces" : "vertices"));
  const std::span<const double> numbers(values.data(), count);
  for (std::size_t i = 0; i < count; ++i)
    if (!(numbers[i] >= 0) || std::isinf(numbers[i]))
      throw py::value_error(
          fmt::format("density[{}] is {}: densities are finite and not negative", i, numbers[i]));
  return {numbers.begin(), numbers.end()};
}

}  // namespace

ContentMesh mesh_of_arrays(const MeshArrays& arrays) {
  const Reals vertices = real_array(arrays.vertices, "vertices", 3);
  const auto count = static_cast<std::size_t>(vertices.shape(0));
  check_count(count, "vertices");
  const std::span<const double> positions(vertices.data(), 3 * count);
  if (arrays.check) require_finite(positions, "vertices");
  Corners corners = corners_of(arrays.faces, count, arrays.check);
  ContentMesh result;
  PolygonMesh& mesh = result.mesh;
  if (!arrays.normals.is_none()) {
    const Reals normals = real_array(arrays.normals, "normals", 3);
    if (normals.shape(0) != vertices.shape(0))
      throw py::value_error(
          fmt::format("there are {} normals of {} vertices", normals.shape(0), vertices.shape(0)));
    for (py::ssize_t i = 0; i < normals.size(); ++i)
      mesh.normals.push_back(static_cast<float>(normals.data()[i]));
  }
  if (!arrays.density.is_none())
    (arrays.density_of_faces ? mesh.face_attributes : mesh.vertex_attributes)
        .push_back({density_attribute, density_values(arrays, count, corners.faces)});
  if (!arrays.content.is_none()) result.content = content_of_bytes(arrays.content);
  const bool digest = arrays.content.is_none();
  const py::gil_scoped_release released;
  if (digest) result.content = content_of(positions, corners);
  mesh.x.resize(count);
  mesh.y.resize(count);
  mesh.z.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    mesh.x[v] = positions[3 * v];
    mesh.y[v] = positions[3 * v + 1];
    mesh.z[v] = positions[3 * v + 2];
  }
  if (corners.faces > 0) mesh.polygon_begin.resize(corners.faces + 1);
  for (std::size_t f = 0; f < mesh.polygon_begin.size(); ++f)
    mesh.polygon_begin[f] = static_cast<std::uint32_t>(f * corners.width);
  mesh.corners = std::move(corners.number);
  return result;
}

std::array<std::uint8_t, 32> content_of_bytes(const py::object& content) {
  const auto bytes = py::cast<std::string>(content);
  std::array<std::uint8_t, 32> digest{};
  if (bytes.size() != digest.size())
    throw py::value_error(fmt::format("content must have 32 bytes (a SHA-256), not {}", bytes.size()));
  std::copy(bytes.begin(), bytes.end(), digest.begin());
  return digest;
}

std::vector<double> finite_triples(const py::object& array, const char* name) {
  const Reals values = real_array(array, name, 3);
  std::vector<double> triples(values.data(), values.data() + values.size());
  require_finite(triples, name);
  return triples;
}

}  // namespace meander
