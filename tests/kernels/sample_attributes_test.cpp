// Attributes and texture coordinates at samples: closed forms, names, what is missing, and seams.
#include "kernels/sample/sample_attributes.h"

#include <cmath>
#include <limits>

#include "kernels/model/model_sampler.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr double not_there = std::numeric_limits<double>::quiet_NaN();

Row sampled_row(const PolygonMesh& mesh, SampleParameters parameters = parameters_for("auto")) {
  parameters.samples = 500;
  Row row = ModelSampler(parameters).sample(mesh);
  REQUIRE(row.report.status == Status::ok);
  return row;
}

double at_point(const Row& row, std::size_t i, std::size_t axis) {
  return row.report.loc[axis] + row.report.scale * static_cast<double>(row.samples.points[3 * i + axis]);
}

// 2 x - 3 y + z + 5 at every vertex.
std::vector<double> linear_values(const PolygonMesh& mesh) {
  std::vector<double> values;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    values.push_back(2 * mesh.x[v] - 3 * mesh.y[v] + mesh.z[v] + 5);
  return values;
}

std::vector<double> face_numbers(const PolygonMesh& mesh) {
  std::vector<double> values;
  for (std::size_t f = 0; f < mesh.polygon_count(); ++f) values.push_back(static_cast<double>(f));
  return values;
}

}  // namespace

TEST_CASE("sample_attribute: a linear function of the position is reproduced at every sample") {
  for (PolygonMesh mesh : {cube(), icosphere(2), torus(20, 9)}) {
    mesh.vertex_attributes = {{"f", linear_values(mesh)}};
    for (const char* method : {"auto", "conformal", "direct", "anisotropic"}) {
      const Row row = sampled_row(mesh, parameters_for(method));
      const SampleValues made = sample_attribute(mesh, {"f", 1}, row.samples);
      CHECK_FALSE(made.lacks_some);
      REQUIRE(made.values.size() == 500);
      for (std::size_t i = 0; i < 500; ++i) {
        const double expected = 2 * at_point(row, i, 0) - 3 * at_point(row, i, 1) + at_point(row, i, 2) + 5;
        CHECK(std::abs(made.values[i] - expected) < 1e-5);
      }
    }
  }
}

TEST_CASE("sample_attribute: a face attribute is that of the face, and vertices take precedence") {
  PolygonMesh mesh = cube();
  mesh.face_attributes = {{"number", face_numbers(mesh)}, {"both", face_numbers(mesh)}};
  mesh.vertex_attributes = {{"both", std::vector<double>(mesh.vertex_count(), -7)}};
  const Row row = sampled_row(mesh);
  const SampleValues number = sample_attribute(mesh, {"number", 1}, row.samples);
  const SampleValues both = sample_attribute(mesh, {"both", 1}, row.samples);
  for (std::size_t i = 0; i < 500; ++i) {
    CHECK(number.values[i] == static_cast<float>(row.samples.face[i]));
    CHECK(both.values[i] == -7);
  }
  // What was asked for by name stands with the vertices.
  mesh.vertex_attributes.clear();
  mesh.asked_attributes = {{"both", std::vector<double>(mesh.vertex_count(), 3)}};
  CHECK(sample_attribute(mesh, {"both", 1}, row.samples).values[0] == 3);
}

TEST_CASE("sample_attribute: a vector consists of attributes with numbers or letters after its name") {
  PolygonMesh mesh = cube();
  const auto constant = [&](double value) { return std::vector<double>(mesh.vertex_count(), value); };
  mesh.vertex_attributes = {{"n_2", constant(12)}, {"n_0", constant(10)}, {"n_1", constant(11)},
                            {"d_x", constant(1)},  {"d_y", constant(2)},  {"d_z", constant(3)},
                            {"d_w", constant(4)},  {"n_x", constant(99)}, {"half_0", constant(1)}};
  mesh.face_attributes = {{"half_1", face_numbers(mesh)}};
  const Row row = sampled_row(mesh);
  const auto first = [&](const char* name, std::uint32_t width) {
    const SampleValues made = sample_attribute(mesh, {name, width}, row.samples);
    CHECK(made.values.size() == std::size_t{500} * width);
    return std::vector<float>(made.values.begin(), made.values.begin() + width);
  };
  CHECK(first("n", 3) == std::vector<float>{10, 11, 12});
  CHECK(first("n", 2) == std::vector<float>{10, 11});
  CHECK(first("d", 4) == std::vector<float>{1, 2, 3, 4});
  // All numbers are of vertices, or all of faces; nothing is one number wide and a vector.
  for (const AttributeColumn& column :
       std::vector<AttributeColumn>{{"n", 4}, {"half", 2}, {"n", 1}, {"", 2}}) {
    const SampleValues made = sample_attribute(mesh, column, row.samples);
    CHECK(made.lacks_some);
    for (const float value : made.values) CHECK(std::isnan(value));
  }
}

