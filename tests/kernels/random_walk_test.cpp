#include "kernels/segment/random_walk.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "kernels/core/random.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/segment/seeds.h"
#include "support/catch.h"
#include "support/direction_field.h"
#include "support/hand_charts.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

Vector3 centroid(const PreparedMesh& mesh, std::uint32_t t) {
  return (1.0 / 3) * (mesh.position(mesh.triangles[3 * t]) + mesh.position(mesh.triangles[3 * t + 1]) +
                      mesh.position(mesh.triangles[3 * t + 2]));
}

// The triangle whose centroid is nearest to file coordinates (x, y, 0).
std::uint32_t triangle_at(const PreparedMesh& mesh, double x, double y) {
  const Vector3 p = (1 / mesh.unit) * (Vector3{x, y, 0} - mesh.center);
  std::uint32_t best = 0;
  for (std::uint32_t t = 1; t < mesh.triangle_count(); ++t)
    if (distance(centroid(mesh, t), p) < distance(centroid(mesh, best), p)) best = t;
  return best;
}

// A bumpy sheet without symmetries.
PolygonMesh bumpy_sheet(std::uint32_t n) {
  return wavy_grid(n, n, 0.25,
                   [](double x, double y) { return 0.2 * std::sin(5 * x + 1) * std::cos(4 * y); });
}

struct CentroidSpread {
  double count = 0, x = 0, y = 0, xx = 0, yy = 0;
  void add(Vector3 p) {
    ++count;
    x += p.x;
    y += p.y;
    xx += p.x * p.x;
    yy += p.y * p.y;
  }
  double variance_x() const { return xx / count - x * x / (count * count); }
  double variance_y() const { return yy / count - y * y / (count * count); }
};

bool same_partition(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) {
  std::map<std::uint32_t, std::uint32_t> forth, back;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (forth.emplace(a[i], b[i]).first->second != b[i] || back.emplace(b[i], a[i]).first->second != a[i])
      return false;
  return true;
}

std::vector<std::uint32_t> segments_of(const PreparedMesh& mesh, const TensorField& field,
                                       std::uint32_t count) {
  const TriangleSteps steps = triangle_steps(mesh, field);
  return random_walk_labels(mesh, steps.weight, farthest_seeds(mesh, steps.length, count));
}

}  // namespace

TEST_CASE("triangle_steps: Euclidean on a flat grid, in spacings along and across a field") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(4, 4, 1, 1));
  const double cell = 0.25 / mesh.unit;
  for (const double ratio : {1.0, 4.0}) {
    const TensorField field = field_along(mesh, {1, 0, 0}, ratio);
    const TriangleSteps steps = triangle_steps(mesh, field);
    for (std::uint32_t h = 0; h < steps.length.size(); ++h) {
      if (mesh.opposite[h] == no_index) {
        CHECK(steps.length[h] == 0);
        CHECK(steps.weight[h] == 0);
        continue;
      }
      const Vector3 step = centroid(mesh, mesh.opposite[h] / 3) - centroid(mesh, h / 3);
      CHECK(steps.length[h] ==
            Approx(std::hypot(step.x / std::sqrt(ratio), step.y * std::sqrt(ratio))).epsilon(1e-12));
      CHECK(steps.length[h] == steps.length[mesh.opposite[h]]);
      CHECK(steps.weight[h] == steps.weight[mesh.opposite[h]]);
      CHECK(steps.weight[h] > 0);
    }
    CHECK(*std::max_element(steps.weight.begin(), steps.weight.end()) == 1.0);
  }
  // Weights by the formula: the diagonals and the edges along x of an isotropic grid.
  const TriangleSteps steps = triangle_steps(mesh, round_field(mesh), {0.5, 0});
  const double diagonal_step = std::sqrt(2.0) / 3 * cell, straight_step = std::sqrt(5.0) / 3 * cell;
  double sum = 0, edges = 0, diagonal = 0, straight = 0;
  for (std::uint32_t h = 0; h < steps.length.size(); ++h) {
    if (mesh.opposite[h] == no_index) continue;
    sum += steps.length[h];
    ++edges;
    const bool on_diagonal = std::abs(steps.length[h] - diagonal_step) < 1e-9;
    if (!on_diagonal) CHECK(steps.length[h] == Approx(straight_step));
    (on_diagonal ? diagonal : straight) = steps.weight[h];
  }
  const double mean = sum / edges;
  CHECK(diagonal / straight ==
        Approx(std::sqrt(2.0) * std::exp((straight_step - diagonal_step) / (0.5 * mean))).epsilon(1e-10));
}

