#include "kernels/analyse/box_discrepancy.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/core/status.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

// Fans of a convex polygon mesh.
double area_in_box(const PolygonMesh& mesh, const RotatedBox& box) {
  return meander::area_in_box(mesh.x, mesh.y, mesh.z, triangles_of(mesh), box);
}

std::vector<RotatedBox> random_boxes(const PolygonMesh& mesh, const BoxParameters& parameters) {
  return meander::random_boxes(mesh.x, mesh.y, mesh.z, triangles_of(mesh), parameters);
}

double total_area(const PolygonMesh& mesh) {
  double area = 0;
  const auto triangles = triangles_of(mesh);
  const auto at = [&](std::size_t corner) {
    const std::uint32_t v = triangles[corner];
    return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
  };
  for (std::size_t t = 0; t < triangles.size(); t += 3) area += triangle_area(at(t), at(t + 1), at(t + 2));
  return area;
}

RotatedBox straight_box(Vector3 center, double hx, double hy, double hz) {
  RotatedBox box;
  box.center = center;
  box.axes = {Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{0, 0, 1}};
  box.half = {hx, hy, hz};
  return box;
}

bool holds(const RotatedBox& box, Vector3 p) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(dot(box.axes[k], p - box.center)) > box.half[k]) return false;
  return true;
}

// The slow way: quarter the triangle until a piece is inside (all corners are; boxes are convex), beyond one
// face, or at the finest depth, where its middle decides.
double area_by_subdivision(const RotatedBox& box, Vector3 a, Vector3 b, Vector3 c, int depth) {
  if (holds(box, a) && holds(box, b) && holds(box, c)) return triangle_area(a, b, c);
  for (std::size_t k = 0; k < 3; ++k) {
    const double qa = dot(box.axes[k], a - box.center), qb = dot(box.axes[k], b - box.center),
                 qc = dot(box.axes[k], c - box.center), h = box.half[k];
    if ((qa > h && qb > h && qc > h) || (qa < -h && qb < -h && qc < -h)) return 0;
  }
  if (depth == 0) return holds(box, (1.0 / 3) * (a + b + c)) ? triangle_area(a, b, c) : 0;
  const Vector3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
  return area_by_subdivision(box, a, ab, ca, depth - 1) + area_by_subdivision(box, ab, b, bc, depth - 1) +
         area_by_subdivision(box, ca, bc, c, depth - 1) + area_by_subdivision(box, bc, ca, ab, depth - 1);
}

double area_by_subdivision(const PolygonMesh& mesh, const RotatedBox& box, int depth) {
  const auto triangles = triangles_of(mesh);
  const auto at = [&](std::size_t corner) {
    const std::uint32_t v = triangles[corner];
    return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
  };
  double area = 0;
  for (std::size_t t = 0; t < triangles.size(); t += 3)
    area += area_by_subdivision(box, at(t), at(t + 1), at(t + 2), depth);
  return area;
}

// Independent uniform points: a triangle by area, a point by the square-root rule.
std::vector<double> random_points(const PolygonMesh& mesh, std::size_t count, std::uint64_t seed) {
  const auto triangles = triangles_of(mesh);
  const auto at = [&](std::size_t corner) {
    const std::uint32_t v = triangles[corner];
    return Vector3{mesh.x[v], mesh.y[v], mesh.z[v]};
  };
  std::vector<double> sums;
  for (std::size_t t = 0; t < triangles.size(); t += 3)
    sums.push_back((sums.empty() ? 0 : sums.back()) + triangle_area(at(t), at(t + 1), at(t + 2)));
  const RandomKey key = make_random_key(seed, {});
  std::vector<double> points;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair first = random_pair(key, Stream::sequence, i),
                   second = random_pair(key, Stream::element_point, i);
    const auto found = std::upper_bound(sums.begin(), sums.end() - 1, first.first * sums.back());
    const auto t = 3 * static_cast<std::size_t>(found - sums.begin());
    const double root = std::sqrt(second.first);
    const Vector3 p =
        (1 - root) * at(t) + (root * (1 - second.second)) * at(t + 1) + (root * second.second) * at(t + 2);
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  return points;
}

}  // namespace

