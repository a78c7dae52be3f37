#include "kernels/tensor/curvature_tensors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>
#include <random>

#include "kernels/mesh/prepare_mesh.h"
#include "kernels/tensor/vertex_tensors.h"
#include "kernels/unit_vector.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// The tensor of the plane as an ambient one that vanishes along the normal: the inverse of tangent_part.
AmbientTensor ambient_tensor(TangentTensor t, const TangentFrame& frame) {
  const Vector3 x = t.xx * frame.x + t.xy * frame.y, y = t.xy * frame.x + t.yy * frame.y;
  const Vector3 u = frame.x, v = frame.y;
  return {x.x * u.x + y.x * v.x, x.x * u.y + y.x * v.y, x.x * u.z + y.x * v.z,
          x.y * u.y + y.y * v.y, x.y * u.z + y.y * v.z, x.z * u.z + y.z * v.z};
}

using std::numbers::pi;

Vector3 file_position(const PreparedMesh& mesh, std::uint32_t v) {
  return mesh.center + mesh.unit * mesh.position(v);
}

std::vector<double> vertex_areas(const PreparedMesh& mesh) {
  std::vector<double> area(mesh.vertex_count(), 0.0);
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h) area[mesh.triangles[h]] += mesh.area[h / 3] / 3;
  return area;
}

// Open cylinder of radius 1 and height 2 about z; inner vertices moved on it by up to `jitter` of a cell.
PolygonMesh cylinder(std::uint32_t around, std::uint32_t rings, double jitter) {
  PolygonMesh mesh = grid_plane(around, rings);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> move(-jitter, jitter);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const bool rim = mesh.y[i] == 0 || mesh.y[i] == 1;
    const double s = 2 * pi * (mesh.x[i] + move(random) / around);
    const double height = 2 * (mesh.y[i] + (rim ? 0 : move(random) / rings));
    mesh.x[i] = std::cos(s);
    mesh.y[i] = std::sin(s);
    mesh.z[i] = height;
  }
  for (std::size_t i = 0; i < mesh.x.size(); i += around + 1) {
    mesh.x[i + around] = mesh.x[i];
    mesh.y[i + around] = mesh.y[i];
    mesh.z[i + around] = mesh.z[i];
  }
  return mesh;
}

PolygonMesh ellipsoid(int subdivisions, double a, double b, double c) {
  PolygonMesh mesh = icosphere(subdivisions);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    mesh.x[i] *= a;
    mesh.y[i] *= b;
    mesh.z[i] *= c;
  }
  return mesh;
}

// A closed form: the unit normal and the shape operator in ambient axes (zero along the normal).
struct Shape {
  Vector3 normal;
  AmbientTensor curvature;
};
// Of the level set of a function with this gradient and Hessian: P H P / |gradient|.
Shape level_set(Vector3 gradient, const AmbientTensor& hessian) {
  TangentFrame frame = frame_of_normal(unit(gradient));
  const TangentTensor inner = tangent_part(hessian, frame);
  return {frame.normal, ambient_tensor((1 / norm(gradient)) * inner, frame)};
}
Shape torus_shape(Vector3 p, double major, double minor) {
  const double r = std::hypot(p.x, p.y);
  const Vector3 out{p.x / r, p.y / r, 0};
  TangentFrame frame = frame_of_normal(unit(p - major * out));
  frame.x = {-out.y, out.x, 0};  // round the axis
  frame.y = cross(frame.normal, frame.x);
  return {frame.normal, ambient_tensor({dot(frame.normal, out) / r, 0, 1 / minor}, frame)};
}

struct Errors {
  double normal = 0, tensor = 0, worst_tensor = 0;  // area-weighted means, and the worst
  double angle = 0, worst_angle = 0, ratio = 0;     // of directions (radians) and of log(s1 / s2)
};

std::ostream& operator<<(std::ostream& out, const Errors& e) {
  return out << " normal " << e.normal << " tensor " << e.tensor << " worst " << e.worst_tensor << " angle "
             << e.angle << " worst " << e.worst_angle << " ratio " << e.ratio;
}

