#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/discrepancy_plane.h"
#include "kernels/analyse/discrepancy_rings.h"
#include "kernels/analyse/discrepancy_sphere.h"
#include "kernels/analyse/discrepancy_star.h"
#include "kernels/core/random.h"
#include "kernels/core/vector3.h"
#include "kernels/pointset/planar_points.h"
#include "kernels/pointset/sphere_points.h"
#include "support/catch.h"
#include "support/test_meshes.h"

using namespace meander;

namespace {

PointIndex<2> index_of(const PlanarPoints& points) { return build_point_index(points.x, points.y); }

// The definition: every corner made of coordinates and 1, open and closed, every point looked at. O(N^3).
double star_by_definition(const PlanarPoints& points) {
  std::vector<double> xs = points.x, ys = points.y;
  xs.push_back(1);
  ys.push_back(1);
  const auto n = static_cast<double>(points.count());
  double most = 0;
  for (const double a : xs)
    for (const double b : ys) {
      int open = 0, closed = 0;
      for (std::size_t i = 0; i < points.count(); ++i) {
        open += points.x[i] < a && points.y[i] < b;
        closed += points.x[i] <= a && points.y[i] <= b;
      }
      most = std::max({most, a * b - open / n, closed / n - a * b});
    }
  return most;
}

ShapeParameters exactly(std::uint32_t shapes, std::uint64_t seed = 1) {
  ShapeParameters parameters;
  parameters.shapes = shapes;
  parameters.seed = seed;
  parameters.stable_rise = 0;
  return parameters;
}

// Middles of the cells of a fine grid: any convex shape's count is its area x N up to its perimeter.
PlanarPoints fine_grid(int side) {
  PlanarPoints points;
  for (int v = 0; v < side; ++v)
    for (int u = 0; u < side; ++u) {
      points.x.push_back((u + 0.5) / side);
      points.y.push_back((v + 0.5) / side);
    }
  return points;
}

Vector3 documented_direction(std::uint64_t seed, std::uint32_t number, std::uint32_t draw) {
  const UnitPair u = random_pair(make_random_key(seed, {}), Stream::test_shapes, number, draw);
  const double z = 1 - 2 * u.second, r = std::sqrt(1 - z * z), angle = 2 * std::numbers::pi * u.first;
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace

TEST_CASE("star_discrepancy_exact: equals the definition, also for equal coordinates") {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    PlanarPoints points = planar_points(PlanarMethod::random, 1 + static_cast<std::uint32_t>(seed), seed);
    CHECK(star_discrepancy_exact(points.x, points.y) == Approx(star_by_definition(points)).epsilon(1e-13));
    for (auto* w : {&points.x, &points.y})  // rounded to eighths, 0 and 1 included
      for (double& c : *w) c = std::round(8 * c) / 8;
    CHECK(star_discrepancy_exact(points.x, points.y) == Approx(star_by_definition(points)).epsilon(1e-13));
  }
}

TEST_CASE("star_discrepancy_exact: one point, equal points, centered grids") {
  for (const auto& [a, b] : {std::pair{0.3, 0.8}, {0.5, 0.5}, {0.9, 0.95}, {0.0, 0.0}, {1.0, 1.0}}) {
    const std::vector<double> x = {a}, y = {b};
    CHECK(star_discrepancy_exact(x, y) == Approx(std::max({a, b, 1 - a * b})));
    const std::vector<double> xs(700, a), ys(700, b);
    CHECK(star_discrepancy_exact(xs, ys) == Approx(std::max({a, b, 1 - a * b})));
  }
  for (const int side : {1, 2, 5, 32}) {  // more than one block of columns for 32 x 32
    const PlanarPoints grid = fine_grid(side);
    const double inner = 1 - 0.5 / side;
    CHECK(star_discrepancy_exact(grid.x, grid.y) == Approx(1 - inner * inner));
  }
  CHECK_THROWS_AS(star_discrepancy_exact({}, {}), std::invalid_argument);
}

TEST_CASE("star_discrepancy_exact: blocks of columns do not matter") {
  // The transposed set has other columns and the same discrepancy; the order of the points does not matter.
  const PlanarPoints points = planar_points(PlanarMethod::jittered, 3000, 2);
  const double d = star_discrepancy_exact(points.x, points.y);
  CHECK(star_discrepancy_exact(points.y, points.x) == Approx(d).epsilon(1e-13));
  const std::vector<double> x(points.x.rbegin(), points.x.rend()), y(points.y.rbegin(), points.y.rend());
  CHECK(star_discrepancy_exact(x, y) == d);
}

TEST_CASE("star_discrepancy_search: a close lower bound of the exact value") {
  for (const PlanarMethod method : {PlanarMethod::random, PlanarMethod::hilbert_stratified,
                                    PlanarMethod::hammersley, PlanarMethod::sobol_owen}) {
    INFO(name_of(method));
    const PlanarPoints points = planar_points(method, 1024, 3);
    const double exact = star_discrepancy_exact(points.x, points.y);
    StarSearchParameters parameters;
    parameters.boxes = 4096;
    const double found = star_discrepancy_search(points.x, points.y, parameters);
    CHECK(found <= exact * (1 + 1e-12));
    CHECK(found >= 0.9 * exact);
  }
  const std::vector<double> x = {0.3}, y = {0.8};
  CHECK(star_discrepancy_search(x, y) == Approx(0.8));
  StarSearchParameters none;
  none.boxes = 0;
  CHECK_THROWS_AS(star_discrepancy_search(x, y, none), std::invalid_argument);
}

TEST_CASE("quarter_circle_discrepancy: closed forms and the definition") {
  const double quarter = std::numbers::pi / 4;
  const std::vector<double> x = {0.6}, y = {0.2}, far = {0.9};
  CHECK(quarter_circle_discrepancy(x, y) == Approx(std::max(quarter * 0.4, 1 - quarter * 0.4)));
  CHECK(quarter_circle_discrepancy(far, far) == Approx(quarter));
  const PlanarPoints points = planar_points(PlanarMethod::random, 200, 1);
  double most = 0;
  for (int k = 0; k <= 20000; ++k) {
    const double r = k / 20000.0;
    int inside = 0;
    for (std::size_t i = 0; i < 200; ++i) inside += std::hypot(points.x[i], points.y[i]) <= r;
    most = std::max(most, std::abs(inside / 200.0 - quarter * r * r));
  }
  const double d = quarter_circle_discrepancy(points.x, points.y);
  CHECK(most <= d + 1e-12);
  CHECK(most > d - 1e-4);  // radii of the scan are 5e-5 apart
}

TEST_CASE("count_inside: equals a loop over the points, in the plane and in space") {
  const RandomKey key = make_random_key(5, {});
  for (const std::uint32_t count : {1u, 15u, 16u, 17u, 64u, 65u, 1000u, 5000u}) {
    PlanarPoints flat = planar_points(PlanarMethod::hilbert_stratified, count, 1);
    if (count == 1000)  // on a lattice, so that points lie on faces
      for (std::size_t i = 0; i < count; ++i) {
        flat.x[i] = std::floor(32 * flat.x[i]) / 32;
        flat.y[i] = std::floor(32 * flat.y[i]) / 32;
      }
    const PointIndex<2> plane = index_of(flat);
    const SpherePoints round = sphere_points(SphereMethod::random, count, 1);
    const PointIndex<3> space = build_point_index(round.x, round.y, round.z);
    for (std::uint32_t shape = 0; shape < 60; ++shape) {
      std::vector<HalfSpace<2>> lines;
      std::vector<HalfSpace<3>> planes;
      for (std::uint32_t s = 0; s < shape % 5; ++s) {
        const UnitPair u = random_pair(key, Stream::test_shapes, shape, s),
                       w = random_pair(key, Stream::test_shapes, shape, 100 + s);
        const double angle = 2 * std::numbers::pi * u.first;
        lines.push_back({{std::cos(angle), std::sin(angle)}, 1.4 * u.second - 0.2});
        if (shape % 3 == 0) lines.back() = {{s % 2 == 0 ? 1.0 : 0.0, s % 2 == 0 ? 0.0 : 1.0}, 0.5};
        const double z = 1 - 2 * w.first, r = std::sqrt(1 - z * z);
        planes.push_back({{r * std::cos(angle), r * std::sin(angle), z}, 1.5 * w.second - 0.4});
      }
      std::size_t in_plane = 0, in_space = 0;
      for (std::size_t i = 0; i < count; ++i) {
        in_plane += std::all_of(lines.begin(), lines.end(), [&](const HalfSpace<2>& h) {
          return contains<2>(h, {flat.x[i], flat.y[i]});
        });
        in_space += std::all_of(planes.begin(), planes.end(), [&](const HalfSpace<3>& h) {
          return contains<3>(h, {round.x[i], round.y[i], round.z[i]});
        });
      }
      CHECK(count_inside(plane, lines) == in_plane);
      CHECK(count_inside(space, planes) == in_space);
    }
  }
  CHECK(count_inside(build_point_index({}, {}), {}) == 0);
  CHECK_THROWS_AS(count_inside(index_of(fine_grid(2)), std::vector<HalfSpace<2>>(9)), std::invalid_argument);
}

TEST_CASE("triangle_discrepancy: the shapes by hand") {
  const PlanarPoints points = planar_points(PlanarMethod::random, 500, 4);
  const std::uint32_t shapes = 300;
  double most = 0;
  for (std::uint32_t t = 0; t < shapes; ++t) {
    const RandomKey key = make_random_key(9, {});
    const UnitPair a = random_pair(key, Stream::test_shapes, t, 0),
                   b = random_pair(key, Stream::test_shapes, t, 1);
    const double doubled = a.first * b.second - b.first * a.second;
    int inside = 0;
    for (std::size_t i = 0; i < points.count(); ++i) {  // barycentric coordinates
      const double p = (points.x[i] * b.second - b.first * points.y[i]) / doubled;
      const double q = (a.first * points.y[i] - points.x[i] * a.second) / doubled;
      inside += p >= 0 && q >= 0 && p + q <= 1;
    }
    most = std::max(most, std::abs(inside / 500.0 - 0.5 * std::abs(doubled)));
  }
  const ShapeDiscrepancy result = triangle_discrepancy(index_of(points), exactly(shapes, 9));
  CHECK(result.discrepancy == Approx(most).epsilon(1e-12));
  CHECK(result.shapes == shapes);
}

TEST_CASE("planar shapes: areas match a fine grid") {
  // The number of cells that a convex boundary of length at most 4 meets bounds the error: with side 400
  // below 4 x 1.3 / 400; in fact far less. A wrong area, or one not cut by the square, would be 0.05 off.
  const PointIndex<2> grid = index_of(fine_grid(400));
  CHECK(triangle_discrepancy(grid, exactly(1024)).discrepancy < 0.004);
  CHECK(rotated_box_discrepancy(grid, exactly(1024)).discrepancy < 0.004);
  CHECK(metric_box_discrepancy(grid, {1, 0, 1}, exactly(1024)).discrepancy < 0.004);
  CHECK(metric_box_discrepancy(grid, {5, 2, 1.5}, exactly(1024)).discrepancy < 0.004);
  CHECK(density_box_discrepancy(grid, PlanarDensity::uniform, exactly(1024)).discrepancy < 0.004);
  // All measures detect an empty half of the square.
  PlanarPoints half = fine_grid(100);
  for (double& x : half.x) x *= 0.5;
  const PointIndex<2> left = index_of(half);
  CHECK(triangle_discrepancy(left, exactly(1024)).discrepancy > 0.2);
  CHECK(rotated_box_discrepancy(left, exactly(1024)).discrepancy > 0.3);
  CHECK(metric_box_discrepancy(left, {5, 2, 1.5}, exactly(1024)).discrepancy > 0.3);
}

TEST_CASE("metric_box_discrepancy: only the shape of the metric matters") {
  const PointIndex<2> points = index_of(planar_points(PlanarMethod::random, 2000, 1));
  const double d = metric_box_discrepancy(points, {5, 2, 1.5}, exactly(500)).discrepancy;
  CHECK(metric_box_discrepancy(points, {50, 20, 15}, exactly(500)).discrepancy == Approx(d).epsilon(1e-9));
  CHECK(metric_box_discrepancy(points, {1, 0, 1}, exactly(500)).discrepancy != Approx(d).epsilon(1e-9));
  CHECK_THROWS_AS(metric_box_discrepancy(points, {1, 2, 1}), std::invalid_argument);
  CHECK_THROWS_AS(metric_box_discrepancy(points, {-1, 0, -1}), std::invalid_argument);
}

TEST_CASE("metric_box_discrepancy: boxes are long along the axis of short lengths") {
  // g = (100, 0, 0.01): distances along x count a hundred-fold. Rectangles are at most 0.1 / 2 wide, so rows
  // of points along y show, and rows along x do not.
  PlanarPoints rows;
  for (int i = 0; i < 20000; ++i) {
    rows.x.push_back((i % 20 + 0.5) / 20);
    rows.y.push_back((i / 20 + 0.5) / 1000);
  }
  const PlanarMetric metric = {100, 0, 0.01};
  const double across = metric_box_discrepancy(index_of(rows), metric, exactly(1000)).discrepancy;
  std::swap(rows.x, rows.y);
  const double along = metric_box_discrepancy(index_of(rows), metric, exactly(1000)).discrepancy;
  CHECK(across > 0.035);
  CHECK(along < 0.005);
}

TEST_CASE("shape discrepancies: shapes are a prefix, and a function of the seed alone") {
  const PointIndex<2> points = index_of(planar_points(PlanarMethod::jittered, 900, 1));
  const ShapeDiscrepancy few = rotated_box_discrepancy(points, exactly(700)),
                         many = rotated_box_discrepancy(points, exactly(2000));
  REQUIRE(few.running_max.size() == 3);
  REQUIRE(many.running_max.size() == 8);
  CHECK(few.running_max[1] == many.running_max[1]);
  CHECK(few.discrepancy <= many.discrepancy);
  CHECK(std::is_sorted(many.running_max.begin(), many.running_max.end()));
  CHECK(rotated_box_discrepancy(points, exactly(700, 2)).discrepancy != few.discrepancy);
  CHECK_THROWS_AS(rotated_box_discrepancy(build_point_index({}, {}), exactly(5)), std::invalid_argument);
}

TEST_CASE("shape discrepancies: the stopping rule") {
  ShapeParameters parameters;
  CHECK(stable_after({1, 1.005, 1.01, 1.015, 1.02, 5}, parameters) == 5);
  CHECK(stable_after({1, 1.02, 1.02, 1.02, 1.04, 1.04}, parameters) == 0);
  CHECK(stable_after({1, 1, 1, 1}, parameters) == 0);
  const PointIndex<2> points = index_of(planar_points(PlanarMethod::random, 1000, 1));
  const ShapeDiscrepancy stopped = triangle_discrepancy(points);
  CHECK(stopped.stable);
  CHECK(stopped.shapes < parameters.shapes);
  CHECK(stopped.shapes == shape_batch * stopped.running_max.size());
  const ShapeDiscrepancy full = triangle_discrepancy(points, exactly(parameters.shapes));
  CHECK(!full.stable);
  CHECK(shape_batch * stable_after(full.running_max, parameters) == stopped.shapes);
  CHECK(full.running_max[stopped.running_max.size() - 1] == stopped.discrepancy);
}

TEST_CASE("box_share: equals a midpoint sum of the density") {
  for (std::size_t d = 0; d < planar_density_names.size(); ++d) {
    const auto density = static_cast<PlanarDensity>(d);
    INFO(name_of(density));
    CHECK(planar_density(name_of(density)) == density);
    const auto midpoint = [&](double a, double b) {
      constexpr int side = 300;
      double sum = 0;
      for (int v = 0; v < side; ++v)
        for (int u = 0; u < side; ++u) sum += density_at(density, a * (u + 0.5) / side, b * (v + 0.5) / side);
      return sum * a * b / (side * side);
    };
    const double whole = midpoint(1, 1);
    // Error of the midpoint rule: (a / 300)^2 / 24 x second derivative (at most 100 here) < 5e-5.
    for (const auto& [a, b] : {std::pair{1.0, 1.0}, {0.3, 0.9}, {0.75, 0.5}, {0.02, 1.0}})
      CHECK(box_share(density, a, b) == Approx(midpoint(a, b) / whole).margin(5e-5));
    CHECK(box_share(density, 0, 0.5) == Approx(0).margin(1e-15));
    CHECK(box_share(density, 0.5, 0) == Approx(0).margin(1e-15));
    CHECK(box_share(density, 1, 1) == Approx(1).epsilon(1e-14));
  }
  CHECK(box_share(PlanarDensity::squares, 0.5, 0.25) == Approx(1.0 / 8 / 64));
  // The density that is a function of the product is symmetric, though its quadrature is not: an independent
  // check at full precision.
  CHECK(box_share(PlanarDensity::product_wave, 0.9, 0.4) ==
        Approx(box_share(PlanarDensity::product_wave, 0.4, 0.9)).epsilon(1e-13));
  CHECK(!planar_density("x2y2").has_value());
}

TEST_CASE("density_box_discrepancy: tells points that follow a density from those that do not") {
  for (const PlanarDensity density :
       {PlanarDensity::squares, PlanarDensity::waves, PlanarDensity::product_wave}) {
    INFO(name_of(density));
    const RandomKey key = make_random_key(6, {});
    PlanarPoints points;
    for (std::uint64_t i = 0; points.count() < 40000; ++i) {  // rejection
      const UnitPair p = random_pair(key, Stream::point_set, i);
      if (2 * random_pair(key, Stream::point_set, i, 1).first < density_at(density, p.first, p.second)) {
        points.x.push_back(p.first);
        points.y.push_back(p.second);
      }
    }
    const PointIndex<2> index = index_of(points);
    // The star discrepancy of random points is above 2 / sqrt(N) in few of a hundred cases.
    CHECK(density_box_discrepancy(index, density, exactly(1000)).discrepancy < 2.0 / 200);
    CHECK(density_box_discrepancy(index, PlanarDensity::uniform, exactly(1000)).discrepancy > 0.02);
  }
}

TEST_CASE("cap_discrepancy: equals sorting the heights, axis by axis") {
  for (std::size_t m = 0; m < sphere_method_names.size(); ++m)
    for (const std::uint32_t count : {1u, 2u, 50u, 3000u}) {
      INFO(sphere_method_names[m] << " " << count);
      const SpherePoints points = sphere_points(static_cast<SphereMethod>(m), count, 2);
      double most = 0;
      for (std::uint32_t axis = 0; axis < 300; ++axis) {
        const Vector3 a = documented_direction(3, axis, 0);
        std::vector<double> heights;
        for (std::size_t i = 0; i < count; ++i)
          heights.push_back(dot(a, {points.x[i], points.y[i], points.z[i]}));
        std::sort(heights.begin(), heights.end());
        for (std::size_t k = 0; k < count; ++k) {
          const double share = 0.5 * (1 + heights[k]);
          most = std::max(
              {most, share - static_cast<double>(k) / count, static_cast<double>(k + 1) / count - share});
        }
      }
      const ShapeDiscrepancy result = cap_discrepancy(points.x, points.y, points.z, exactly(300, 3));
      CHECK(result.discrepancy == Approx(most).epsilon(1e-10));
      CHECK(result.shapes == 300);
    }
  CHECK_THROWS_AS(cap_discrepancy({}, {}, {}, exactly(1)), std::invalid_argument);
}

TEST_CASE("cap_discrepancy: follows Kolmogorov's law for random points") {
  // One axis: the heights of random points are uniform, so sqrt(N) D follows Kolmogorov's distribution, mean
  // sqrt(pi / 2) ln 2, after Stephens' correction for finite N; 500 sets: standard error 0.26 / sqrt(500).
  const double n = 400;
  double mean = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    const SpherePoints points = sphere_points(SphereMethod::random, 400, seed);
    mean += cap_discrepancy(points.x, points.y, points.z, exactly(1, seed)).discrepancy / 500;
  }
  mean *= std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n);
  CHECK(std::abs(mean - std::sqrt(std::numbers::pi / 2) * std::numbers::ln2) < 4 * 0.26 / std::sqrt(500.0));
}