TEST_CASE("area_in_box: a box around everything holds the whole area") {
  for (const PolygonMesh& mesh : {tetrahedron(), cube(), icosphere(3), torus(30, 20)}) {
    RotatedBox box = straight_box({0.1, 0, 0}, 4, 4, 4);
    CHECK(area_in_box(mesh, box) == Approx(total_area(mesh)).epsilon(1e-14));
    box.center = {20, 0, 0};
    CHECK(area_in_box(mesh, box) == 0);
  }
}

TEST_CASE("area_in_box: rectangles cut from a plane") {
  const PolygonMesh plane = grid_plane(7, 5);
  CHECK(area_in_box(plane, straight_box({0.5, 0.5, 0}, 0.25, 0.125, 1)) == Approx(0.125).epsilon(1e-14));
  CHECK(area_in_box(plane, straight_box({0, 0, 0}, 0.3, 0.7, 1e-9)) == Approx(0.21).epsilon(1e-14));
  CHECK(area_in_box(plane, straight_box({0.5, 0.5, 0.2}, 1, 1, 0.1)) == 0);
  // A square turned by 45 degrees whose diagonal is the side of the plane.
  RotatedBox diamond = straight_box({0.5, 0.5, 0}, std::sqrt(0.125), std::sqrt(0.125), 1);
  const double s = std::sqrt(0.5);
  diamond.axes = {Vector3{s, s, 0}, Vector3{-s, s, 0}, Vector3{0, 0, 1}};
  CHECK(area_in_box(plane, diamond) == Approx(0.5).epsilon(1e-14));
}

TEST_CASE("area_in_box: corner of a cube") {
  // A box with half-sizes h at the corner (1, 1, 1) holds three squares of side h.
  const double h = 0.3;
  CHECK(area_in_box(cube(), straight_box({1, 1, 1}, h, h, h)) == Approx(3 * h * h).epsilon(1e-14));
  // All of the top, and the upper tenth of the walls.
  CHECK(area_in_box(cube(), straight_box({0, 0, 1.8}, 5, 5, 1)) == Approx(4 + 8 * 0.2).epsilon(1e-14));
}

TEST_CASE("area_in_box: cap of a sphere") {
  const PolygonMesh sphere = icosphere(5);
  for (const double height : {-0.5, 0.0, 0.3, 0.8}) {
    RotatedBox box = straight_box({0, 0, height + 5}, 5, 5, 5);
    // Edges are at most 0.041 long: the polyhedron lies up to 2e-4 below the sphere, so its area is up to
    // 4e-4 smaller and the cut up to 2e-4 lower, which is 1e-3 of the smallest cap.
    CHECK(area_in_box(sphere, box) == Approx(2 * std::numbers::pi * (1 - height)).epsilon(1.5e-3));
    const PolygonMesh turned = moved(sphere, 1, 0, 0, 0);
    CHECK(area_in_box(turned, box) == Approx(2 * std::numbers::pi * (1 - height)).epsilon(1.5e-3));
  }
}

TEST_CASE("area_in_box: triangles without area and an empty mesh give zero") {
  const PolygonMesh needle = polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0}, {{0, 1, 2}, {0, 0, 1}});
  CHECK(area_in_box(needle, straight_box({0, 0, 0}, 0.5, 0.5, 0.5)) == Approx(0).margin(1e-15));
  CHECK(area_in_box(PolygonMesh{}, straight_box({0, 0, 0}, 1, 1, 1)) == 0);
}

TEST_CASE("area_in_box: a triangle in a face of the box counts once on either side") {
  // Points on a face of the box are inside, so a triangle in the face of two touching boxes is in both.
  const PolygonMesh plane = grid_plane(1, 1);
  CHECK(area_in_box(plane, straight_box({0.5, 0.5, 1}, 1, 1, 1)) == Approx(1));
  CHECK(area_in_box(plane, straight_box({0.5, 0.5, -1}, 1, 1, 1)) == Approx(1));
}