TEST_CASE("triangle_steps: unfolding a crease leaves the steps unchanged") {
  const PolygonMesh flat = grid_plane(6, 6, 2, 2);
  PolygonMesh folded = flat;  // at x = 1, upright beyond
  for (std::size_t i = 0; i < folded.x.size(); ++i)
    if (folded.x[i] > 1) {
      folded.z[i] = folded.x[i] - 1;
      folded.x[i] = 1;
    }
  const PreparedMesh a = prepare_mesh(flat), b = prepare_mesh(folded);
  const TensorField fa = field_along(a, {1, 0, 0}, 3);
  const TensorField fb = field_along(
      b,
      [&](Vector3 p) {
        return p.x * b.unit + b.center.x < 1 - 1e-9 ? Vector3{1, 0, 0} : Vector3{0, 0, 1};
      },
      3);
  const TriangleSteps sa = triangle_steps(a, fa), sb = triangle_steps(b, fb);
  for (std::size_t h = 0; h < sa.length.size(); ++h) {
    CHECK(sb.length[h] * b.unit == Approx(sa.length[h] * a.unit).margin(1e-12));
    CHECK(sb.weight[h] == Approx(sa.weight[h]).margin(1e-12));
  }
}

TEST_CASE("random_walk_probabilities: a dense solve and simulated walks agree") {
  const PreparedMesh mesh = prepare_mesh(icosphere(1));
  const std::size_t count = mesh.triangle_count();
  const TriangleSteps steps = triangle_steps(mesh, field_along(mesh, {1, 2, 0.5}, 3));
  const std::vector<std::uint32_t> seeds = {3, 71, 40};
  const std::vector<double> found = random_walk_probabilities(mesh, mesh.components[0], steps.weight, seeds);
  REQUIRE(found.size() == count * 3);

  Eigen::MatrixXd walk = Eigen::MatrixXd::Identity(static_cast<int>(count), static_cast<int>(count));
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(static_cast<int>(count), 3);
  std::vector<double> total(count, 0.0);
  for (std::size_t h = 0; h < steps.weight.size(); ++h) total[h / 3] += steps.weight[h];
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto seed = std::find(seeds.begin(), seeds.end(), t);
    if (seed != seeds.end()) {
      right(t, seed - seeds.begin()) = 1;
      continue;
    }
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h)
      walk(t, mesh.opposite[h] / 3) -= steps.weight[h] / total[t];
  }
  const Eigen::MatrixXd expected = walk.partialPivLu().solve(right);
  for (std::uint32_t t = 0; t < count; ++t)
    for (std::uint32_t l = 0; l < 3; ++l) CHECK(found[3 * t + l] == Approx(expected(t, l)).margin(1e-12));

  const RandomKey key = make_random_key(5, {});
  constexpr std::uint32_t walks = 4000;
  for (const std::uint32_t start : {10u, 33u, 64u}) {
    std::array<double, 3> met{};
    for (std::uint32_t w = 0; w < walks; ++w) {
      std::uint32_t t = start;
      for (std::uint32_t step = 0;; ++step) {
        const auto seed = std::find(seeds.begin(), seeds.end(), t);
        if (seed != seeds.end()) {
          met[static_cast<std::size_t>(seed - seeds.begin())] += 1.0 / walks;
          break;
        }
        double at =
            random_pair(key, Stream::test_shapes, std::uint64_t{start} * walks + w, step).first * total[t];
        std::uint32_t h = 3 * t;
        while (h < 3 * t + 2 && at >= steps.weight[h]) at -= steps.weight[h++];
        t = mesh.opposite[h] / 3;
      }
    }
    for (std::uint32_t l = 0; l < 3; ++l)  // four standard deviations
      CHECK(met[l] == Approx(found[3 * start + l]).margin(4 * std::sqrt(0.25 / walks)));
  }
}