TEST_CASE("spherical_triangle_discrepancy: areas match a dense set, and by hand") {
  const SpherePoints dense = sphere_points(SphereMethod::fibonacci, 100000, 1);
  CHECK(spherical_triangle_discrepancy(build_point_index(dense.x, dense.y, dense.z), exactly(1000))
            .discrepancy < 5e-4);
  const SpherePoints points = sphere_points(SphereMethod::random, 300, 1);
  double most = 0;
  for (std::uint32_t t = 0; t < 300; ++t) {
    const Vector3 a = documented_direction(5, t, 0), b = documented_direction(5, t, 1),
                  c = documented_direction(5, t, 2);
    const double sign = dot(a, cross(b, c)) < 0 ? -1 : 1;
    int inside = 0;
    for (std::size_t i = 0; i < 300; ++i) {
      const Vector3 p{points.x[i], points.y[i], points.z[i]};
      inside += sign * dot(cross(a, b), p) >= 0 && sign * dot(cross(b, c), p) >= 0 &&
                sign * dot(cross(c, a), p) >= 0;
    }
    // Girard: the excess of the angles between the planes of the sides.
    const auto angle = [](Vector3 at, Vector3 to, Vector3 from) {
      const Vector3 m = cross(at, to), n = cross(at, from);
      return std::acos(std::clamp(dot(m, n) / (norm(m) * norm(n)), -1.0, 1.0));
    };
    const double excess = angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - std::numbers::pi;
    most = std::max(most, std::abs(inside / 300.0 - excess / (4 * std::numbers::pi)));
  }
  CHECK(spherical_triangle_discrepancy(build_point_index(points.x, points.y, points.z), exactly(300, 5))
            .discrepancy == Approx(most).epsilon(1e-9));
}

