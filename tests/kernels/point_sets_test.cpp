#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <stdexcept>

#include "kernels/analyse/chi_square.h"
#include "kernels/analyse/spacing.h"
#include "kernels/core/random.h"
#include "kernels/pointset/iterative_points.h"
#include "kernels/pointset/planar_points.h"
#include "kernels/pointset/sample_elimination.h"
#include "kernels/pointset/sphere_points.h"
#include "support/catch.h"

using namespace meander;

namespace {

std::vector<PlanarMethod> every_planar_method() {
  std::vector<PlanarMethod> methods;
  for (std::size_t m = 0; m < planar_method_names.size(); ++m)
    methods.push_back(static_cast<PlanarMethod>(m));
  return methods;
}

bool same(const PlanarPoints& a, const PlanarPoints& b) { return a.x == b.x && a.y == b.y; }

// Smallest distance over the largest possible one for so many points of area 1, the hexagonal lattice's.
double relative_spacing(const PlanarPoints& points) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.count(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, std::hypot(points.x[i] - points.x[j], points.y[i] - points.y[j]));
  return least / std::sqrt(2 / (std::sqrt(3.0) * static_cast<double>(points.count())));
}

// Is there exactly one of 2^m points in every elementary interval 2^-a x 2^-(m - a)?
bool is_net(const PlanarPoints& points, int m) {
  for (int a = 0; a <= m; ++a) {
    std::set<std::uint64_t> cells;
    for (std::size_t i = 0; i < points.count(); ++i)
      cells.insert(static_cast<std::uint64_t>(std::ldexp(points.x[i], a)) << 32 |
                   static_cast<std::uint64_t>(std::ldexp(points.y[i], m - a)));
    if (cells.size() != std::size_t{1} << m) return false;
  }
  return points.count() == std::size_t{1} << m;
}

}  // namespace

TEST_CASE("planar_points: names are parsed and listed") {
  for (const PlanarMethod method : every_planar_method()) CHECK(planar_method(name_of(method)) == method);
  CHECK(!planar_method("Halton").has_value());
  CHECK(!planar_method("").has_value());
  for (std::size_t m = 0; m < sphere_method_names.size(); ++m)
    CHECK(sphere_method(sphere_method_names[m]) == static_cast<SphereMethod>(m));
}

TEST_CASE("planar_points: every method gives exactly the count inside the square, by seed") {
  for (const PlanarMethod method : every_planar_method()) {
    INFO(name_of(method));
    CHECK(planar_points(method, 0, 1).count() == 0);
    for (const std::uint32_t count : {1u, 2u, 3u, 5u, 16u, 96u, 257u, 1000u}) {
      const PlanarPoints points = planar_points(method, count, 1);
      REQUIRE(points.x.size() == count);
      REQUIRE(points.y.size() == count);
      for (const auto& w : {points.x, points.y})
        CHECK(std::all_of(w.begin(), w.end(), [](double c) { return c >= 0 && c < 1; }));
    }
    const PlanarPoints points = planar_points(method, 300, 1);
    CHECK(same(points, planar_points(method, 300, 1)));
    CHECK(same(points, planar_points(method, 300, 2)) == is_deterministic(method));
    // The center of gravity: 5 standard errors of independent points.
    double x = 0, y = 0;
    for (std::size_t i = 0; i < 300; ++i) {
      x += points.x[i] / 300;
      y += points.y[i] / 300;
    }
    CHECK(std::abs(x - 0.5) < 5 * std::sqrt(1 / 12.0 / 300));
    CHECK(std::abs(y - 0.5) < 5 * std::sqrt(1 / 12.0 / 300));
  }
}

TEST_CASE("planar_points: parameters out of range are refused") {
  PlanarParameters parameters;
  parameters.leaves_per_point = 0.5;
  CHECK_THROWS_AS(planar_points(PlanarMethod::hilbert_vertex, 10, 1, parameters), std::invalid_argument);
  parameters = {};
  parameters.lloyd_iterations = 20000;
  CHECK_THROWS_AS(planar_points(PlanarMethod::lloyd, 10, 1, parameters), std::invalid_argument);
}

