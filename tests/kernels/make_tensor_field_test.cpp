#include "kernels/tensor/make_tensor_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "io/mesh/mesh_reader.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/tensor/vertex_tensors.h"
#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

using Six = std::array<double, 6>;

// s1 along direction (unit), s2 across, `normal` (unit) with `out` along it.
Six tensor_along(Vector3 direction, Vector3 normal, double s1, double s2, double out) {
  const Vector3 a = direction, b = cross(normal, direction), n = normal;
  return {
      s1 * a.x * a.x + s2 * b.x * b.x + out * n.x * n.x, s1 * a.x * a.y + s2 * b.x * b.y + out * n.x * n.y,
      s1 * a.x * a.z + s2 * b.x * b.z + out * n.x * n.z, s1 * a.y * a.y + s2 * b.y * b.y + out * n.y * n.y,
      s1 * a.y * a.z + s2 * b.y * b.z + out * n.y * n.z, s1 * a.z * a.z + s2 * b.z * b.z + out * n.z * n.z};
}

constexpr std::array<const char*, 6> six_names = {"_xx", "_xy", "_xz", "_yy", "_yz", "_zz"};
constexpr std::array<const char*, 3> three_names = {"_x", "_y", "_z"};

template <class Value>
void add_six(std::vector<ScalarAttribute>& attributes, const std::string& name, std::size_t count,
             const Value& value) {
  const std::size_t first = attributes.size();
  for (const char* suffix : six_names) attributes.push_back({name + suffix, std::vector<double>(count)});
  for (std::size_t i = 0; i < count; ++i) {
    const Six row = value(i);
    for (std::size_t k = 0; k < 6; ++k) attributes[first + k].values[i] = row[k];
  }
}

template <class Value>
void add_vector(std::vector<ScalarAttribute>& attributes, const std::string& name, std::size_t count,
                const Value& value) {
  const std::size_t first = attributes.size();
  for (const char* suffix : three_names) attributes.push_back({name + suffix, std::vector<double>(count)});
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 v = value(i);
    attributes[first].values[i] = v.x;
    attributes[first + 1].values[i] = v.y;
    attributes[first + 2].values[i] = v.z;
  }
}

TensorParameters of_kind(TensorKind kind, std::string attribute = {}) {
  TensorParameters parameters;
  parameters.kind = kind;
  parameters.attribute = std::move(attribute);
  return parameters;
}

// Every corner: the ratio, and e1 within `margin` of the direction (as a line).
void check_direction(const PreparedMesh& mesh, const TensorField& field, Vector3 direction, double ratio,
                     double margin = 1e-9) {
  double worst_ratio = 0, worst_direction = 0;
  for (std::uint32_t h = 0; h < field.corner.size(); ++h) {
    const TensorAxes axes = spacings_of(field.corner[h]);
    const TangentFrame frame = triangle_frame(mesh, h / 3);
    worst_ratio = std::max(worst_ratio, std::abs(axes.first / axes.second / ratio - 1));
    worst_direction = std::max(worst_direction, norm(cross(direction, axes.x * frame.x + axes.y * frame.y)));
  }
  CHECK(worst_ratio < margin);
  CHECK(worst_direction < margin);
}

double worst_difference(const TensorField& a, const TensorField& b) {
  double worst = 0;
  for (std::size_t h = 0; h < a.corner.size(); ++h) {
    const TangentTensor d = a.corner[h] + -1.0 * b.corner[h];
    worst = std::max({worst, std::abs(d.xx), std::abs(d.xy), std::abs(d.yy)});
  }
  return worst;
}

}  // namespace

