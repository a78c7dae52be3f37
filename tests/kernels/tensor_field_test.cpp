#include "kernels/tensor/tensor_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "kernels/mesh/prepare_mesh.h"
#include "kernels/unit_vector.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

using std::numbers::pi;

TangentTensor tensor_at(double angle, double first, double second) {
  return tensor_of({first, second, std::cos(angle), std::sin(angle)});
}

void check_equal(TangentTensor a, TangentTensor b, double margin) {
  CHECK(a.xx == Approx(b.xx).margin(margin));
  CHECK(a.xy == Approx(b.xy).margin(margin));
  CHECK(a.yy == Approx(b.yy).margin(margin));
}

// The tensor with spacings s1, s2 whose primary direction is `direction` projected to the frame's plane.
TangentTensor along(const TangentFrame& frame, Vector3 direction, double s1, double s2) {
  const double x = dot(direction, frame.x), y = dot(direction, frame.y), length = std::hypot(x, y);
  return tensor_of({std::log(s1), std::log(s2), x / length, y / length});
}

// The same log S everywhere in a plane z = 0, given along `angle`.
TensorField plane_field(const PreparedMesh& mesh, double angle, double s1, double s2) {
  const std::vector<TangentFrame> frames(mesh.vertex_count(), frame_of_normal({0, 0, 1}));
  const std::vector<TangentTensor> values(mesh.vertex_count(),
                                          along(frames[0], {std::cos(angle), std::sin(angle), 0}, s1, s2));
  return field_from_vertices(mesh, frames, values);
}

// A radial frame and a spiral field on a surface around the origin.
struct VertexField {
  std::vector<TangentFrame> frames;
  std::vector<TangentTensor> values;
};
VertexField spiral_field(const PolygonMesh& file, const PreparedMesh& mesh) {
  VertexField field;
  field.frames.resize(mesh.vertex_count());
  field.values.resize(mesh.vertex_count());
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h) {
    const std::uint32_t i = file.corners[mesh.corner_slot[h]], v = mesh.triangles[h];
    const Vector3 p{file.x[i], file.y[i], file.z[i]};
    field.frames[v] = frame_of_normal(unit(p));
    field.values[v] = along(field.frames[v], {1 - p.y, p.x, 0.3 * p.z}, 2 + p.z, 0.5 + 0.2 * p.x * p.x);
  }
  return field;
}

// A strip of width 1 folded along its columns, so that its profile is a polygon with sides of one length that
// turn by `turn` each. Isometric to the flat one (turn = 0).
PolygonMesh folded_strip(std::uint32_t columns, std::uint32_t rows, double turn) {
  PolygonMesh mesh = grid_plane(columns, rows);
  std::vector<double> px(columns + 1, 0.0), pz(columns + 1, 0.0);
  for (std::uint32_t i = 0; i < columns; ++i) {
    px[i + 1] = px[i] + std::cos(turn * i) / columns;
    pz[i + 1] = pz[i] + std::sin(turn * i) / columns;
  }
  for (std::size_t v = 0; v < mesh.x.size(); ++v) {
    mesh.x[v] = px[v % (columns + 1)];
    mesh.z[v] = pz[v % (columns + 1)];
  }
  return mesh;
}

}  // namespace

TEST_CASE("tangent tensors: axes and tensor_of are inverse, for every angle") {
  for (int i = -90; i <= 90; ++i) {
    const double angle = pi * i / 180;
    const TensorAxes axes = tensor_axes(tensor_at(angle, 3, -0.5));
    CAPTURE(i);
    CHECK(axes.first == Approx(3));
    CHECK(axes.second == Approx(-0.5));
    CHECK(axes.x * axes.x + axes.y * axes.y == Approx(1));
    CHECK(std::abs(axes.x * std::sin(angle) - axes.y * std::cos(angle)) < 1e-14);
    CHECK((axes.x > 0 || (axes.x == 0 && axes.y > 0)));
  }
  const TensorAxes vertical = tensor_axes({1, 0, 2});
  CHECK(vertical.x == 0);
  CHECK(vertical.y == 1);
  const TensorAxes round = tensor_axes({2, 0, 2});
  CHECK(round.x == 1);
  CHECK(round.first == 2);
  // Small angles keep their digits.
  CHECK(tensor_axes(tensor_at(1e-10, 2, 1)).y == Approx(1e-10).epsilon(1e-12));
  CHECK(tensor_axes(tensor_at(pi / 2 + 1e-10, 2, 1)).x == Approx(1e-10).epsilon(1e-5));
}