TEST_CASE("area_in_box: rotated boxes agree with fine subdivision") {
  const PolygonMesh mesh = icosphere(1);
  BoxParameters parameters;
  parameters.boxes = 20;
  for (const RotatedBox& box : random_boxes(mesh, parameters)) {
    const double exact = area_in_box(mesh, box);
    // At depth 8 a piece has an edge of 0.0025; the boundary in the surface is shorter than 12.
    CHECK(area_by_subdivision(mesh, box, 8) == Approx(exact).margin(2e-3));
    CHECK(box.share == Approx(exact / total_area(mesh)).epsilon(1e-12));
  }
}

TEST_CASE("area_in_box: the parts of a split box add up") {
  const PolygonMesh mesh = torus(40, 24);
  BoxParameters parameters;
  parameters.boxes = 50;
  for (const RotatedBox& box : random_boxes(mesh, parameters)) {
    const double whole = area_in_box(mesh, box);
    for (std::size_t k = 0; k < 3; ++k) {
      RotatedBox low = box, high = box;
      const double at = 0.3 * box.half[k];  // where the box is cut, from its center
      low.half[k] = 0.5 * (box.half[k] + at);
      low.center = box.center + (at - low.half[k]) * box.axes[k];
      high.half[k] = 0.5 * (box.half[k] - at);
      high.center = box.center + (at + high.half[k]) * box.axes[k];
      CHECK(area_in_box(mesh, low) + area_in_box(mesh, high) == Approx(whole).epsilon(1e-12));
    }
  }
}

TEST_CASE("area_in_box: invariant to rigid motion, and scales with the unit") {
  const PolygonMesh mesh = torus(20, 12);
  const PolygonMesh scaled = moved(mesh, 1e6, 0, 0, 0);
  const PolygonMesh turned = moved(mesh, 1, 0, 0, 0);
  const auto turn = [](Vector3 v) {
    const PolygonMesh point = moved(polygon_mesh({v.x, v.y, v.z}, {}), 1, 0, 0, 0);
    return Vector3{point.x[0], point.y[0], point.z[0]};
  };
  BoxParameters parameters;
  parameters.boxes = 30;
  for (const RotatedBox& box : random_boxes(mesh, parameters)) {
    RotatedBox moved_box = box;
    moved_box.center = turn(box.center);
    for (Vector3& axis : moved_box.axes) axis = turn(axis);
    const double area = area_in_box(mesh, box);
    CHECK(area_in_box(turned, moved_box) == Approx(area).epsilon(1e-12));
    for (double& half : moved_box.half) half *= 1e6;
    moved_box.center = 1e6 * moved_box.center;
    CHECK(area_in_box(scaled, moved_box) == Approx(1e12 * area).epsilon(1e-12));
  }
}

TEST_CASE("random_boxes: follow their distribution") {
  const PolygonMesh mesh = moved(torus(40, 24), 3, 10, -4, 2);
  BoxParameters parameters;
  const auto boxes = random_boxes(mesh, parameters);
  REQUIRE(boxes.size() == parameters.boxes);
  std::array<double, 2> range[3] = {{1e300, -1e300}, {1e300, -1e300}, {1e300, -1e300}};
  for (std::size_t i = 0; i < mesh.x.size(); ++i) {
    const double p[3] = {mesh.x[i], mesh.y[i], mesh.z[i]};
    for (int k = 0; k < 3; ++k) range[k] = {std::min(range[k][0], p[k]), std::max(range[k][1], p[k])};
  }
  const double diagonal =
      std::hypot(range[0][1] - range[0][0], range[1][1] - range[1][0], range[2][1] - range[2][0]);
  double mean_cosine = 0;
  for (const RotatedBox& box : boxes) {
    CHECK(box.share >= parameters.share_min);
    CHECK(box.share <= parameters.share_max);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(box.half[k] >= diagonal * 0.03 * (1 - 1e-12));
      CHECK(box.half[k] <= diagonal * 0.35 * (1 + 1e-12));
      CHECK(dot(box.axes[k], box.axes[k]) == Approx(1).epsilon(1e-12));
      CHECK(dot(box.axes[k], box.axes[(k + 1) % 3]) == Approx(0).margin(1e-12));
    }
    CHECK(dot(cross(box.axes[0], box.axes[1]), box.axes[2]) == Approx(1));
    mean_cosine += box.axes[0].x * box.axes[0].x / static_cast<double>(boxes.size());
  }
  // E[cos^2] = 1/3 for a uniform rotation, standard deviation sqrt(4/45/1000) = 0.0094. (Boxes are kept by
  // their share, which hardly depends on the rotation.)
  CHECK(mean_cosine == Approx(1.0 / 3).margin(4 * 0.0094));
}