TEST_CASE("random_walk_probabilities: rows sum to one over several batches, labels are their max") {
  const PreparedMesh mesh = prepare_mesh(torus(40, 24));
  const TriangleSteps steps = triangle_steps(mesh, field_along(mesh, {0, 0, 1}, 4));
  for (const std::uint32_t count : {1u, 2u, 3u, 16u, 17u, 37u, 150u}) {
    const std::vector<std::uint32_t> seeds = farthest_seeds(mesh, steps.length, count);
    REQUIRE(seeds.size() == count);
    const std::vector<double> p = random_walk_probabilities(mesh, mesh.components[0], steps.weight, seeds);
    const std::vector<std::uint32_t> label = random_walk_labels(mesh, steps.weight, seeds);
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      const std::span<const double> row = std::span(p).subspan(t * count, count);
      REQUIRE(std::abs(std::accumulate(row.begin(), row.end(), 0.0) - 1) < 1e-11);
      REQUIRE(*std::min_element(row.begin(), row.end()) >= -1e-15);
      REQUIRE(row[label[t]] >= *std::max_element(row.begin(), row.end()) - 4e-12);
    }
    for (std::uint32_t l = 0; l < count; ++l) REQUIRE(label[seeds[l]] == l);
  }
}

TEST_CASE("random walk: two seeds of a mesh with a half-turn symmetry share it evenly") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(9, 6, 3, 2));
  const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
  const auto turned = [&](std::uint32_t t) { return count - 1 - t; };
  for (std::uint32_t t = 0; t < count; ++t)
    REQUIRE(norm(centroid(mesh, t) + centroid(mesh, turned(t))) < 1e-12);
  const TriangleSteps steps = triangle_steps(mesh, field_along(mesh, {1, 1, 0}, 2));
  const std::vector<std::uint32_t> seeds = {20, turned(20)};
  const std::vector<double> p = random_walk_probabilities(mesh, mesh.components[0], steps.weight, seeds);
  for (std::uint32_t t = 0; t < count; ++t) CHECK(p[2 * t] == Approx(p[2 * turned(t) + 1]).margin(1e-13));
  const std::vector<std::uint32_t> label = random_walk_labels(mesh, steps.weight, seeds);
  CHECK(static_cast<std::uint32_t>(std::count(label.begin(), label.end(), 0u)) == count / 2);
}

TEST_CASE("random walk: equal probabilities go to the lower number") {
  // A fan of three triangles in a row: the walk from the middle one is undecided.
  const PreparedMesh mesh = prepare_mesh(
      polygon_mesh({-1, 0, 0, 1, 0, 0, 0, std::sqrt(3.0), 0, -2, std::sqrt(3.0), 0, 2, std::sqrt(3.0), 0},
                   {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}));
  const TriangleSteps steps = triangle_steps(mesh, round_field(mesh));
  for (const auto& seeds : {std::vector<std::uint32_t>{1, 2}, std::vector<std::uint32_t>{2, 1}})
    CHECK(random_walk_labels(mesh, steps.weight, seeds)[0] == 0);
}

TEST_CASE("random walk: a long thin strip, whatever the range of its weights") {
  const std::uint32_t n = 12000;
  const PreparedMesh mesh = prepare_mesh(grid_plane(n, 1, 120, 1));
  const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
  // The triangles form a chain; probabilities are those of a voltage divider.
  for (const double ratio : {1.0, 1e3, 1e9}) {
    const TriangleSteps steps =
        triangle_steps(mesh, field_along(
                                 mesh,
                                 [](Vector3 p) {
                                   return std::sin(20 * p.x) > 0 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
                                 },
                                 ratio));
    double least = 1, most = 0;
    for (std::size_t h = 0; h < steps.weight.size(); ++h) {
      if (mesh.opposite[h] == no_index) continue;
      least = std::min(least, steps.weight[h]);
      most = std::max(most, steps.weight[h]);
    }
    CHECK(most == 1);
    CHECK(least >= 1e-8);
    if (ratio > 1e6) CHECK(least == 1e-8);
    std::vector<double> resistance(count, 0.0);  // from triangle 1 up to t; the order is 1, 0, 3, 2, ...
    std::vector<std::uint32_t> chain = {1};
    for (std::uint32_t last = no_index; chain.size() < count;) {
      const std::uint32_t at = chain.back();
      std::uint32_t next = no_index;
      double weight = 0;
      for (std::uint32_t h = 3 * at; h < 3 * at + 3; ++h)
        if (mesh.opposite[h] != no_index && mesh.opposite[h] / 3 != last) {
          next = mesh.opposite[h] / 3;
          weight = steps.weight[h];
        }
      REQUIRE(next != no_index);
      resistance[next] = resistance[at] + 1 / weight;
      last = at;
      chain.push_back(next);
    }
    const std::vector<std::uint32_t> seeds = {chain.front(), chain.back()};
    const std::vector<double> p = random_walk_probabilities(mesh, mesh.components[0], steps.weight, seeds);
    const double whole = resistance[chain.back()];
    double worst = 0;
    for (std::uint32_t t = 0; t < count; ++t)
      worst = std::max(worst, std::abs(p[2 * t + 1] - resistance[t] / whole));
    CAPTURE(ratio, worst);
    CHECK(worst < 1e-6);
    const std::vector<std::uint32_t> label = random_walk_labels(mesh, steps.weight, seeds);
    std::uint32_t changes = 0;
    for (std::uint32_t i = 1; i < count; ++i) changes += label[chain[i]] != label[chain[i - 1]];
    CHECK(changes == 1);
    const std::vector<std::uint32_t> many = farthest_seeds(mesh, steps.length, 24);
    const std::vector<std::uint32_t> labels = random_walk_labels(mesh, steps.weight, many);
    changes = 0;
    for (std::uint32_t i = 1; i < count; ++i) changes += labels[chain[i]] != labels[chain[i - 1]];
    CHECK(changes == many.size() - 1);
  }
}