TEST_CASE("make_tensor_field: six numbers or a vector, at vertices or faces, from attributes or a table") {
  // A turned plane: the planes of the tensors are not those of the axes.
  PolygonMesh file = moved(grid_plane(6, 4), 20, 3, 2, 1);
  const PolygonMesh axes = moved(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {}), 1, 0, 0, 0);
  const auto axis = [&](std::size_t k) {
    return Vector3{axes.x[k] - axes.x[0], axes.y[k] - axes.y[0], axes.z[k] - axes.z[0]};
  };
  const Vector3 direction = std::cos(0.4) * axis(1) + std::sin(0.4) * axis(2),
                normal = cross(axis(1), axis(2));
  const std::size_t vertices = file.vertex_count(), faces = file.polygon_count();
  // Units do not matter, nor what lies along the normal.
  const auto spacing = [&](std::size_t i) {
    return tensor_along(direction, normal, 6e5, 2e5, 1e5 * static_cast<double>(i));
  };
  const auto metric = [&](std::size_t) { return tensor_along(direction, normal, 1.0 / 36, 1.0 / 4, 0); };
  const auto vector = [&](std::size_t i) { return (i % 2 == 0 ? 3.0 : -3.0) * direction; };
  add_six(file.vertex_attributes, "s", vertices, spacing);
  add_six(file.vertex_attributes, "g", vertices, metric);
  add_vector(file.vertex_attributes, "v", vertices, vector);
  add_six(file.face_attributes, "s", faces, spacing);
  add_vector(file.face_attributes, "v", faces, vector);
  const PreparedMesh mesh = prepare_mesh(file);

  TensorParameters constant = of_kind(TensorKind::constant);
  constant.constant = tensor_along(direction, normal, 6, 2, 1);
  TensorParameters g = of_kind(TensorKind::vertex_attribute, "g");
  g.form = TensorForm::metric;
  TensorParameters rows = of_kind(TensorKind::table);
  TensorTable table;
  for (std::size_t i = 0; i < vertices; ++i)
    for (const double v : spacing(i)) table.values.push_back(v);
  rows.table = std::make_shared<const TensorTable>(table);
  TensorParameters vectors = of_kind(TensorKind::table);
  table = {3, {}};
  for (std::size_t i = 0; i < vertices; ++i)
    for (const double v : {vector(i).x, vector(i).y, vector(i).z}) table.values.push_back(v);
  vectors.table = std::make_shared<const TensorTable>(table);

  const auto by_formulas = [](std::span<const double> numbers) {
    TensorParameters parameters = of_kind(TensorKind::formula);
    for (const double number : numbers)
      parameters.formula += (parameters.formula.empty() ? "" : ", ") + fmt::format("{}", number);
    return parameters;
  };
  const std::array<double, 3> along = {3 * direction.x, 3 * direction.y, 3 * direction.z};

  for (const TensorParameters& parameters :
       {by_formulas(constant.constant), by_formulas(along), of_kind(TensorKind::vertex_attribute, "s"), g,
        of_kind(TensorKind::vertex_attribute, "v"), of_kind(TensorKind::face_attribute, "s"),
        of_kind(TensorKind::face_attribute, "v"), constant, rows, vectors}) {
    TensorFieldReport report;
    const TensorField field = make_tensor_field(file, mesh, parameters, {}, &report);
    CAPTURE(static_cast<int>(parameters.kind), parameters.attribute);
    check_direction(mesh, field, direction, 3);
    CHECK(report.clamped_triangles == 0);
    CHECK(report.mean_ratio == Approx(3));
    CHECK(report.max_ratio == Approx(3));
    for (const double d : tensor_density(field)) REQUIRE(d == Approx(1));
  }
  for (const TangentTensor& t : make_tensor_field(file, mesh, of_kind(TensorKind::isotropic)).corner) {
    CHECK(trace(t) == 0);
    CHECK(t.xy == 0);
  }
}