TEST_CASE("radical_inverse: known values") {
  const double base_two[] = {0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875, 0.0625};
  for (std::uint32_t i = 0; i < 9; ++i) CHECK(radical_inverse(2, i) == base_two[i]);
  const double base_three[] = {0, 1 / 3.0, 2 / 3.0, 1 / 9.0, 4 / 9.0, 7 / 9.0, 2 / 9.0, 5 / 9.0, 8 / 9.0};
  for (std::uint32_t i = 0; i < 9; ++i) CHECK(radical_inverse(3, i) == Approx(base_three[i]).epsilon(1e-15));
  CHECK(radical_inverse(10, 1234) == Approx(0.4321).epsilon(1e-15));
  CHECK(radical_inverse(2, 0xFFFFFFFFu) < 1);
}

TEST_CASE("planar_points: Halton starts at index 1, Hammersley is centered") {
  const PlanarPoints halton = planar_points(PlanarMethod::halton, 4, 9);
  CHECK(halton.x == std::vector<double>{0.5, 0.25, 0.75, 0.125});
  CHECK(halton.y[0] == Approx(1 / 3.0));
  CHECK(halton.y[3] == Approx(4 / 9.0));
  const PlanarPoints hammersley = planar_points(PlanarMethod::hammersley, 4, 9);
  CHECK(hammersley.x == std::vector<double>{0.125, 0.375, 0.625, 0.875});
  CHECK(hammersley.y == std::vector<double>{0, 0.5, 0.25, 0.75});
}

TEST_CASE("planar_points: Sobol's first points as published, and its nets") {
  const PlanarPoints points = planar_points(PlanarMethod::sobol, 10, 1);
  CHECK(points.x == std::vector<double>{0, 0.5, 0.75, 0.25, 0.375, 0.875, 0.625, 0.125, 0.1875, 0.6875});
  CHECK(points.y == std::vector<double>{0, 0.5, 0.25, 0.75, 0.375, 0.875, 0.125, 0.625, 0.3125, 0.8125});
  for (int m = 0; m <= 12; ++m) CHECK(is_net(planar_points(PlanarMethod::sobol, 1u << m, 1), m));
  CHECK(!is_net(planar_points(PlanarMethod::halton, 64, 1), 6));
}

TEST_CASE("planar_points: Owen scrambling keeps nets and prefixes, and makes every point uniform") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (int m = 0; m <= 11; ++m) CHECK(is_net(planar_points(PlanarMethod::sobol_owen, 1u << m, seed), m));
  const PlanarPoints few = planar_points(PlanarMethod::sobol_owen, 100, 3),
                     many = planar_points(PlanarMethod::sobol_owen, 1000, 3);
  CHECK(std::equal(few.x.begin(), few.x.end(), many.x.begin()));
  CHECK(std::equal(few.y.begin(), few.y.end(), many.y.begin()));
  // Point 5 over 8000 seeds: uniform over 8 x 8 cells (p-value of a chi-square test, fixed seeds).
  std::vector<std::uint64_t> cells(64, 0);
  for (std::uint64_t seed = 0; seed < 8000; ++seed) {
    const PlanarPoints points = planar_points(PlanarMethod::sobol_owen, 6, seed);
    ++cells[static_cast<std::size_t>(8 * points.x[5]) + 8 * static_cast<std::size_t>(8 * points.y[5])];
  }
  CHECK(chi_square_test(cells, std::vector<double>(64, 1.0)).p_value > 1e-3);
}

TEST_CASE("planar_points: R2 is a Kronecker sequence of the plastic number") {
  const double g = std::cbrt((9 + std::sqrt(69.0)) / 18) + std::cbrt((9 - std::sqrt(69.0)) / 18);
  const PlanarPoints points = planar_points(PlanarMethod::r2, 2000, 1);
  for (std::size_t i = 1; i < points.count(); ++i) {
    CHECK(std::abs(std::remainder(points.x[i] - points.x[i - 1] - 1 / g, 1.0)) < 1e-12);
    CHECK(std::abs(std::remainder(points.y[i] - points.y[i - 1] - 1 / (g * g), 1.0)) < 1e-12);
  }
}