TEST_CASE("tangent tensors: exponential, logarithm, metric and spacing forms") {
  const double angle = 0.7;
  const TangentTensor s = tensor_at(angle, 4, 0.25), l = logarithm(s);
  check_equal(l, tensor_at(angle, std::log(4.0), std::log(0.25)), 1e-14);
  check_equal(exponential(l), s, 1e-14);
  CHECK(trace(l) == Approx(0).margin(1e-14));
  CHECK(determinant(s) == Approx(1));
  const TensorAxes spacings = spacings_of(l);
  CHECK(spacings.first == Approx(4));
  CHECK(spacings.second == Approx(0.25));
  CHECK(spacings.x == Approx(std::cos(angle)));
  const TangentTensor g = metric_of(l);
  check_equal(g, tensor_at(angle, 1.0 / 16, 16), 1e-12);
  check_equal(-0.5 * logarithm(g), l, 1e-13);
  // A step of one spacing along either axis has length 1.
  CHECK(quadratic(g, 4 * std::cos(angle), 4 * std::sin(angle)) == Approx(1));
  CHECK(quadratic(g, -0.25 * std::sin(angle), 0.25 * std::cos(angle)) == Approx(1));
}

TEST_CASE("tangent tensors: rotated frames keep the quadratic form") {
  const TangentTensor a{1.3, -0.4, 0.2};
  for (const double angle : {0.0, 0.3, 1.9, -2.5}) {
    const double c = std::cos(angle), s = std::sin(angle), x = 0.6, y = -1.1;
    CHECK(quadratic(in_turned_frame(a, c, s), c * x + s * y, -s * x + c * y) == Approx(quadratic(a, x, y)));
  }
  check_equal(in_turned_frame(tensor_at(0.9, 2, 1), std::cos(0.9), std::sin(0.9)), {2, 0, 1}, 1e-15);
}

TEST_CASE("transport: a rotation from normal to normal that moves nothing along the fold") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return unit({normal(random), normal(random), normal(random)}); };
  for (int i = 0; i < 50; ++i) {
    const Vector3 from = direction(), to = direction(), v = direction(), w = direction();
    CHECK(norm(transport(from, from, to) - to) < 1e-13);
    CHECK(dot(transport(v, from, to), transport(w, from, to)) == Approx(dot(v, w)).margin(1e-13));
    const Vector3 fold = unit(cross(from, to));
    CHECK(norm(transport(fold, from, to) - fold) < 1e-13);
    CHECK(norm(transport(transport(v, from, to), to, from) - v) < 1e-13);

    // A tensor is carried like its axes, into whatever frame.
    const TangentFrame a = frame_of_normal(from), b = frame_of_normal(to);
    const TensorAxes before{2, 1, std::cos(0.1 * i), std::sin(0.1 * i)};
    const Vector3 axis = transport(before.x * a.x + before.y * a.y, from, to);
    const TensorAxes after = tensor_axes(transport(tensor_of(before), a, b));
    CHECK(after.first == Approx(2));
    CHECK(after.second == Approx(1));
    CHECK(norm(cross(axis, after.x * b.x + after.y * b.y)) < 1e-12);
  }
  for (const Vector3 n : {Vector3{1, 0, 0}, Vector3{0, -1, 0}, Vector3{0, 0, 1}, unit({1, 1, 1})}) {
    const TangentFrame frame = frame_of_normal(n);
    CHECK(norm(cross(frame.x, frame.y) - n) < 1e-15);
    // Opposite normals: the plane is the same, seen from behind.
    const Vector3 back = transport(frame.x, n, -1.0 * n);
    CHECK(norm(back - frame.x) < 1e-12);
  }
}

TEST_CASE("metric lengths: a constant tensor on a plane is exact") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(7, 5, 2, 1));
  const double angle = 0.4, s1 = 3, s2 = 0.5;
  const std::vector<double> length = metric_edge_lengths(mesh, plane_field(mesh, angle, s1, s2));
  for (std::uint32_t h = 0; h < length.size(); ++h) {
    const Vector3 e = mesh.position(mesh.triangles[next_half_edge(h)]) - mesh.position(mesh.triangles[h]);
    const double a = std::cos(angle) * e.x + std::sin(angle) * e.y;
    const double b = -std::sin(angle) * e.x + std::cos(angle) * e.y;
    REQUIRE(length[h] == Approx(std::hypot(a / s1, b / s2)).epsilon(1e-12));
    if (mesh.opposite[h] != no_index) REQUIRE(length[h] == length[mesh.opposite[h]]);
  }
}