TEST_CASE("ring_discrepancy: patches of a strip by hand") {
  // A strip of 6 unit squares, cut: vertices 0 .. 6 below, 7 .. 13 above; triangles 2 i and 2 i + 1.
  std::vector<std::uint32_t> triangles;
  for (std::uint32_t i = 0; i < 6; ++i) triangles.insert(triangles.end(), {i, i + 1, i + 8, i, i + 8, i + 7});
  const VertexTriangles around = triangles_around_vertices(triangles, 14);
  REQUIRE(around.begin.size() == 15);
  CHECK(around.begin[1] - around.begin[0] == 2);
  CHECK(around.begin[4] - around.begin[3] == 3);
  const std::vector<double> areas(12, 0.5);
  std::vector<std::uint32_t> counts(12, 3);
  const std::vector<std::uint32_t> first = {0}, last = {13}, both = {0, 13};
  // Counts in proportion to the area: no discrepancy.
  CHECK(ring_discrepancy(triangles, around, areas, counts, both).discrepancy == Approx(0).margin(1e-15));
  // All samples in the square at vertex 0. Ring 1 of vertex 0 is this square: 1 - 1/6.
  counts.assign(12, 0);
  counts[0] = 4;
  CHECK(ring_discrepancy(triangles, around, areas, counts, first).discrepancy == Approx(5.0 / 6));
  // Ring k is k squares from either end. All samples in the third square: from vertex 13 three squares
  // without a sample, from vertex 0 three with all of them.
  counts.assign(12, 0);
  counts[4] = 7;
  CHECK(ring_discrepancy(triangles, around, areas, counts, first).discrepancy == Approx(0.5));
  CHECK(ring_discrepancy(triangles, around, areas, counts, last).discrepancy == Approx(0.5));
  counts[2] = 7;  // half of them in the second: 1 - 3/6 from vertex 0, 3/6 from 13 (then 1/2 of them in 4/6)
  CHECK(ring_discrepancy(triangles, around, areas, counts, first).discrepancy == Approx(0.5));
  counts[4] = 0;  // all in the second: 1 - 2/6 and 4/6
  CHECK(ring_discrepancy(triangles, around, areas, counts, first).discrepancy == Approx(2.0 / 3));
  const ShapeDiscrepancy result = ring_discrepancy(triangles, around, areas, counts, both);
  CHECK(result.discrepancy == Approx(2.0 / 3));
  CHECK(result.shapes == 2);
  CHECK_THROWS_AS(ring_discrepancy(triangles, around, areas, std::vector<std::uint32_t>(12, 0), both),
                  std::invalid_argument);
  CHECK_THROWS_AS(ring_discrepancy(triangles, around, areas, counts, std::vector<std::uint32_t>{14}),
                  std::invalid_argument);
  CHECK_THROWS_AS(triangles_around_vertices(triangles, 13), std::invalid_argument);
}