TEST_CASE("random walk: coincident vertices and zero-area triangles keep finite steps") {
  PreparedMesh mesh = prepare_mesh(torus(12, 8));
  for (std::size_t i = 0; i < mesh.x.size(); i += 3) mesh.x[i] = mesh.y[i] = mesh.z[i] = 0.25;
  for (std::size_t t = 0; t < mesh.area.size(); ++t)
    mesh.area[t] =
        triangle_area(mesh.position(mesh.triangles[3 * t]), mesh.position(mesh.triangles[3 * t + 1]),
                      mesh.position(mesh.triangles[3 * t + 2]));
  REQUIRE(std::count(mesh.area.begin(), mesh.area.end(), 0.0) > 0);
  const auto check = [&] {
    const TriangleSteps steps = triangle_steps(mesh, field_along(mesh, {0, 0, 1}, 5), {1, 1});
    for (std::size_t h = 0; h < steps.length.size(); ++h) {
      REQUIRE(std::isfinite(steps.length[h]));
      REQUIRE((steps.weight[h] >= 1e-8 && steps.weight[h] <= 1));
    }
    const std::vector<std::uint32_t> seeds = {0, 50, 100};
    const std::vector<double> p = random_walk_probabilities(mesh, mesh.components[0], steps.weight, seeds);
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
      REQUIRE(std::abs(p[3 * t] + p[3 * t + 1] + p[3 * t + 2] - 1) < 1e-6);
    return farthest_seeds(mesh, steps.length, 4).size();
  };
  CHECK(check() == 4);
  std::fill(mesh.x.begin(), mesh.x.end(), 0.5);  // everything in one point
  std::fill(mesh.y.begin(), mesh.y.end(), 0.5);
  std::fill(mesh.z.begin(), mesh.z.end(), 0.5);
  std::fill(mesh.area.begin(), mesh.area.end(), 0.0);
  CHECK(check() == 1);
}

TEST_CASE("random walk: labels do not depend on the order of the triangles") {
  const PolygonMesh sheet = bumpy_sheet(24);
  const PreparedMesh mesh = prepare_mesh(sheet);
  const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
  PolygonMesh shuffled = sheet;  // by a fixed step, and corners turned round
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t from = i * 101 % count;
    for (std::uint32_t k = 0; k < 3; ++k) shuffled.corners[3 * i + k] = sheet.corners[3 * from + (k + i) % 3];
  }
  const PreparedMesh other = prepare_mesh(shuffled);
  const Vector3 along{1, 0.4, 0.2};
  const std::vector<std::uint32_t> a = segments_of(mesh, field_along(mesh, along, 4), 8);
  const std::vector<std::uint32_t> b = segments_of(other, field_along(other, along, 4), 8);
  std::vector<std::uint32_t> back(count);
  for (std::uint32_t i = 0; i < count; ++i) back[i * 101 % count] = b[i];
  CHECK(std::set<std::uint32_t>(a.begin(), a.end()).size() == 8);
  CHECK(same_partition(a, back));
}