TEST_CASE("metric lengths: invariant to moving mesh and field together") {
  const PolygonMesh still = icosphere(2);
  const PreparedMesh a = prepare_mesh(still), b = prepare_mesh(moved(still, 1, 0.1, -0.2, 0.3));
  // `moved` may reorder triangles and rescale by a power of two: compare by the file's corners, in file
  // units. The field of b is that of a, its axes turned by the same rotation.
  const PolygonMesh origin = moved(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {}), 1, 0, 0, 0);
  const auto turned = [&](Vector3 v) {
    const auto column = [&](std::size_t k) {
      return Vector3{origin.x[k] - origin.x[0], origin.y[k] - origin.y[0], origin.z[k] - origin.z[0]};
    };
    return v.x * column(1) + v.y * column(2) + v.z * column(3);
  };
  const VertexField field = spiral_field(still, a);
  VertexField other;
  other.frames.resize(b.vertex_count());
  other.values.resize(b.vertex_count());
  std::vector<std::uint32_t> working(still.vertex_count());
  for (std::size_t h = 0; h < a.triangles.size(); ++h)
    working[still.corners[a.corner_slot[h]]] = a.triangles[h];
  for (std::size_t h = 0; h < b.triangles.size(); ++h) {
    const std::uint32_t v = working[still.corners[b.corner_slot[h]]], w = b.triangles[h];
    const TensorAxes axes = tensor_axes(field.values[v]);
    const Vector3 primary = turned(axes.x * field.frames[v].x + axes.y * field.frames[v].y);
    other.frames[w] = frame_of_normal(turned(field.frames[v].normal));
    other.values[w] = along(other.frames[w], primary, std::exp(axes.first), std::exp(axes.second));
  }
  const std::vector<double> first =
      metric_edge_lengths(a, field_from_vertices(a, field.frames, field.values));
  const std::vector<double> second =
      metric_edge_lengths(b, field_from_vertices(b, other.frames, other.values));
  std::vector<double> by_slot(first.size());
  for (std::size_t h = 0; h < first.size(); ++h) by_slot[a.corner_slot[h]] = a.unit * first[h];
  double worst = 0;
  for (std::size_t h = 0; h < second.size(); ++h)
    worst = std::max(worst, std::abs(b.unit * second[h] / by_slot[b.corner_slot[h]] - 1));
  CHECK(worst < 1e-11);
}

TEST_CASE("metric lengths: a sheet bent together with its field keeps the lengths of the flat one") {
  const std::uint32_t columns = 12, rows = 5;
  const double turn = 0.35;
  const PolygonMesh flat_file = folded_strip(columns, rows, 0), bent_file = folded_strip(columns, rows, turn);
  const PreparedMesh flat = prepare_mesh(flat_file), bent = prepare_mesh(bent_file);
  const auto field_on = [&](const PreparedMesh& mesh, const PolygonMesh& file, double step) {
    VertexField field;
    field.frames.resize(mesh.vertex_count());
    field.values.resize(mesh.vertex_count());
    for (std::size_t h = 0; h < mesh.triangles.size(); ++h) {
      const std::uint32_t i = file.corners[mesh.corner_slot[h]], v = mesh.triangles[h];
      const double slope = step * (static_cast<double>(i % (columns + 1)) - 0.5);
      const Vector3 forward{std::cos(slope), 0, std::sin(slope)}, across{0, 1, 0};
      const double angle = 0.2 * i, c = std::cos(angle), s = std::sin(angle);
      field.frames[v] = frame_of_normal(cross(forward, across));
      field.values[v] = along(field.frames[v], c * forward + s * across, 2 + std::sin(0.3 * i), 0.4);
    }
    return metric_edge_lengths(mesh, field_from_vertices(mesh, field.frames, field.values));
  };
  const std::vector<double> a = field_on(flat, flat_file, 0), b = field_on(bent, bent_file, turn);
  std::vector<double> by_slot(a.size());
  for (std::size_t h = 0; h < a.size(); ++h) by_slot[flat.corner_slot[h]] = flat.unit * a[h];
  double worst = 0;
  for (std::size_t h = 0; h < b.size(); ++h)
    worst = std::max(worst, std::abs(bent.unit * b[h] / by_slot[bent.corner_slot[h]] - 1));
  CHECK(worst < 1e-11);
}