// Curvature tensors and the unsmoothed field against a closed form. Directions count where the exact ratio
// is at least `least_ratio`. Curvature errors in units of `scale`.
template <class Exact>
Errors errors_of(const PolygonMesh& file, const Exact& exact, double least_ratio, double scale,
                 unsigned smoothing = 0) {
  const PreparedMesh mesh = prepare_mesh(file);
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  const std::vector<TangentTensor> tensors = curvature_tensors(mesh, frames);
  CurvatureFieldParameters parameters;
  parameters.smoothing = smoothing;
  const std::vector<TangentTensor> field = curvature_field(mesh, frames, parameters);
  const std::vector<double> area = vertex_areas(mesh);
  const double epsilon = parameters.epsilon / mesh.diagonal;
  Errors errors;
  double total = 0, directed = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Shape shape = exact(file_position(mesh, v));
    const TangentFrame plane = frame_of_normal(shape.normal);
    const TangentTensor truth = tangent_part(shape.curvature, plane);
    const TangentTensor found = transport((1 / mesh.unit) * tensors[v], frames[v], plane);
    const TangentTensor off = found + -1.0 * truth;
    const double wrong = std::sqrt(off.xx * off.xx + 2 * off.xy * off.xy + off.yy * off.yy) / scale;
    errors.normal += area[v] * norm(frames[v].normal - shape.normal);
    errors.tensor += area[v] * wrong;
    errors.worst_tensor = std::max(errors.worst_tensor, wrong);
    total += area[v];

    const TensorAxes axes = tensor_axes(truth);
    const bool second_longer = std::abs(axes.second) < std::abs(axes.first);
    const double high = std::max(std::abs(axes.first), std::abs(axes.second)) + epsilon;
    const double low = std::min(std::abs(axes.first), std::abs(axes.second)) + epsilon;
    const double ratio = std::min(std::sqrt(high / low), parameters.max_ratio);
    if (ratio < least_ratio) continue;
    const double x = second_longer ? -axes.y : axes.x, y = second_longer ? axes.x : axes.y;
    const TensorAxes got = tensor_axes(transport(field[v], frames[v], plane));
    const double angle = std::asin(std::min(1.0, std::abs(got.x * y - got.y * x)));
    errors.angle += area[v] * angle;
    errors.worst_angle = std::max(errors.worst_angle, angle);
    errors.ratio += area[v] * std::abs(got.first - got.second - std::log(ratio));
    directed += area[v];
  }
  errors.normal /= total;
  errors.tensor /= total;
  errors.angle /= directed;
  errors.ratio /= directed;
  return errors;
}

PolygonMesh noisy(PolygonMesh mesh, double amplitude) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> move(-amplitude, amplitude);
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    mesh.x[i] += move(random);
    mesh.y[i] += move(random);
    mesh.z[i] += move(random);
  }
  return mesh;
}

}  // namespace

TEST_CASE("tangent_part and ambient_tensor are inverse on the plane") {
  const TangentFrame frame = frame_of_normal(unit({0.3, -0.5, 0.8}));
  const TangentTensor t{2, -0.3, 0.7}, back = tangent_part(ambient_tensor(t, frame), frame);
  CHECK(back.xx == Approx(t.xx));
  CHECK(back.xy == Approx(t.xy));
  CHECK(back.yy == Approx(t.yy));
  const TangentTensor identity = tangent_part({}, frame);
  CHECK(identity.xx == Approx(1));
  CHECK(identity.xy == Approx(0).margin(1e-15));
  CHECK(tangent_part({1, 2, 3, 4, 5, 6}, frame_of_normal({0, 0, 1})).xx == 1);
}

TEST_CASE("vertex_frames: exact on a sphere and a cylinder grid, right-handed, robust without area") {
  const PreparedMesh sphere = prepare_mesh(icosphere(2));
  const std::vector<TangentFrame> frames = vertex_frames(sphere);
  for (std::uint32_t v = 0; v < sphere.vertex_count(); ++v) {
    CHECK(norm(frames[v].normal - unit(file_position(sphere, v))) < 1e-12);
    CHECK(norm(cross(frames[v].x, frames[v].y) - frames[v].normal) < 1e-14);
  }
  // Vertex 3 in the middle of an edge: two triangles, one of them without area. Vertex 4 lies on the line
  // (0, 3): all its triangles are without area.
  const PreparedMesh thin = prepare_mesh(
      polygon_mesh({0, 0, 0, 2, 0, 0, 0, 2, 0, 1, 0, 0, 0.5, 0, 0}, {{0, 1, 2}, {0, 3, 1}, {0, 4, 3}}));
  for (const TangentFrame& frame : vertex_frames(thin)) CHECK(norm(frame.normal - Vector3{0, 0, 1}) < 1e-14);
}