TEST_CASE("planar_points: jittered has one point in each cell of area 1/N") {
  const PlanarPoints square = planar_points(PlanarMethod::jittered, 144, 5);
  std::set<int> cells;
  for (std::size_t i = 0; i < 144; ++i)
    cells.insert(static_cast<int>(12 * square.x[i]) + 12 * static_cast<int>(12 * square.y[i]));
  CHECK(cells.size() == 144);
  // 10 points: 3 columns of 3, 3 and 4 cells.
  const PlanarPoints ten = planar_points(PlanarMethod::jittered, 10, 5);
  const auto cell_of = [](double x, double y) {
    const int column = x < 0.3 ? 0 : x < 0.6 ? 1 : 2;
    return 10 * column + static_cast<int>(y * (column == 2 ? 4 : 3));
  };
  cells.clear();
  for (std::size_t i = 0; i < 10; ++i) cells.insert(cell_of(ten.x[i], ten.y[i]));
  CHECK(cells == std::set<int>{0, 1, 2, 10, 11, 12, 20, 21, 22, 23});
}

TEST_CASE("planar_points: stratified on the Hilbert curve has one point in every quarter of a quarter ...") {
  for (const PlanarMethod method : {PlanarMethod::hilbert_stratified, PlanarMethod::hilbert_owen}) {
    const PlanarPoints points = planar_points(method, 1024, 3);
    std::set<int> cells;
    for (std::size_t i = 0; i < 1024; ++i)
      cells.insert(static_cast<int>(32 * points.x[i]) + 32 * static_cast<int>(32 * points.y[i]));
    CHECK(cells.size() == 1024);
  }
  const PlanarPoints peano = planar_points(PlanarMethod::peano_stratified, 729, 3);
  std::set<int> cells;
  for (std::size_t i = 0; i < 729; ++i)
    cells.insert(static_cast<int>(27 * peano.x[i]) + 27 * static_cast<int>(27 * peano.y[i]));
  CHECK(cells.size() == 729);
}

TEST_CASE("planar_points: regular Hilbert is a grid for powers of four, at vertices the leaf centers") {
  // H of the middle of a cell's interval is the middle of the cell: the curve crosses it from the second to
  // the third quarter.
  const PlanarPoints regular = planar_points(PlanarMethod::hilbert_regular, 256, 1);
  std::set<std::pair<double, double>> places;
  for (std::size_t i = 0; i < 256; ++i) {
    places.insert({std::floor(16 * regular.x[i]), std::floor(16 * regular.y[i])});
    CHECK(std::abs(std::remainder(16 * regular.x[i] - 0.5, 1.0)) < 1e-6);
    CHECK(std::abs(std::remainder(16 * regular.y[i] - 0.5, 1.0)) < 1e-6);
  }
  CHECK(places.size() == 256);

  PlanarParameters parameters;
  for (const double leaves : {1.0, 16.0}) {
    parameters.leaves_per_point = leaves;
    const PlanarPoints vertex = planar_points(PlanarMethod::hilbert_vertex, 200, 1, parameters);
    const double side = leaves == 1 ? 16 : 64;  // 4^4 >= 200, 4^6 >= 3200
    for (std::size_t i = 0; i < 200; ++i) {
      CHECK(std::remainder(side * vertex.x[i] - 0.5, 1.0) == 0);
      CHECK(std::remainder(side * vertex.y[i] - 0.5, 1.0) == 0);
    }
  }
}

TEST_CASE("planar_points: Poisson disk keeps its distance") {
  for (const std::uint32_t count : {256u, 1024u, 2048u}) {
    const double spacing = relative_spacing(planar_points(PlanarMethod::poisson_disk, count, count));
    CHECK(spacing > 0.65);
    CHECK(spacing < 0.78);
  }
  CHECK(relative_spacing(planar_points(PlanarMethod::random, 1024, 1)) < 0.1);
}

TEST_CASE("eliminate_samples: in the plane equals planar_points") {
  // The same rule over the same candidates, whose neighbors are found in another way and whose weights are
  // kept in single precision: nearly all decisions are the same.
  const RandomKey key = make_random_key(3, {});
  constexpr std::uint32_t count = 512;
  std::vector<double> candidates;
  for (std::size_t i = 0; i < 5 * count; ++i) {
    const UnitPair p = random_pair(key, Stream::point_set, i);
    candidates.insert(candidates.end(), {p.first, p.second, 0});
  }
  const std::vector<std::uint32_t> kept = eliminate_samples(candidates, count, 1);
  REQUIRE(kept.size() == count);
  CHECK(std::is_sorted(kept.begin(), kept.end()));
  const PlanarPoints expected = poisson_disk_points(count, key);
  std::set<double> known(expected.x.begin(), expected.x.end());
  std::size_t same_points = 0;
  for (const std::uint32_t i : kept) same_points += known.count(candidates[3 * i]);
  CHECK(same_points >= count - 8);
}