TEST_CASE(
    "sample_attribute: missing, non-finite or too large values are NaN in all components of the sample") {
  PolygonMesh mesh = cube();
  std::vector<double> holed = face_numbers(mesh), huge = holed, infinite = holed, second = holed;
  holed[2] = not_there;
  huge[3] = 1e300;
  infinite[4] = -std::numeric_limits<double>::infinity();
  second[1] = not_there;
  std::vector<double> shorter = holed;
  shorter.resize(2);
  mesh.face_attributes = {{"holed", holed},     {"huge", huge},    {"infinite", infinite},
                          {"shorter", shorter}, {"v_0", infinite}, {"v_1", second}};
  const Row row = sampled_row(mesh);
  const auto check = [&](const AttributeColumn& column, auto lost) {
    const SampleValues made = sample_attribute(mesh, column, row.samples);
    CHECK(made.lacks_some);
    for (std::size_t i = 0; i < 500; ++i)
      for (std::size_t k = 0; k < column.width; ++k) {
        const float value = made.values[column.width * i + k];
        INFO(column.name << " " << row.samples.face[i] << " " << value);
        CHECK(std::isnan(value) == lost(row.samples.face[i]));
        CHECK((std::isnan(value) || value == static_cast<float>(row.samples.face[i])));
      }
  };
  check({"holed", 1}, [](std::uint32_t f) { return f == 2; });
  check({"huge", 1}, [](std::uint32_t f) { return f == 3; });
  check({"infinite", 1}, [](std::uint32_t f) { return f == 4; });
  check({"shorter", 1}, [](std::uint32_t f) { return f >= 2; });
  check({"v", 2}, [](std::uint32_t f) { return f == 1 || f == 4; });
  check({"absent", 3}, [](std::uint32_t) { return true; });
}

TEST_CASE("sample_attribute: integers at vertices are those of the corner with the largest weight") {
  PolygonMesh mesh = icosphere(1);
  std::vector<double> numbers;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) numbers.push_back(static_cast<double>(v * v));
  mesh.vertex_attributes = {{"label", numbers, true}, {"f", numbers},   {"v_0", numbers, true},
                            {"v_1", numbers, true},   {"w_0", numbers}, {"w_1", numbers, true}};
  const Row row = sampled_row(mesh);
  const SampleValues plain = sample_attribute(mesh, {"label", 1}, row.samples),
                     classes = sample_attribute(mesh, {"label", 1, AttributeKind::classes}, row.samples),
                     linear = sample_attribute(mesh, {"label", 1, AttributeKind::linear}, row.samples),
                     floats = sample_attribute(mesh, {"f", 1}, row.samples),
                     rounded = sample_attribute(mesh, {"f", 1, AttributeKind::classes}, row.samples),
                     pair = sample_attribute(mesh, {"v", 2, AttributeKind::classes}, row.samples),
                     mixed = sample_attribute(mesh, {"w", 2}, row.samples);
  CHECK((plain.is_nearest && classes.is_nearest && !linear.is_nearest && !floats.is_nearest));
  CHECK((plain.classes.empty() && classes.values.empty() && linear.values == floats.values));
  CHECK(rounded.classes == classes.classes);
  for (std::size_t i = 0; i < 500; ++i) {
    const double b1 = row.samples.barycentric[2 * i], b2 = row.samples.barycentric[2 * i + 1],
                 b0 = 1 - b1 - b2;
    const std::size_t corner = b0 >= b1 && b0 >= b2 ? 0 : b1 >= b2 ? 1 : 2;
    const std::uint32_t v = row.samples.corners[3 * i + corner];
    CHECK(classes.classes[i] == static_cast<std::int32_t>(v * v));
    CHECK(plain.values[i] == static_cast<float>(v * v));
    CHECK(pair.classes[2 * i] == classes.classes[i]);
    CHECK(pair.classes[2 * i + 1] == classes.classes[i]);
    CHECK(mixed.values[2 * i] == floats.values[i]);
  }
}