TEST_CASE("make_tensor_field: values follow the numbering of the file, whatever the working order") {
  PolygonMesh file = merged(moved(icosphere(2), 1, 3, 0, 0), icosphere(1));
  // On a sphere about the origin or not: a density that varies, by file vertex.
  add_six(file.vertex_attributes, "s", file.vertex_count(), [&](std::size_t i) {
    const double s = 1 + 0.1 * static_cast<double>(i % 17);
    return Six{s, 0, 0, s, 0, s};
  });
  add_six(file.face_attributes, "s", file.polygon_count(), [&](std::size_t i) {
    const double s = 1 + 0.1 * static_cast<double>(i % 17);
    return Six{s, 0, 0, s, 0, s};
  });
  const PreparedMesh mesh = prepare_mesh(file);
  for (const TensorKind kind : {TensorKind::vertex_attribute, TensorKind::face_attribute}) {
    const TensorField field = make_tensor_field(file, mesh, of_kind(kind, "s"));
    const std::vector<double> density = tensor_density(field);
    double factor = 0, integral = 0, worst = 0;
    for (std::uint32_t h = 0; h < density.size(); ++h) {
      const std::size_t i =
          kind == TensorKind::vertex_attribute ? file.corners[mesh.corner_slot[h]] : mesh.polygon[h / 3];
      const double s = 1 + 0.1 * static_cast<double>(i % 17);
      if (h == 0) factor = density[h] * s * s;
      worst = std::max(worst, std::abs(density[h] * s * s / factor - 1));
      integral += density[h] * mesh.area[h / 3] / 3;
    }
    CHECK(worst < 1e-12);
    CHECK(integral == Approx(mesh.total_area));
  }
}

TEST_CASE("make_tensor_field: ratios are clamped and counted, densities kept") {
  PolygonMesh file = grid_plane(10, 10);
  add_six(file.vertex_attributes, "s", file.vertex_count(),
          [&](std::size_t i) { return i % 11 < 5 ? Six{2, 0, 0, 1, 0, 1} : Six{100, 0, 0, 1, 0, 1}; });
  const PreparedMesh mesh = prepare_mesh(file);
  TensorParameters parameters = of_kind(TensorKind::vertex_attribute, "s");
  TensorFieldReport report;
  const TensorField field = make_tensor_field(file, mesh, parameters, {}, &report);
  CHECK(report.clamped_triangles == 120);  // 6 of 10 columns touch such a vertex
  CHECK(report.max_ratio == Approx(8));
  CHECK(report.mean_ratio == Approx((4 * 2 + 5 * 8 + 5) / 10.0));
  const std::vector<double> density = tensor_density(field);
  for (const double d : density) {
    const double relative = d / *std::max_element(density.begin(), density.end());
    CHECK((relative == Approx(1) || relative == Approx(0.02)));
  }
  parameters.max_ratio = 64;
  make_tensor_field(file, mesh, parameters, {}, &report);
  CHECK(report.max_ratio == Approx(64));
  parameters.max_ratio = 1;
  for (const TangentTensor& t : make_tensor_field(file, mesh, parameters, {}, &report).corner)
    CHECK(t.xx == Approx(t.yy));
  CHECK(report.mean_ratio == Approx(1));
}

TEST_CASE("make_tensor_field: invariant to the scale of the mesh and of the values") {
  const PolygonMesh file = icosphere(3);
  TensorParameters parameters = of_kind(TensorKind::constant);
  parameters.constant = {3, 0.2, -0.4, 1, 0.1, 0.5};
  const PreparedMesh mesh = prepare_mesh(file);
  const TensorField field = make_tensor_field(file, mesh, parameters);
  for (const double scale : {1e-100, 3.0, 1e150}) {
    TensorParameters scaled = parameters;
    for (double& v : scaled.constant) v *= scale;
    REQUIRE(validate(scaled).empty());
    CHECK(worst_difference(make_tensor_field(file, mesh, scaled), field) < 1e-9);
    PolygonMesh vertices = file;
    add_six(vertices.vertex_attributes, "s", file.vertex_count(),
            [&](std::size_t) { return scaled.constant; });
    CHECK(worst_difference(make_tensor_field(vertices, mesh, of_kind(TensorKind::vertex_attribute, "s")),
                           field) < 1e-9);
  }
  PolygonMesh large = file;
  for (std::vector<double>* const x : {&large.x, &large.y, &large.z})
    for (double& v : *x) v *= 1e20;
  CHECK(worst_difference(make_tensor_field(large, prepare_mesh(large), parameters), field) < 1e-9);
  CHECK(worst_difference(make_tensor_field(large, prepare_mesh(large), {}),
                         make_tensor_field(file, mesh, {})) < 1e-9);
}

