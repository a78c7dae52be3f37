#include "kernels/query/nearest_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "kernels/core/nearest_on_triangle.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/query/curve_order.h"
#include "support/catch.h"
#include "support/query_meshes.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

TriangleTree tree_of(const PreparedMesh& mesh) {
  return build_triangle_tree(mesh.x, mesh.y, mesh.z, mesh.triangles);
}

// Triangles without topology, within [-1, 1].
struct Soup {
  std::vector<double> x, y, z;
  std::vector<std::uint32_t> triangles;

  void add(Vector3 a, Vector3 b, Vector3 c) {
    for (const Vector3 corner : {a, b, c}) {
      triangles.push_back(static_cast<std::uint32_t>(x.size()));
      x.push_back(corner.x);
      y.push_back(corner.y);
      z.push_back(corner.z);
    }
  }
  TriangleTree tree() const { return build_triangle_tree(x, y, z, triangles); }
};

Soup soup_of(const PreparedMesh& mesh) { return {mesh.x, mesh.y, mesh.z, mesh.triangles}; }

// Balls around the triangles of a soup.
struct Balls {
  std::vector<Vector3> middle;
  std::vector<double> radius;
};
Balls balls_of(const Soup& soup) {
  Balls balls;
  for (std::size_t t = 0; t < soup.triangles.size() / 3; ++t) {
    Vector3 corner[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = soup.triangles[3 * t + k];
      corner[k] = {soup.x[v], soup.y[v], soup.z[v]};
    }
    balls.middle.push_back((1.0 / 3) * (corner[0] + corner[1] + corner[2]));
    double radius = 0;
    for (const Vector3& c : corner) radius = std::max(radius, distance(c, balls.middle.back()));
    balls.radius.push_back(radius);
  }
  return balls;
}

// The slow way: all triangles in turn, but for those whose ball is farther away than the nearest one so far,
// by more than rounding.
NearestTriangles by_all_triangles(const Soup& soup, std::span<const double> points) {
  const Balls balls = balls_of(soup);
  const std::size_t count = points.size() / 3;
  NearestTriangles out;
  out.distance.resize(count);
  out.triangle.resize(count);
  out.weights.resize(2 * count);
  const auto corner = [&](std::size_t c) {
    const std::uint32_t v = soup.triangles[c];
    return Vector3{soup.x[v], soup.y[v], soup.z[v]};
  };
  parallel_blocks(count, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3 point{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
      TrianglePlace best;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t t = 0; t < soup.triangles.size() / 3; ++t) {
        const Vector3 to = balls.middle[t] - point;
        const double within = nearest + balls.radius[t];
        if (dot(to, to) > within * within * (1 + 1e-9)) continue;
        const TrianglePlace place =
            nearest_on_triangle(point, corner(3 * t), corner(3 * t + 1), corner(3 * t + 2));
        if (place.squared >= best.squared) continue;
        best = place;
        nearest = std::sqrt(best.squared);
        out.triangle[i] = static_cast<std::uint32_t>(t);
      }
      out.distance[i] = std::sqrt(best.squared);
      out.weights[2 * i] = best.weight1;
      out.weights[2 * i + 1] = best.weight2;
    }
  });
  return out;
}

void check_same(const NearestTriangles& found, const NearestTriangles& expected) {
  CHECK(found.distance == expected.distance);
  CHECK(found.triangle == expected.triangle);
  CHECK(found.weights == expected.weights);
}

// Points in the box and around it, near the surface, on it (inside, on edges, at corners), and far away.
std::vector<double> points_around(const Soup& soup, std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  std::vector<double> points;
  for (std::size_t i = 0; i < count; ++i) {
    const UnitPair u = random_pair(key, Stream::sequence, i), v = random_pair(key, Stream::sequence, i, 1),
                   w = random_pair(key, Stream::sequence, i, 2);
    const Vector3 in_box{2.2 * u.first - 1.1, 2.2 * u.second - 1.1, 2.2 * v.first - 1.1};
    const std::size_t t = static_cast<std::size_t>(v.second * static_cast<double>(soup.triangles.size() / 3));
    const auto corner = [&](std::size_t k) {
      const std::uint32_t c = soup.triangles[3 * t + k];
      return Vector3{soup.x[c], soup.y[c], soup.z[c]};
    };
    const double a = 1 - std::sqrt(w.first), b = w.second * (1 - a);
    const Vector3 on = a * corner(0) + b * corner(1) + (1 - a - b) * corner(2);
    const Vector3 of_kind[] = {in_box,       on + 1e-3 * in_box, on + 1e-7 * in_box,
                               on,           corner(1),          0.5 * (corner(0) + corner(2)),
                               1e3 * in_box, 1e10 * in_box};
    const Vector3 p = of_kind[i % std::size(of_kind)];
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  return points;
}

double uniform(const RandomKey& key, std::uint64_t i) {
  return 2 * random_pair(key, Stream::sequence, i).first - 1;
}

}  // namespace