TEST_CASE("random walk: labels are invariant to position and scale") {
  const PolygonMesh sheet = bumpy_sheet(24);
  const PreparedMesh mesh = prepare_mesh(sheet), other = prepare_mesh(moved(sheet, 3.7, 1, -20, 5));
  const PolygonMesh arrow = moved(polygon_mesh({0, 0, 0, 1, 0.4, 0.2}, {}), 1, 0, 0, 0);
  const Vector3 along{arrow.x[1], arrow.y[1], arrow.z[1]};
  CHECK(segments_of(mesh, field_along(mesh, {1, 0.4, 0.2}, 4), 8) ==
        segments_of(other, field_along(other, along, 4), 8));
  // Nor on the unit of the spacings.
  TensorField field = field_along(mesh, {1, 0.4, 0.2}, 4);
  const std::vector<std::uint32_t> before = segments_of(mesh, field, 8);
  for (TangentTensor& value : field.corner) value = value + TangentTensor{2, 0, 2};
  CHECK(segments_of(mesh, field, 8) == before);
}

TEST_CASE("random walk: in a constant field of ratio 8 segments lie along e1") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(40, 40));
  const std::vector<std::uint32_t> seeds = {triangle_at(mesh, 0.25, 0.25), triangle_at(mesh, 0.75, 0.75)};
  // The share of the square that the boundary y = 1/2, or x = 1/2, would explain.
  const auto shares = [&](double ratio, Vector3 along) {
    const TriangleSteps steps = triangle_steps(mesh, field_along(mesh, along, ratio));
    const std::vector<std::uint32_t> label = random_walk_labels(mesh, steps.weight, seeds);
    double by_y = 0, by_x = 0;
    for (std::uint32_t t = 0; t < label.size(); ++t) {
      by_y += (centroid(mesh, t).y > 0) == (label[t] == 1);
      by_x += (centroid(mesh, t).x > 0) == (label[t] == 1);
    }
    const auto count = static_cast<double>(label.size());
    return std::pair(by_x / count, by_y / count);
  };
  const auto [round_x, round_y] = shares(1, {1, 0, 0});
  CHECK(round_x == Approx(0.75).margin(0.02));
  CHECK(round_y == Approx(0.75).margin(0.02));
  const auto [along_x, along_y] = shares(8, {1, 0, 0});
  CHECK(along_y > 0.93);
  CHECK(along_x < 0.6);
  const auto [across_x, across_y] = shares(8, {0, 1, 0});
  CHECK(across_x > 0.93);
  CHECK(across_y < 0.6);

  // Sixteen segments: the spread along e1 against that across, within segments.
  const auto elongation = [&](double ratio) {
    const std::vector<std::uint32_t> label = segments_of(mesh, field_along(mesh, {1, 0, 0}, ratio), 16);
    std::vector<CentroidSpread> spread(16);
    for (std::uint32_t t = 0; t < label.size(); ++t) spread[label[t]].add(centroid(mesh, t));
    double x = 0, y = 0;
    for (const CentroidSpread& s : spread) {
      x += s.variance_x() * s.count;
      y += s.variance_y() * s.count;
    }
    return std::sqrt(x / y);
  };
  CHECK(elongation(1) == Approx(1).margin(0.35));
  CHECK(elongation(8) > 2);
}

TEST_CASE("random walk: the bending term keeps the boundary where the field turns") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(60, 30, 2, 1));
  const TensorField field = field_along(
      mesh,
      [&](Vector3 p) {
        return p.x * mesh.unit + mesh.center.x < 1 ? Vector3{1, 1, 0} : Vector3{1, -1, 0};
      },
      3);
  const std::vector<std::uint32_t> seeds = {triangle_at(mesh, 0.2, 0.5), triangle_at(mesh, 1.4, 0.5)};
  const auto wrong = [&](double beta) {
    const TriangleSteps steps = triangle_steps(mesh, field, {1, beta});
    const std::vector<std::uint32_t> label = random_walk_labels(mesh, steps.weight, seeds);
    double count = 0;
    for (std::uint32_t t = 0; t < label.size(); ++t)
      count += (centroid(mesh, t).x * mesh.unit + mesh.center.x > 1) != (label[t] == 1);
    return count / static_cast<double>(label.size());
  };
  CHECK(wrong(0) > 0.05);
  CHECK(wrong(6) < 0.02);
}