TEST_CASE("smooth_tensors: constants stay, noise decreases, ratios never grow") {
  const PreparedMesh plane = prepare_mesh(grid_plane(20, 20));
  const std::vector<TangentFrame> flat = vertex_frames(plane);
  std::vector<TangentTensor> same(plane.vertex_count(), {0.7, 0.2, -0.3});
  smooth_tensors(plane, flat, same, 5);
  for (const TangentTensor& t : same) {
    CHECK(t.xx == Approx(0.7));
    CHECK(t.xy == Approx(0.2));
    CHECK(t.yy == Approx(-0.3));
  }
  const PreparedMesh mesh = prepare_mesh(icosphere(3));
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<TangentTensor> noise(mesh.vertex_count());
  for (TangentTensor& t : noise) t = {normal(random), normal(random), normal(random)};
  const auto spread = [&] {
    double sum = 0, most = 0;
    for (const TangentTensor& t : noise) {
      const TensorAxes axes = tensor_axes(t);
      sum += t.xx * t.xx + 2 * t.xy * t.xy + t.yy * t.yy;
      most = std::max(most, axes.first - axes.second);
    }
    return std::pair{std::sqrt(sum / static_cast<double>(noise.size())), most};
  };
  const auto before = spread();
  smooth_tensors(mesh, frames, noise, 1);
  const auto once = spread();
  smooth_tensors(mesh, frames, noise, 4);
  const auto after = spread();
  CHECK(once.first < 0.7 * before.first);
  CHECK(after.first < 0.4 * before.first);
  CHECK(once.second <= before.second);
  CHECK(after.second <= once.second);
}

TEST_CASE("smooth_tensors: the transported mean over both neighbors of every corner") {
  // A closed surface, and one with a boundary and triangles of unequal areas.
  PolygonMesh sheet = grid_plane(9, 6);
  for (std::size_t v = 0; v < sheet.x.size(); ++v) {
    sheet.x[v] *= 1 + sheet.x[v];
    sheet.z[v] = 0.4 * std::sin(3 * sheet.x[v]) * std::cos(2 * sheet.y[v]);
  }
  for (const PolygonMesh& polygons : {icosphere(2), sheet}) {
    const PreparedMesh mesh = prepare_mesh(polygons);
    const std::vector<TangentFrame> frames = vertex_frames(mesh);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<TangentTensor> before(mesh.vertex_count());
    for (TangentTensor& t : before) t = {normal(random), normal(random), normal(random)};
    std::vector<TangentTensor> sum(before.size());
    std::vector<double> weight(before.size(), 0);
    for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h)
      for (const std::uint32_t other : {next_half_edge(h), previous_half_edge(h)}) {
        const std::uint32_t v = mesh.triangles[h], w = mesh.triangles[other];
        sum[v] = sum[v] + mesh.area[h / 3] * transport(before[w], frames[w], frames[v]);
        weight[v] += mesh.area[h / 3];
      }
    std::vector<TangentTensor> smooth = before;
    smooth_tensors(mesh, frames, smooth, 1);
    for (std::size_t v = 0; v < smooth.size(); ++v) {
      const TangentTensor expected = 0.5 * before[v] + (0.5 / weight[v]) * sum[v];
      CHECK(smooth[v].xx == Approx(expected.xx).margin(1e-12));
      CHECK(smooth[v].xy == Approx(expected.xy).margin(1e-12));
      CHECK(smooth[v].yy == Approx(expected.yy).margin(1e-12));
    }
  }
}