TEST_CASE("random_boxes: pure in the seed, fewer boxes are a prefix") {
  const PolygonMesh mesh = icosphere(2);
  BoxParameters parameters;
  parameters.boxes = 40;
  const auto first = random_boxes(mesh, parameters), again = random_boxes(mesh, parameters);
  parameters.boxes = 15;
  const auto fewer = random_boxes(mesh, parameters);
  parameters.seed = 2;
  const auto other = random_boxes(mesh, parameters);
  REQUIRE(first.size() == 40);
  REQUIRE(fewer.size() == 15);
  for (std::size_t i = 0; i < 40; ++i) {
    CHECK(first[i].share == again[i].share);
    CHECK(first[i].half == again[i].half);
    if (i >= 15) continue;
    CHECK(first[i].half == fewer[i].half);
    CHECK(first[i].half != other[i].half);
  }
}

TEST_CASE("random_boxes: no area is an error, area in one spot gives no box") {
  const PolygonMesh needle = polygon_mesh({0, 0, 0, 1, 0, 0, 2, 0, 0}, {{0, 1, 2}});
  CHECK_THROWS_AS(random_boxes(needle, {}), ItemError);
  CHECK_THROWS_AS(random_boxes(PolygonMesh{}, {}), ItemError);
  // All the area within 1e-6 of one point and a needle far away: every box holds all or next to nothing.
  const PolygonMesh spot = polygon_mesh({0, 0, 0, 1e-6, 0, 0, 0, 1e-6, 0, 5, 0, 0}, {{0, 1, 2}, {0, 3, 3}});
  BoxParameters parameters;
  parameters.boxes = 4;
  CHECK(random_boxes(spot, parameters).empty());
}

TEST_CASE("box_error_ratio: equals direct counting") {
  const PolygonMesh mesh = icosphere(2);
  BoxParameters parameters;
  parameters.boxes = 200;
  const auto boxes = random_boxes(mesh, parameters);
  for (const std::size_t n :
       {std::size_t{1}, std::size_t{15}, std::size_t{16}, std::size_t{17}, std::size_t{3000}}) {
    const auto points = random_points(mesh, n, n);
    double squared = 0, variance = 0;
    for (const RotatedBox& box : boxes) {
      double count = 0;
      for (std::size_t i = 0; i < n; ++i)
        count += holds(box, {points[3 * i], points[3 * i + 1], points[3 * i + 2]});
      squared += std::pow(count / static_cast<double>(n) - box.share, 2);
      variance += box.share * (1 - box.share) / static_cast<double>(n);
    }
    CHECK(box_error_ratio(boxes, points) == Approx(std::sqrt(squared / variance)).epsilon(1e-12));
  }
}