TEST_CASE("eliminate_samples: keeps its distance on a sphere, with exactly the count") {
  const RandomKey key = make_random_key(5, {});
  constexpr std::uint32_t count = 700;
  std::vector<double> candidates;
  for (std::size_t i = 0; i < 5 * count; ++i) {
    const UnitPair p = random_pair(key, Stream::point_set, i);
    const double z = 2 * p.first - 1, r = std::sqrt(1 - z * z), a = 2 * std::numbers::pi * p.second;
    candidates.insert(candidates.end(), {r * std::cos(a), r * std::sin(a), z});
  }
  const double area = 4 * std::numbers::pi;
  std::vector<double> kept;
  for (const std::uint32_t i : eliminate_samples(candidates, count, area))
    for (std::size_t k = 0; k < 3; ++k) kept.push_back(candidates[3 * i + k]);
  REQUIRE(kept.size() == 3 * count);
  const double rho = spacing_of(nearest_distances(kept), area).rho;
  CHECK(rho > 0.65);
  CHECK(rho < 0.78);
  CHECK(eliminate_samples(candidates, 5 * count, area).size() == 5 * count);  // nothing to leave out
  CHECK_THROWS_AS(eliminate_samples(candidates, 5 * count + 1, area), std::invalid_argument);
  CHECK_THROWS_AS(eliminate_samples(candidates, 0, area), std::invalid_argument);
  CHECK_THROWS_AS(eliminate_samples(candidates, count, 0), std::invalid_argument);
}

TEST_CASE("centroidal_points: fixed points and the Voronoi cells of few points") {
  // One point goes to the middle; two at the heights of their halves' middles stay.
  PlanarPoints start{{0.9}, {0.1}};
  PlanarPoints moved = centroidal_points(start, 1);
  CHECK(moved.x[0] == Approx(0.5).epsilon(1e-15));
  CHECK(moved.y[0] == Approx(0.5).epsilon(1e-15));
  // Two points: the bisector x = 0.4 cuts the square into strips with middles 0.2 and 0.7.
  moved = centroidal_points({{0.3, 0.5}, {0.5, 0.5}}, 1);
  CHECK(moved.x[0] == Approx(0.2).epsilon(1e-14));
  CHECK(moved.x[1] == Approx(0.7).epsilon(1e-14));
  CHECK(moved.y[0] == Approx(0.5).epsilon(1e-14));
  PlanarPoints grid;
  for (int i = 0; i < 400; ++i) {
    grid.x.push_back((i % 20 + 0.5) / 20);
    grid.y.push_back((i / 20 + 0.5) / 20);
  }
  moved = centroidal_points(grid, 3);
  for (std::size_t i = 0; i < 400; ++i) {
    CHECK(moved.x[i] == Approx(grid.x[i]).margin(1e-12));
    CHECK(moved.y[i] == Approx(grid.y[i]).margin(1e-12));
  }
}

TEST_CASE("centroidal_points: cells agree with a dense raster, also for clustered points") {
  PlanarPoints start = planar_points(PlanarMethod::random, 60, 2);
  for (std::size_t i = 0; i < 20; ++i) {  // a cluster, so that cells reach over many empty buckets
    start.x[i] = 0.01 + 0.01 * start.x[i];
    start.y[i] = 0.98 + 0.01 * start.y[i];
  }
  const PlanarPoints moved = centroidal_points(start, 1);
  constexpr int side = 700;
  std::vector<double> x(60, 0), y(60, 0), cells(60, 0);
  for (int v = 0; v < side; ++v)
    for (int u = 0; u < side; ++u) {
      const double px = (u + 0.5) / side, py = (v + 0.5) / side;
      std::size_t nearest = 0;
      double least = 10;
      for (std::size_t i = 0; i < 60; ++i) {
        const double dx = start.x[i] - px, dy = start.y[i] - py, d = dx * dx + dy * dy;
        if (d < least) nearest = i;
        least = std::min(d, least);
      }
      x[nearest] += px;
      y[nearest] += py;
      ++cells[nearest];
    }
  // Raster centroids are good to about a pixel's side where cells have many pixels.
  for (std::size_t i = 0; i < 60; ++i) {
    if (cells[i] < 500) continue;
    CHECK(moved.x[i] == Approx(x[i] / cells[i]).margin(5e-4));
    CHECK(moved.y[i] == Approx(y[i] / cells[i]).margin(5e-4));
  }
}