TEST_CASE("curvature_tensors: a sphere gives 1 / R everywhere, a field of ratio 1") {
  for (const double radius : {1.0, 250.0}) {
    double last = 1;
    for (const int subdivisions : {2, 3, 4}) {
      const Errors errors = errors_of(
          icosphere(subdivisions, radius),
          [](Vector3 p) {
            return level_set(p, AmbientTensor{1, 0, 0, 1, 0, 1});
          },
          1.0, 1 / radius);
      CAPTURE(subdivisions, errors.tensor, errors.worst_tensor, errors.ratio);
      CHECK(errors.tensor < 1e-9);  // normals and positions are parallel: the fit is exact
      CHECK(errors.ratio < 1e-9);
      CHECK(errors.tensor < last);
      last = std::max(errors.tensor, 1e-12);
    }
  }
}

TEST_CASE(
    "curvature_tensors: on a cylinder straight lines are the primary direction, with the clamped ratio") {
  const auto exact = [](Vector3 p) {
    const TangentFrame frame{{-p.y, p.x, 0}, {0, 0, 1}, {p.x, p.y, 0}};
    return Shape{unit({p.x, p.y, 0}), ambient_tensor({1, 0, 0}, frame)};
  };
  for (const std::uint32_t n : {24u, 96u}) {
    const Errors errors = errors_of(cylinder(n, n / 3, 0), exact, 1.05, 1, 3);
    CHECK(errors.worst_tensor < 1e-12);
    CHECK(errors.worst_angle < 1e-12);  // on the boundary too
    CHECK(errors.ratio < 1e-12);
  }
  // Irregular vertices: their normals are off by O(h), the curvature by a constant share.
  for (const std::uint32_t n : {48u, 96u, 144u}) {
    const Errors raw = errors_of(cylinder(n, n / 3, 0.2), exact, 1.05, 1, 0);
    const Errors smooth = errors_of(cylinder(n, n / 3, 0.2), exact, 1.05, 1, 3);
    CAPTURE(n, raw, smooth);
    CHECK(raw.tensor < 0.03);
    CHECK(raw.worst_angle < 0.05);
    CHECK(smooth.angle < 0.5 * raw.angle);
  }
}

TEST_CASE("curvature_tensors: a torus has closed-form directions and ratios, to second order") {
  Errors last{1, 1, 1, 1, 1, 1};
  for (const std::uint32_t n : {16u, 32u, 64u}) {
    const Errors errors = errors_of(
        torus(2 * n, n), [](Vector3 p) { return torus_shape(p, 1, 0.4); }, 1.3, 2.5);
    CAPTURE(n, errors);
    CHECK(errors.normal < 1e-12);
    CHECK(errors.tensor < 0.3 * last.tensor);
    CHECK(errors.worst_tensor < 0.3 * last.worst_tensor);
    CHECK(errors.angle < 0.3 * last.angle);
    CHECK(errors.worst_angle < 0.3 * last.worst_angle);
    CHECK(errors.ratio < 0.4 * last.ratio);
    last = errors;
  }
  CHECK(last.tensor < 0.0015);
  CHECK(last.worst_angle < 0.0005);
  CHECK(last.ratio < 0.003);
}

TEST_CASE("curvature_tensors: an ellipsoid has closed-form directions and ratios away from umbilics") {
  const double a = 1.5, b = 1, c = 0.7;
  const auto exact = [&](Vector3 p) {
    return level_set({p.x / (a * a), p.y / (b * b), p.z / (c * c)},
                     AmbientTensor{1 / (a * a), 0, 0, 1 / (b * b), 0, 1 / (c * c)});
  };
  for (const unsigned smoothing : {0u, 3u}) {
    Errors last{1, 1, 1, 1, 1, 1};
    for (const int s : {2, 3, 4}) {
      const Errors errors = errors_of(ellipsoid(s, a, b, c), exact, 1.2, 1, smoothing);
      CAPTURE(s, smoothing);
      CAPTURE(errors);
      CHECK(errors.normal < 0.3 * last.normal);
      CHECK(errors.tensor < 0.5 * last.tensor);
      CHECK((s < 4 || errors.angle < 0.6 * last.angle));
      CHECK((s < 4 || errors.worst_angle < last.worst_angle));
      CHECK(errors.ratio < 0.5 * last.ratio);
      last = errors;
    }
    CHECK(last.tensor < 0.01);
    CHECK(last.angle < 0.003);
    CHECK(last.worst_angle < 0.02);
    CHECK(last.ratio < 0.02);
  }
  // Noise of 0.1 % of the size, a twentieth of the edges: directions stay.
  const Errors raw = errors_of(noisy(ellipsoid(4, a, b, c), 0.002), exact, 1.2, 1, 0);
  const Errors smooth = errors_of(noisy(ellipsoid(4, a, b, c), 0.002), exact, 1.2, 1, 3);
  CAPTURE(raw, smooth);
  CHECK(raw.angle < 0.1);
  CHECK(smooth.angle < 0.02);
  CHECK(smooth.ratio < 0.05);
}