TEST_CASE("random walk: the same bits on one thread and on several") {
  const PreparedMesh mesh = prepare_mesh(merged(torus(120, 80), moved(icosphere(3), 1, 5, 0, 0)));
  const TensorField field = field_along(mesh, {0, 0, 1}, 4);
  const auto run = [&] {
    const TriangleSteps steps = triangle_steps(mesh, field, {1, 0.5});
    const std::vector<std::uint32_t> seeds = farthest_seeds(mesh, steps.length, 40);
    return std::tuple(steps.length, steps.weight, seeds, random_walk_labels(mesh, steps.weight, seeds),
                      random_walk_probabilities(mesh, mesh.components[0], steps.weight,
                                                std::vector{mesh.components[0].triangle_begin,
                                                            mesh.components[0].triangle_end - 1}));
  };
  CHECK(on_threads(1, run) == on_threads(4, run));
}

TEST_CASE("farthest_seeds: one per component, then the farthest of all") {
  const PreparedMesh mesh = prepare_mesh(
      merged(merged(icosphere(2), moved(icosphere(1), 0.3, 4, 0, 0)), moved(tetrahedron(), 1, 9, 0, 0)));
  REQUIRE(mesh.components.size() == 3);
  const TriangleSteps steps = triangle_steps(mesh, round_field(mesh));
  CHECK(farthest_seeds(mesh, steps.length, 1).size() == 3);
  const std::vector<std::uint32_t> seeds = farthest_seeds(mesh, steps.length, 12);
  REQUIRE(seeds.size() == 12);
  // Slow reference: distances by relaxation, the farthest each time.
  std::vector<double> nearest(mesh.triangle_count(), 1e300);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    if (i < 3) {
      CHECK(seeds[i] >= mesh.components[i].triangle_begin);
      CHECK(seeds[i] < mesh.components[i].triangle_end);
    } else {
      const auto farthest = std::max_element(nearest.begin(), nearest.end());
      CHECK(seeds[i] == static_cast<std::uint32_t>(farthest - nearest.begin()));
    }
    nearest[seeds[i]] = 0;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t h = 0; h < mesh.opposite.size(); ++h) {
        const double through = nearest[mesh.opposite[h] / 3] + steps.length[h];
        if (through < nearest[h / 3]) {
          nearest[h / 3] = through;
          changed = true;
        }
      }
    }
  }
  // More seeds than triangles: every triangle once.
  const PreparedMesh small = prepare_mesh(tetrahedron());
  const TriangleSteps few = triangle_steps(small, round_field(small));
  std::vector<std::uint32_t> all = farthest_seeds(small, few.length, 99);
  const std::vector<std::uint32_t> label = random_walk_labels(small, few.weight, all);
  for (std::uint32_t l = 0; l < 4; ++l) CHECK(label[all[l]] == l);
  std::sort(all.begin(), all.end());
  CHECK(all == std::vector<std::uint32_t>{0, 1, 2, 3});
}

TEST_CASE("random walk: invalid arguments are refused, deadlines end it") {
  const PreparedMesh mesh = prepare_mesh(merged(icosphere(1), moved(icosphere(1), 1, 4, 0, 0)));
  const TensorField field = round_field(mesh);
  const TriangleSteps steps = triangle_steps(mesh, field);
  const Component& first = mesh.components[0];
  CHECK_THROWS_AS(triangle_steps(mesh, field, {0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(triangle_steps(mesh, field, {NAN, 0}), std::invalid_argument);
  CHECK_THROWS_AS(triangle_steps(mesh, field, {1, -1}), std::invalid_argument);
  CHECK_THROWS_AS(triangle_steps(mesh, TensorField{}), std::invalid_argument);
  using Seeds = std::vector<std::uint32_t>;
  CHECK_THROWS_AS(random_walk_labels(mesh, steps.weight, Seeds{0, 1}), std::invalid_argument);
  CHECK_THROWS_AS(random_walk_labels(mesh, steps.weight, Seeds{0, 9999}), std::invalid_argument);
  CHECK_THROWS_AS(random_walk_labels(mesh, std::vector<double>{}, Seeds{0}), std::invalid_argument);
  CHECK_THROWS_AS(random_walk_probabilities(mesh, first, steps.weight, Seeds{}), std::invalid_argument);
  CHECK_THROWS_AS(random_walk_probabilities(mesh, first, steps.weight, Seeds{1, 1}), std::invalid_argument);
  CHECK_THROWS_AS(random_walk_probabilities(mesh, first, steps.weight, Seeds{first.triangle_end}),
                  std::invalid_argument);
  CancelToken token;
  token.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK_THROWS_AS(random_walk_probabilities(mesh, first, steps.weight, Seeds{0, 1}, token), ItemError);
}