TEST_CASE("normalize_spacings: mean density 1, whatever the units of field and mesh") {
  const PolygonMesh file = icosphere(3);
  std::vector<double> first;
  for (const double scale : {1.0, 1e-6, 3e5}) {
    const PolygonMesh scaled = moved(file, scale, 0, 0, 0);
    const PreparedMesh mesh = prepare_mesh(scaled);
    // The field of the unscaled mesh, times a factor: corners are intrinsic.
    VertexField field = spiral_field(scaled, mesh);
    for (std::size_t h = 0; h < mesh.triangles.size(); ++h) {
      const std::uint32_t i = scaled.corners[mesh.corner_slot[h]], v = mesh.triangles[h];
      const Vector3 p{scaled.x[i] / scale, scaled.y[i] / scale, scaled.z[i] / scale};
      field.values[v] = along(field.frames[v], {1 - p.y, p.x, 0.3 * p.z}, 2 + p.z, 0.5 + 0.2 * p.x * p.x);
      field.values[v].xx += std::log(7 * scale);
      field.values[v].yy += std::log(7 * scale);
    }
    TensorField result = field_from_vertices(mesh, field.frames, field.values);
    const std::vector<double> before = metric_edge_lengths(mesh, result);
    const double factor = normalize_spacings(mesh, result);
    const std::vector<double> density = tensor_density(result), length = metric_edge_lengths(mesh, result);
    double integral = 0;
    for (std::size_t h = 0; h < density.size(); ++h) integral += mesh.area[h / 3] * density[h] / 3;
    CHECK(integral == Approx(mesh.total_area).epsilon(1e-12));
    CHECK(length[5] * factor == Approx(before[5]));
    std::vector<double> by_slot(length.size());
    for (std::size_t h = 0; h < length.size(); ++h)
      by_slot[mesh.corner_slot[h]] = length[h] / std::sqrt(mesh.total_area);
    if (first.empty()) first = by_slot;
    double worst = 0;
    for (std::size_t h = 0; h < first.size(); ++h)
      worst = std::max(worst, std::abs(by_slot[h] / first[h] - 1));
    CHECK(worst < 1e-9);
    TensorField again = result;
    CHECK(normalize_spacings(mesh, again) == Approx(1).epsilon(1e-12));
  }
}

TEST_CASE("interpolate: weights of the corners, positive definite between them") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(1, 1));
  TensorField field = plane_field(mesh, 0, 1, 1);
  field.corner[0] = tensor_at(0, std::log(8.0), std::log(0.5));
  field.corner[1] = tensor_at(pi / 2, std::log(8.0), std::log(0.5));
  field.corner[2] = {0, 0, 0};
  check_equal(interpolate(field, 0, {1, 0, 0}), field.corner[0], 1e-15);
  // Half way between crossed spacings 8 and 0.5: both are 2.
  const TensorAxes middle = spacings_of(interpolate(field, 0, {0.5, 0.5, 0}));
  CHECK(middle.first == Approx(2));
  CHECK(middle.second == Approx(2));
  CHECK(tensor_density(field)[0] == Approx(0.25));
}

TEST_CASE("tensor field: triangles without area have S = 1, and edges as long as their other side says") {
  // The middle triangle (0, 2, 1) is a line: 1 lies on the edge from 0 to 2 of the lower one.
  const PolygonMesh file = polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0, 1, 1, 0, 1, -1, 0},
                                        {{0, 1, 3}, {1, 2, 3}, {0, 2, 1}, {0, 4, 2}});
  const PreparedMesh mesh = prepare_mesh(file);
  TensorField field = plane_field(mesh, 0, 2, 1);
  const std::vector<double> length = metric_edge_lengths(mesh, field);
  std::size_t flat = 0;
  for (std::uint32_t h = 0; h < length.size(); ++h) {
    const Vector3 e = mesh.position(mesh.triangles[next_half_edge(h)]) - mesh.position(mesh.triangles[h]);
    CHECK(length[h] == Approx(std::hypot(e.x / 2, e.y)));
    if (mesh.area[h / 3] > 0) continue;
    ++flat;
    check_equal(field.corner[h], {0, 0, 0}, 0);
  }
  CHECK(flat == 3);
}