namespace {

// The field at the vertices of the file: log s1, log s2 (in file units over the diagonal) and the primary
// direction in file axes turned back by `back`.
struct FieldRow {
  double first, second;
  Vector3 direction;
};
template <class Back>
std::vector<FieldRow> field_rows(const PolygonMesh& file, const CurvatureFieldParameters& parameters,
                                 const Back& back) {
  const PreparedMesh mesh = prepare_mesh(file);
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  const std::vector<TangentTensor> field = curvature_field(mesh, frames, parameters);
  // Spacings go with 1 / sqrt(curvature): the square root of a length.
  const double unit_log = parameters.adaptive ? 0.5 * std::log(mesh.unit / mesh.diagonal) : 0;
  std::vector<FieldRow> rows(file.vertex_count());
  for (std::size_t h = 0; h < mesh.triangles.size(); ++h) {
    const std::uint32_t v = mesh.triangles[h];
    const TensorAxes axes = tensor_axes(field[v]);
    rows[file.corners[mesh.corner_slot[h]]] = {axes.first + unit_log, axes.second + unit_log,
                                               back(axes.x * frames[v].x + axes.y * frames[v].y)};
  }
  return rows;
}

void check_rows(const std::vector<FieldRow>& a, const std::vector<FieldRow>& b, double margin) {
  REQUIRE(a.size() == b.size());
  double spacing = 0, direction = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    spacing = std::max({spacing, std::abs(a[i].first - b[i].first), std::abs(a[i].second - b[i].second)});
    if (a[i].first - a[i].second > std::log(1.2))
      direction = std::max(direction, norm(cross(a[i].direction, b[i].direction)));
  }
  CHECK(spacing < margin);
  CHECK(direction < margin);
}

}  // namespace

TEST_CASE("curvature_field: invariant to position, rotation, size and numbering") {
  const PolygonMesh file = ellipsoid(3, 1.5, 1, 0.7);
  const PolygonMesh axes = moved(polygon_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {}), 1, 0, 0, 0);
  const auto turned_back = [&](Vector3 v) {
    const auto along = [&](std::size_t k) {
      return dot(v, {axes.x[k] - axes.x[0], axes.y[k] - axes.y[0], axes.z[k] - axes.z[0]});
    };
    return Vector3{along(1), along(2), along(3)};
  };
  const auto same = [](Vector3 v) { return v; };
  for (const bool adaptive : {false, true}) {
    CAPTURE(adaptive);
    CurvatureFieldParameters parameters;
    parameters.adaptive = adaptive;
    const std::vector<FieldRow> base = field_rows(file, parameters, same);
    // The diagonal of the turned box is another one, and with it epsilon: scale it back.
    const PolygonMesh turned = moved(file, 1, 0.5, -1, 2);
    const double diagonal = prepare_mesh(file).diagonal, turned_diagonal = prepare_mesh(turned).diagonal;
    CurvatureFieldParameters other = parameters;
    other.epsilon *= turned_diagonal / diagonal;
    std::vector<FieldRow> rows = field_rows(turned, other, turned_back);
    const double shift = adaptive ? 0.5 * std::log(turned_diagonal / diagonal) : 0;
    for (FieldRow& row : rows) {
      row.first += shift;
      row.second += shift;
    }
    check_rows(base, rows, 1e-8);

    PolygonMesh large = file;
    for (std::size_t i = 0; i < large.x.size(); ++i) {
      large.x[i] *= 3e7;
      large.y[i] *= 3e7;
      large.z[i] *= 3e7;
    }
    check_rows(base, field_rows(large, parameters, same), 1e-8);

    // Vertices and faces in another order.
    std::vector<std::uint32_t> order(file.vertex_count());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::mt19937 random(4);
    std::shuffle(order.begin(), order.end(), random);
    PolygonMesh shuffled = file;
    for (std::size_t i = 0; i < order.size(); ++i) {
      shuffled.x[order[i]] = file.x[i];
      shuffled.y[order[i]] = file.y[i];
      shuffled.z[order[i]] = file.z[i];
    }
    std::vector<std::uint32_t> faces(file.polygon_count());
    for (std::uint32_t i = 0; i < faces.size(); ++i) faces[i] = i;
    std::shuffle(faces.begin(), faces.end(), random);
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k)
        shuffled.corners[3 * f + k] = order[file.corners[3 * faces[f] + (k + f) % 3]];
    const std::vector<FieldRow> mixed = field_rows(shuffled, parameters, same);
    std::vector<FieldRow> sorted(mixed.size());
    for (std::size_t i = 0; i < order.size(); ++i) sorted[i] = mixed[order[i]];
    check_rows(base, sorted, 1e-8);
  }
}