TEST_CASE(
    "make_tensor_field: formulas give the numbers of every corner, in units of the file or the unit box") {
  const PolygonMesh file = moved(grid_plane(5, 5), 20, 0, 0, 0);
  const PreparedMesh mesh = prepare_mesh(file);
  TensorParameters parameters = of_kind(TensorKind::unit_formula);
  parameters.formula = "(2 + x + z)/sqrt(2), max(1 + x/2, 0)*sqrt(2), 0*y";
  const std::array<double, 6>& box = mesh.bbox;
  const double longest = std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2]});
  const TensorField field = make_tensor_field(file, mesh, parameters);
  double worst = 0;
  for (std::size_t h = 0; h < field.corner.size(); ++h) {
    const Vector3 p = mesh.center + mesh.unit * mesh.position(mesh.triangles[h]);
    const double x = (p.x - box[0]) / longest, z = (p.z - box[2]) / longest;
    const double ratio = std::hypot((2 + x + z) / std::sqrt(2), (1 + x / 2) * std::sqrt(2));
    const TensorAxes axes = spacings_of(field.corner[h]);
    worst = std::max(worst, std::abs(axes.first / axes.second / ratio - 1));
  }
  CHECK(worst < 1e-12);
  parameters.formula = "1, 2";
  CHECK_THAT(validate(parameters).at(0), ContainsSubstring("has 2 formulas: it needs three"));
  parameters.formula = "1, 2, w";
  CHECK_THAT(validate(parameters).at(0), ContainsSubstring("unknown name"));
}

TEST_CASE("make_tensor_field: invalid and missing values are named") {
  PolygonMesh file = grid_plane(3, 3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto six_at = [&](std::size_t bad, Six value) {
    return [bad, value](std::size_t i) { return i == bad || i == 14 ? value : Six{1, 0, 0, 1, 0, 1}; };
  };
  add_six(file.vertex_attributes, "indefinite", 16, six_at(5, {1, 2, 0, 1, 0, 1}));
  add_six(file.vertex_attributes, "flat", 16, six_at(6, {1, 0, 0, 0, 0, 1}));
  add_six(file.vertex_attributes, "nan", 16, six_at(7, {1, 0, 0, nan, 0, 1}));
  add_vector(file.vertex_attributes, "short", 16, [](std::size_t i) {
    return Vector3{i == 9 ? 0.5 : 2, 0, 0};
  });
  add_vector(file.vertex_attributes, "up", 16, [](std::size_t) { return Vector3{0, 0, 2}; });
  add_six(file.face_attributes, "nan", 18, six_at(3, {nan, 0, 0, 1, 0, 1}));
  file.vertex_attributes.push_back({"part_xx", std::vector<double>(16, 1.0)});
  const PreparedMesh mesh = prepare_mesh(file);
  const auto fails = [&](const TensorParameters& parameters, const std::string& sentence,
                         Status status = Status::unreadable) {
    CAPTURE(sentence);
    try {
      make_tensor_field(file, mesh, parameters);
      FAIL("nothing was thrown");
    } catch (const ItemError& error) {
      CHECK(error.status() == status);
      CHECK_THAT(error.what(), ContainsSubstring(sentence));
    }
  };
  fails(of_kind(TensorKind::vertex_attribute, "indefinite"),
        "the vertex attribute \"indefinite\" is not positive definite in the tangent plane at vertex 5");
  fails(of_kind(TensorKind::vertex_attribute, "flat"), "at vertex 6");
  fails(of_kind(TensorKind::vertex_attribute, "nan"),
        "the vertex attribute \"nan\" is not finite at vertex 7");
  fails(of_kind(TensorKind::vertex_attribute, "short"), "has length 0.5 at vertex 9");
  fails(of_kind(TensorKind::face_attribute, "nan"), "the face attribute \"nan\" is not finite at face 3");
  fails(of_kind(TensorKind::vertex_attribute, "part"), "needs the vertex attribute part_xy",
        Status::missing_attribute);
  fails(of_kind(TensorKind::face_attribute, "none"), "has only the face attributes nan_xx, nan_xy",
        Status::missing_attribute);
  TensorParameters formulas = of_kind(TensorKind::formula);
  formulas.formula = "1, 0, 0, x - 0.5, 0, 1";
  fails(formulas,
        "the tensor `1, 0, 0, x - 0.5, 0, 1` is not positive definite in the tangent plane at face ");
  formulas.formula = "log(x), 0, 0";
  fails(formulas, "the tensor `log(x), 0, 0` is not finite at face ");
  formulas.formula = "u, 0, 0";
  fails(formulas, "uses texture coordinates, u or v, but the file has none", Status::missing_attribute);
  TensorParameters table = of_kind(TensorKind::table);
  table.table = std::make_shared<const TensorTable>(TensorTable{3, std::vector<double>(45, 1.0)});
  fails(table, "the tensor table has 15 rows but the file has 16 vertices");
  // A vector along the normal has no direction in the plane: isotropic.
  for (const TangentTensor& t :
       make_tensor_field(file, mesh, of_kind(TensorKind::vertex_attribute, "up")).corner)
    CHECK(t.xx == Approx(t.yy).margin(1e-12));
}

TEST_CASE("make_tensor_field: values of unused vertices do not matter") {
  PolygonMesh file = polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 9, 9}, {{0, 1, 2}});
  add_six(file.vertex_attributes, "s", 4,
          [](std::size_t i) { return i == 3 ? Six{-1, 0, 0, -1, 0, -1} : Six{2, 0, 0, 1, 0, 1}; });
  const PreparedMesh mesh = prepare_mesh(file);
  check_direction(mesh, make_tensor_field(file, mesh, of_kind(TensorKind::vertex_attribute, "s")), {1, 0, 0},
                  2);
}