TEST_CASE("box_error_ratio: random points score one") {
  const PolygonMesh mesh = torus(40, 24);
  const auto boxes = random_boxes(mesh, {});
  constexpr int sets = 40;
  double mean_square = 0, mean_fourth = 0;
  for (int seed = 0; seed < sets; ++seed) {
    const double ratio =
        box_error_ratio(boxes, random_points(mesh, 1000, 100 + static_cast<std::uint64_t>(seed)));
    mean_square += ratio * ratio / sets;
    mean_fourth += std::pow(ratio, 4) / sets;
  }
  // The square of the ratio has expectation exactly one; its noise is measured from the sets themselves.
  const double noise = std::sqrt((mean_fourth - mean_square * mean_square) / sets);
  CAPTURE(noise);
  CHECK(noise < 0.06);
  CHECK(mean_square == Approx(1).margin(4 * noise));
}

TEST_CASE("box_error_ratio: a regular grid on a plane scores far below one") {
  const PolygonMesh plane = grid_plane(4, 4);
  const auto boxes = random_boxes(plane, {});
  std::vector<double> points;
  for (int j = 0; j < 64; ++j)
    for (int i = 0; i < 64; ++i) points.insert(points.end(), {(i + 0.5) / 64, (j + 0.5) / 64, 0});
  CHECK(box_error_ratio(boxes, points) < 0.25);
  // Half of the plane left out: much worse than random.
  CHECK(box_error_ratio(boxes, std::span(points).first(points.size() / 2)) > 5);
}

TEST_CASE("box_error_ratio: nothing to measure is an error") {
  const auto boxes = random_boxes(cube(), {});
  const std::vector<double> none, one{0, 0, 1};
  CHECK_THROWS_AS(box_error_ratio(boxes, none), std::invalid_argument);
  CHECK_THROWS_AS(box_error_ratio({}, one), std::invalid_argument);
}

TEST_CASE("box_errors: signed, with the root mean square that box_error_ratio uses") {
  const PolygonMesh mesh = grid_plane(4, 4);
  BoxParameters parameters;
  parameters.boxes = 50;
  const std::vector<RotatedBox> boxes = random_boxes(mesh, parameters);
  std::vector<double> points;
  const RandomKey key = make_random_key(9, {});
  for (std::size_t i = 0; i < 200; ++i) {
    const UnitPair p = random_pair(key, Stream::point_set, i);
    points.insert(points.end(), {p.first, p.second, 0});
  }
  const std::vector<double> errors = box_errors(boxes, points);
  double squared = 0, variance = 0;
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    double inside = 0;
    for (std::size_t i = 0; i < points.size(); i += 3)
      inside += holds(boxes[b], {points[i], points[i + 1], points[i + 2]});
    CHECK(errors[b] == Approx(inside / 200 - boxes[b].share).margin(1e-15));
    squared += errors[b] * errors[b];
    variance += boxes[b].share * (1 - boxes[b].share) / 200;
  }
  CHECK(box_error_ratio(boxes, points) == Approx(std::sqrt(squared / variance)));
}

TEST_CASE("BoxBias: zero for independent errors, one for constant errors") {
  const RandomKey key = make_random_key(4, {});
  BoxBias none, half, all;
  constexpr std::size_t boxes = 300, sets = 400;
  for (std::size_t s = 0; s < sets; ++s) {
    std::vector<double> errors(boxes);
    for (std::size_t b = 0; b < boxes; ++b)
      errors[b] = random_pair(key, Stream::sequence, s * boxes + b).first - 0.5;
    none.add(errors);
    // As large as the deviation of what is random: half of the square is bias.
    for (std::size_t b = 0; b < boxes; ++b) errors[b] += (b % 2 == 0 ? 1 : -1) / std::sqrt(12.0);
    half.add(errors);
    for (std::size_t b = 0; b < boxes; ++b) errors[b] = b % 3 == 0 ? 0.1 : -0.2;
    all.add(errors);
  }
  CHECK(none.ratio() < 0.03);
  CHECK(half.ratio() == Approx(std::sqrt(0.5)).epsilon(0.02));
  CHECK(all.ratio() == Approx(1));
  CHECK_THROWS_AS(all.add(std::vector<double>(boxes + 1)), std::invalid_argument);
}