TEST_CASE("nearest_triangles: the same as all triangles in turn, bit for bit") {
  for (const PolygonMesh& mesh :
       {cube(), tetrahedron(), icosphere(3), torus(40, 25), two_sided_plate(6, 1e-9)}) {
    const Soup soup = soup_of(prepare_mesh(mesh));
    const std::vector<double> points = points_around(soup, 2000, 1);
    check_same(nearest_triangles(soup.tree(), points), by_all_triangles(soup, points));
  }
}

TEST_CASE("nearest_triangles: soups of any sizes, needles, and triangles without area") {
  const RandomKey key = make_random_key(7, {});
  std::uint64_t drawn = 0;
  const auto number = [&] { return uniform(key, drawn++); };
  for (const double size : {0.3, 0.01}) {
    Soup soup;
    for (int t = 0; t < 700; ++t) {
      const Vector3 at{0.3 * number(), 0.3 * number(), 0.3 * number()};
      // Every tenth of them thin, a segment, a point, or one of two that cover each other.
      const Vector3 a{number(), number(), number()}, b{number(), number(), number()};
      const double thin = t % 10 == 0 ? 1e-12 : t % 10 == 1 ? 0 : 1, length = t % 10 == 2 ? 0 : size;
      soup.add(at, at + length * a, at + length * (a + thin * b));
      if (t % 10 == 3) soup.add(at, at + length * (a + b), at + length * a);
    }
    const std::vector<double> points = points_around(soup, 3000, 3);
    check_same(nearest_triangles(soup.tree(), points), by_all_triangles(soup, points));
  }
}

TEST_CASE("nearest_triangles: the lowest of many equal triangles, and trees as deep as they get") {
  Soup pile;
  for (int t = 0; t < 5000; ++t) pile.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const NearestTriangles on_pile =
      nearest_triangles(pile.tree(), std::vector<double>{0.2, 0.3, 0.4, -1, -1, 0});
  CHECK(on_pile.triangle == std::vector<std::uint32_t>{0, 0});
  CHECK(on_pile.distance[0] == Approx(0.4));
  CHECK(on_pile.distance[1] == Approx(std::sqrt(2.0)));
  // Each is a hundredth smaller than the one before: no bins of equal width divide them evenly.
  Soup spiral;
  double size = 1;
  for (int t = 0; t < 3000; ++t, size *= 0.9) spiral.add({size, 0, 0}, {0, size, 0}, {0, 0, size});
  const std::vector<double> points = points_around(spiral, 400, 5);
  check_same(nearest_triangles(spiral.tree(), points), by_all_triangles(spiral, points));
}

TEST_CASE("nearest_triangles: the tree lists every triangle once, within its boxes") {
  const PreparedMesh mesh = prepare_mesh(torus(250, 140));
  const TriangleTree tree = on_threads(2, [&] { return tree_of(mesh); });
  std::vector<std::uint32_t> all = tree.order;
  std::sort(all.begin(), all.end());
  std::vector<std::uint32_t> expected(mesh.triangle_count());
  std::iota(expected.begin(), expected.end(), 0u);
  CHECK(all == expected);
  CHECK(tree.leaf_begin.back() == mesh.triangle_count());
  std::size_t outside = 0, seen = 0;
  for (const TriangleTree::Node& node : tree.nodes)
    for (std::size_t c = 0; c < TriangleTree::fan; ++c) {
      if (node.child[c] == TriangleTree::no_child || (node.child[c] & TriangleTree::leaf_bit) == 0) continue;
      const std::size_t leaf = node.child[c] & ~TriangleTree::leaf_bit;
      CHECK_FALSE(tree.leaf_begin[leaf] == tree.leaf_begin[leaf + 1]);
      for (std::size_t p = tree.leaf_begin[leaf]; p < tree.leaf_begin[leaf + 1]; ++p, ++seen)
        for (std::size_t k = 0; k < 9; ++k) {
          const double value = tree.corners[9 * p + k];
          outside += value < node.low[k % 3][c] || value > node.high[k % 3][c];
        }
    }
  CHECK(outside == 0);
  CHECK(seen == mesh.triangle_count());
  const TriangleTree alone = on_threads(1, [&] { return tree_of(mesh); });
  CHECK(alone.order == tree.order);
  CHECK(alone.leaf_begin == tree.leaf_begin);
}