TEST_CASE("planar_points: Lloyd spreads points, more with every iteration") {
  PlanarParameters parameters;
  double before = 0;
  for (const std::uint32_t iterations : {0u, 5u, 40u}) {
    parameters.lloyd_iterations = iterations;
    const double spacing = relative_spacing(planar_points(PlanarMethod::lloyd, 1024, 1, parameters));
    CHECK(spacing > before);
    before = spacing;
  }
  CHECK(before > 0.55);
}

TEST_CASE("sphere_points: unit vectors, balanced, by seed") {
  for (std::size_t m = 0; m < sphere_method_names.size(); ++m) {
    const auto method = static_cast<SphereMethod>(m);
    INFO(name_of(method));
    for (const std::uint32_t count : {0u, 1u, 2u, 3u, 1000u}) {
      const SpherePoints points = sphere_points(method, count, 1);
      REQUIRE((points.x.size() == count && points.y.size() == count && points.z.size() == count));
      double worst = 0, x = 0, y = 0, z = 0;
      for (std::size_t i = 0; i < count; ++i) {
        worst = std::max(worst, std::abs(std::hypot(points.x[i], points.y[i], points.z[i]) - 1));
        x += points.x[i];
        y += points.y[i];
        z += points.z[i];
      }
      CHECK(worst < 1e-14);
      if (count == 1000) CHECK(std::hypot(x, y, z) < 5 * std::sqrt(1000.0));
    }
    const bool equal = sphere_points(method, 100, 1).x == sphere_points(method, 100, 2).x;
    CHECK(equal == is_deterministic(method));
  }
}

TEST_CASE("sphere_points: Fibonacci and spiral follow their formulas") {
  const std::uint32_t n = 500;
  const SpherePoints fibonacci = sphere_points(SphereMethod::fibonacci, n, 1),
                     spiral = sphere_points(SphereMethod::spiral, n, 1);
  const double golden = 2 * std::numbers::pi / std::numbers::phi;
  for (std::size_t i = 1; i < n; ++i) {
    const double turned =
        std::atan2(fibonacci.y[i], fibonacci.x[i]) - std::atan2(fibonacci.y[i - 1], fibonacci.x[i - 1]);
    CHECK(std::abs(std::remainder(turned - golden, 2 * std::numbers::pi)) < 1e-10);
    CHECK(fibonacci.z[i - 1] - fibonacci.z[i] == Approx(2.0 / n));
    CHECK(spiral.z[i] - spiral.z[i - 1] == Approx(2.0 / (n - 1)));
  }
  CHECK(spiral.z.front() == -1);
  CHECK(spiral.z.back() == 1);
  for (std::size_t i = 2; i + 1 < n; ++i) {
    const double turned = std::atan2(spiral.y[i], spiral.x[i]) - std::atan2(spiral.y[i - 1], spiral.x[i - 1]);
    const double step = 3.6 / std::sqrt(n * (1 - spiral.z[i] * spiral.z[i]));
    CHECK(std::abs(std::remainder(turned - step, 2 * std::numbers::pi)) < 1e-10);
  }
}

TEST_CASE("lift_to_sphere: preserves areas") {
  const SpherePoints points = lift_to_sphere({{0, 0.25, 0.5, 0.75}, {0.5, 0.5, 0.25, 0}});
  CHECK(points.x[0] == Approx(1));
  CHECK(points.y[1] == Approx(1));
  CHECK(points.x[2] == Approx(-std::sqrt(0.75)));
  CHECK(points.z[2] == Approx(0.5));
  CHECK(points.z[3] == 1);
}