TEST_CASE("sample_attribute: among corners with equal weights the first one's class is taken") {
  PolygonMesh mesh = polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}});
  mesh.vertex_attributes = {{"label", {7, 8, 9}, true}};
  Samples samples;
  samples.points.resize(12);
  samples.face = {0, 0, 0, 0};
  samples.corners = {0, 1, 2, 0, 1, 2, 0, 1, 2, 2, 0, 1};
  samples.barycentric = {.5f, .5f, .25f, .5f, .5f, 0, .5f, .5f};
  const SampleValues made = sample_attribute(mesh, {"label", 1, AttributeKind::classes}, samples);
  CHECK(made.classes == std::vector<std::int32_t>{8, 9, 7, 7});
}

TEST_CASE("sample_attribute: values that no class can hold are missing, and counted") {
  PolygonMesh mesh = cube();
  const double largest = 2147483647;
  mesh.face_attributes = {{"n", {largest, largest + 1, -largest - 1, -largest - 2, 0.5, not_there}, true},
                          {"exact", {16777216, 16777217, -16777217, 3, 1e300, 1.5}, true},
                          {"pair_0", {1, 2, 3, 4, 5, 6}, true},
                          {"pair_1", {1, 2, 3, 4, 5, 1e10}, true},
                          {"short", {1, 2}, true}};
  const Row row = sampled_row(mesh);
  const SampleValues n = sample_attribute(mesh, {"n", 1, AttributeKind::classes}, row.samples),
                     exact = sample_attribute(mesh, {"exact", 1}, row.samples),
                     pair = sample_attribute(mesh, {"pair", 2, AttributeKind::classes}, row.samples),
                     cut = sample_attribute(mesh, {"short", 1, AttributeKind::classes}, row.samples),
                     none = sample_attribute(mesh, {"none", 2, AttributeKind::classes}, row.samples);
  CHECK((n.lacks_some && exact.lacks_some && pair.lacks_some && cut.lacks_some && none.lacks_some));
  CHECK((!n.is_missing && !cut.is_missing && none.is_missing));
  CHECK((n.bad_values == 3 && exact.bad_values == 4 && pair.bad_values == 1 && cut.bad_values == 0));
  const std::vector<std::int32_t> expected = {2147483647, -1, -2147483647 - 1, -1, -1, -1};
  for (std::size_t i = 0; i < 500; ++i) {
    const std::uint32_t face = row.samples.face[i];
    CHECK(n.classes[i] == expected[face]);
    CHECK(std::isnan(exact.values[i]) == (face == 1 || face == 2 || face >= 4));
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(pair.classes[2 * i + k] == (face == 5 ? -1 : static_cast<std::int32_t>(face) + 1));
    CHECK(cut.classes[i] == (face < 2 ? static_cast<std::int32_t>(face) + 1 : -1));
    CHECK(none.classes[2 * i] == -1);
  }
}

TEST_CASE("sample_coordinates: at a seam each polygon has its own coordinates") {
  // Two quads side by side over x in [0, 2]; the right one begins again at u = 0 and is laid upside down.
  PolygonMesh mesh =
      polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0}, {{0, 1, 4, 3}, {1, 2, 5, 4}});
  mesh.coordinates.values = {0, 0, 1, 0, 1, 1, 0, 1};
  mesh.coordinates.corner = {0, 1, 2, 3, 3, 2, 1, 0};
  const Row row = sampled_row(mesh);
  const SampleValues made = sample_coordinates(mesh, row.samples);
  CHECK_FALSE(made.lacks_some);
  REQUIRE(made.values.size() == 1000);
  for (std::size_t i = 0; i < 500; ++i) {
    const double x = at_point(row, i, 0), y = at_point(row, i, 1);
    const bool right = row.samples.face[i] == 1;
    CHECK(std::abs(made.values[2 * i] - (right ? x - 1 : x)) < 1e-6);
    CHECK(std::abs(made.values[2 * i + 1] - (right ? 1 - y : y)) < 1e-6);
  }
  mesh.coordinates.corner[6] = no_index;  // vertex 5, of the right one
  const SampleValues holed = sample_coordinates(mesh, row.samples);
  CHECK(holed.lacks_some);
  for (std::size_t i = 0; i < 500; ++i) {
    if (row.samples.face[i] == 0) CHECK(holed.values[2 * i] == made.values[2 * i]);
    bool touches = false;
    for (std::size_t k = 0; k < 3; ++k) touches = touches || row.samples.corners[3 * i + k] == 5;
    CHECK(std::isnan(holed.values[2 * i]) == touches);
    CHECK(std::isnan(holed.values[2 * i + 1]) == touches);
  }
  mesh.coordinates = {};
  CHECK(sample_coordinates(mesh, row.samples).lacks_some);
}