TEST_CASE("nearest_triangles: the same for every thread count, order of the points and instruction set",
          "[release]") {
  const PreparedMesh mesh = prepare_mesh(torus(120, 70));
  const TriangleTree tree = tree_of(mesh);
  const std::vector<double> points = points_around(soup_of(mesh), 40000, 9);
  const NearestTriangles expected = on_threads(1, [&] { return nearest_triangles(tree, points); });
  check_same(on_threads(3, [&] { return nearest_triangles(tree, points); }), expected);
  std::vector<double> reversed;
  for (std::size_t i = points.size(); i > 0; i -= 3)
    reversed.insert(reversed.end(), points.begin() + static_cast<std::ptrdiff_t>(i - 3),
                    points.begin() + static_cast<std::ptrdiff_t>(i));
  std::vector<double> distance = nearest_triangles(tree, reversed).distance;
  std::reverse(distance.begin(), distance.end());
  CHECK(distance == expected.distance);
  check_same(nearest_triangles(tree, points, {}, InstructionSet::scalar), expected);
  const CurvePoints along = along_curve(points);
  CHECK(along.as_given(nearest_triangles(tree, along.points).weights, 2) == expected.weights);
}

TEST_CASE("along_curve: points are taken along the curve, and values come back as they were given") {
  const std::vector<double> points = points_around(soup_of(prepare_mesh(torus(20, 10))), 5000, 4);
  const CurvePoints along = along_curve(points);
  CHECK(along.as_given(along.points, 3) == points);
  std::vector<std::uint32_t> numbers(along.order.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  CHECK(along.as_given(along.order) == numbers);
  CHECK(along.as_given(std::vector<float>{}).empty());
  CHECK_THROWS_AS(along_curve(std::vector<double>{0, 0}), std::invalid_argument);
  CHECK(along_curve({}).points.empty());
}

TEST_CASE("nearest_triangles: refuses what it cannot answer") {
  Soup soup;
  soup.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  CHECK_THROWS_AS(build_triangle_tree(soup.x, soup.y, soup.z, {}), std::invalid_argument);
  CHECK_THROWS_AS(build_triangle_tree(soup.x, soup.y, soup.z, std::vector<std::uint32_t>{0, 1, 3}),
                  std::invalid_argument);
  for (const double bad : {2.0, std::numeric_limits<double>::quiet_NaN()}) {
    Soup outside = soup;
    outside.y[2] = bad;
    CHECK_THROWS_AS(outside.tree(), std::invalid_argument);
  }
  const TriangleTree tree = soup.tree();
  CHECK_THROWS_AS(nearest_triangles(tree, std::vector<double>{0, 0}), std::invalid_argument);
  for (const double bad :
       {1e13, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS(nearest_triangles(tree, std::vector<double>{0, bad, 0}), std::invalid_argument);
  CHECK(nearest_triangles(tree, {}).distance.empty());
  std::atomic<bool> canceled = true;
  CancelToken cancel;
  cancel.canceled = &canceled;
  CHECK_THROWS_AS(nearest_triangles(tree, std::vector<double>{0, 0, 0}, cancel), RunCanceled);
}

TEST_CASE("nearest_triangles: real models, the same as all triangles in turn", "[release]") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const std::string& name : query_models()) {
    INFO(name);
    const Soup soup = soup_of(prepare_mesh(model_of(name)));
    const std::vector<double> points = points_around(soup, 80, 11);
    check_same(nearest_triangles(soup.tree(), points), by_all_triangles(soup, points));
  }
}

TEST_CASE("nearest_triangles: 100,000 points of each real model, the same as all triangles in turn",
          "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  for (const std::string& name : query_models()) {
    INFO(name);
    const Soup soup = soup_of(prepare_mesh(model_of(name)));
    const std::vector<double> points = points_around(soup, 100000, 13);
    check_same(nearest_triangles(soup.tree(), points), by_all_triangles(soup, points));
  }
}