TEST_CASE("make_tensor_field: attributes of a PLY file are read by name") {
  PolygonMesh file = grid_plane(4, 4);
  add_six(file.vertex_attributes, "stroke", file.vertex_count(), [](std::size_t) {
    return tensor_along({0.6, 0.8, 0}, {0, 0, 1}, 4, 1, 1);
  });
  add_vector(file.face_attributes, "flow", file.polygon_count(), [](std::size_t) {
    return Vector3{0, 5, 0};
  });
  const ScratchFolder folder;
  write_mesh(folder / "plane.ply", file, MeshFile::ply_little_endian);
  const PolygonMesh read = read_mesh(FileBytes(folder / "plane.ply").bytes(), MeshFormat::ply);
  const PreparedMesh mesh = prepare_mesh(read);
  check_direction(mesh, make_tensor_field(read, mesh, of_kind(TensorKind::vertex_attribute, "stroke")),
                  {0.6, 0.8, 0}, 4);
  check_direction(mesh, make_tensor_field(read, mesh, of_kind(TensorKind::face_attribute, "flow")), {0, 1, 0},
                  5);
}

TEST_CASE("TensorParameters: values out of range are named") {
  CHECK(validate(TensorParameters{}).empty());
  TensorParameters p;
  p.max_ratio = 65;
  p.epsilon = 0;
  p.smoothing = 100;
  CHECK(validate(p).size() == 3);
  CHECK_THROWS_AS(make_tensor_field({}, {}, p), std::invalid_argument);
  p = of_kind(TensorKind::vertex_attribute);
  CHECK(validate(p).size() == 1);
  p = of_kind(TensorKind::constant);
  CHECK(validate(p).empty());
  p.constant = {1, 2, 0, 1, 0, 1};
  CHECK(validate(p).size() == 1);
  p.constant = {1, 0, 0, 1, 0, std::numeric_limits<double>::quiet_NaN()};
  CHECK(validate(p).size() == 1);
  p = of_kind(TensorKind::table);
  CHECK(validate(p).size() == 1);
  p.table = std::make_shared<const TensorTable>(TensorTable{4, {}});
  CHECK(validate(p).size() == 1);
}