TEST_CASE("curvature_field: flat surfaces are isotropic, float32 rounding included") {
  PolygonMesh file = moved(grid_plane(60, 60), 1, 10, 20, -30);
  for (std::size_t i = 0; i < file.x.size(); ++i) {
    file.x[i] = static_cast<float>(file.x[i]);
    file.y[i] = static_cast<float>(file.y[i]);
    file.z[i] = static_cast<float>(file.z[i]);
  }
  const PreparedMesh mesh = prepare_mesh(file);
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  for (const TangentTensor& tensor : curvature_field(mesh, frames, {})) {
    CHECK(tensor.xx == tensor.yy);
    CHECK(tensor.xy == 0);
  }
  // A strip without inner vertices still has a curvature: the edges of the boundary count.
  PolygonMesh strip = cylinder(40, 1, 0);
  const PreparedMesh narrow = prepare_mesh(strip);
  const std::vector<TangentFrame> planes = vertex_frames(narrow);
  for (const TangentTensor& tensor : curvature_tensors(narrow, planes)) {
    const TensorAxes axes = tensor_axes(tensor);
    CHECK(axes.first / narrow.unit == Approx(1).epsilon(0.01));
  }
}

TEST_CASE("curvature_field: adaptive density follows the curvature, shape-only density is 1") {
  const PreparedMesh mesh = prepare_mesh(torus(96, 48));
  const std::vector<TangentFrame> frames = vertex_frames(mesh);
  CurvatureFieldParameters parameters;
  for (const TangentTensor& tensor : curvature_field(mesh, frames, parameters)) {
    CHECK(trace(tensor) == Approx(0).margin(1e-12));
    const TensorAxes axes = tensor_axes(tensor);
    CHECK(std::exp(axes.first - axes.second) <= 8 * (1 + 1e-12));
  }
  parameters.adaptive = true;
  parameters.smoothing = 0;
  const std::vector<TangentTensor> field = curvature_field(mesh, frames, parameters);
  const double epsilon = parameters.epsilon / mesh.diagonal;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 p = file_position(mesh, v);
    const double r = std::hypot(p.x, p.y), flat = std::abs(r - 1) / 0.4 / r + epsilon, bent = 2.5 + epsilon;
    const double density = std::sqrt(bent * std::max(flat, bent / 64)) * mesh.unit;
    if (flat > 0.05) REQUIRE(std::exp(-trace(field[v])) == Approx(density).epsilon(0.03));
  }
}

TEST_CASE("curvature_field: parameters out of range are named") {
  CurvatureFieldParameters parameters;
  CHECK(validate(parameters).empty());
  parameters.max_ratio = 0.5;
  parameters.epsilon = 0;
  parameters.quantile = 2;
  parameters.smoothing = 65;
  CHECK(validate(parameters).size() == 4);
}