TEST_CASE("sample_coordinates: a polygon with many corners is triangulated") {
  constexpr std::uint32_t sides = 200;
  std::vector<double> xyz;
  std::vector<std::uint32_t> polygon;
  PolygonMesh mesh;
  for (std::uint32_t k = 0; k < sides; ++k) {
    const double angle = 2 * 3.14159265358979 * k / sides;
    xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), 0});
    polygon.push_back(k);
  }
  mesh = polygon_mesh(xyz, {polygon});
  for (std::uint32_t k = 0; k < sides; ++k) {
    mesh.coordinates.values.push_back(static_cast<float>(xyz[3 * k]));
    mesh.coordinates.values.push_back(static_cast<float>(xyz[3 * k + 1]));
    mesh.coordinates.corner.push_back(k);
  }
  const Row row = sampled_row(mesh);
  const SampleValues made = sample_coordinates(mesh, row.samples);
  for (std::size_t i = 0; i < 500; ++i)
    for (std::size_t k = 0; k < 2; ++k) CHECK(std::abs(made.values[2 * i + k] - at_point(row, i, k)) < 1e-6);
}

TEST_CASE(
    "Sampler: attributes and texture coordinates are columns of the row, with a bit for missing values") {
  PolygonMesh mesh = cube();
  mesh.vertex_attributes = {{"f", linear_values(mesh)}};
  SampleParameters parameters = parameters_for("auto");
  parameters.attributes = {{"absent", 2}, {"f", 1}};
  parameters.columns[&Samples::texcoord] = true;
  const Row row = sampled_row(mesh, parameters);
  REQUIRE(row.samples.attributes.size() == 2);
  CHECK(row.samples.attributes[0].size() == 1000);
  CHECK(row.samples.attributes[1] == sample_attribute(mesh, {"f", 1}, row.samples).values);
  CHECK(row.samples.texcoord.size() == 1000);
  CHECK(row.report.lacks == 0b101);
  CHECK(row.report.missing == 0b101);
  CHECK(row.samples.points == sampled_row(mesh).samples.points);
}

TEST_CASE("Sampler: class columns stand next to numeric ones, and invalid values are counted") {
  PolygonMesh mesh = cube();
  mesh.face_attributes = {{"a", {1, 2, 3, 4, 5, 1e12}, true}, {"c", face_numbers(mesh), true}};
  SampleParameters parameters = parameters_for("auto");
  parameters.attributes = {{"a", 1, AttributeKind::classes}, {"b", 1}, {"c", 1, AttributeKind::classes}};
  const Row row = sampled_row(mesh, parameters);
  REQUIRE(row.samples.classes.size() == 3);
  REQUIRE(row.samples.attributes.size() == 2);
  CHECK((row.samples.classes[1].empty() && row.samples.attributes[0].empty()));
  CHECK(row.samples.attributes[1].size() == 500);
  for (std::size_t i = 0; i < 500; ++i)
    CHECK(row.samples.classes[2][i] == static_cast<std::int32_t>(row.samples.face[i]));
  CHECK(row.report.lacks == 0b011);
  CHECK(row.report.missing == 0b010);
  CHECK(row.report.repairs[Repair::bad_attributes] == 1);
}

TEST_CASE("validate: allows at most 32 columns, of widths from 1 to 4") {
  SampleParameters parameters;
  for (int i = 0; i < 32; ++i) parameters.attributes.push_back({"a" + std::to_string(i), 1});
  CHECK(validate(parameters).empty());
  parameters.columns[&Samples::texcoord] = true;
  CHECK(validate(parameters).size() == 1);
  parameters.attributes.resize(2);
  parameters.attributes[0].width = 5;
  parameters.attributes[1].width = 0;
  CHECK(validate(parameters).size() == 2);
}