TEST_CASE("ring_discrepancy: rings are graph distances, and end with the component") {
  const PolygonMesh mesh = test::icosphere(3);
  std::vector<std::uint32_t> triangles = mesh.corners;
  const auto vertices = static_cast<std::uint32_t>(mesh.x.size());
  const std::size_t one = triangles.size();
  for (std::size_t i = 0; i < one; ++i) triangles.push_back(triangles[i] + vertices);  // a second sphere
  const VertexTriangles around = triangles_around_vertices(triangles, 2 * vertices);
  const std::size_t count = triangles.size() / 3;
  std::vector<double> measure(count);
  std::vector<std::uint32_t> counts(count);
  const RandomKey key = make_random_key(2, {});
  for (std::size_t t = 0; t < count; ++t) {
    const UnitPair u = random_pair(key, Stream::point_set, t);
    measure[t] = u.first;
    counts[t] = static_cast<std::uint32_t>(3 * u.second);
  }
  const std::vector<std::uint32_t> seeds = ring_seeds(triangles, 20, 4);
  REQUIRE(seeds.size() == 20);
  CHECK(seeds == ring_seeds(triangles, 20, 4));
  double whole = 0, samples = 0, most = 0;
  for (std::size_t t = 0; t < count; ++t) {
    whole += measure[t];
    samples += counts[t];
  }
  for (const std::uint32_t seed : seeds) {
    // Distances of the vertices by relaxation; triangle t is in ring 1 + the least distance of its corners.
    std::vector<int> distance(2 * vertices, 1000);
    distance[seed] = 0;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t t = 0; t < count; ++t) {
        int least = 1000;
        for (std::size_t k = 0; k < 3; ++k) least = std::min(least, distance[triangles[3 * t + k]]);
        for (std::size_t k = 0; k < 3; ++k)
          if (distance[triangles[3 * t + k]] > least + 1) {
            distance[triangles[3 * t + k]] = least + 1;
            changed = true;
          }
      }
    }
    for (int ring = 1; ring < 100; ++ring) {
      double inside = 0, found = 0;
      for (std::size_t t = 0; t < count; ++t) {
        int least = 1000;
        for (std::size_t k = 0; k < 3; ++k) least = std::min(least, distance[triangles[3 * t + k]]);
        if (least + 1 > ring) continue;
        inside += measure[t];
        found += counts[t];
      }
      most = std::max(most, std::abs(found / samples - inside / whole));
    }
  }
  CHECK(ring_discrepancy(triangles, around, measure, counts, seeds).discrepancy ==
        Approx(most).epsilon(1e-9));
}
