// Rates and values of the survey's comparison against values measured independently before.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "kernels/analyse/discrepancy_plane.h"
#include "kernels/analyse/discrepancy_sphere.h"
#include "kernels/analyse/discrepancy_star.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/pointset/planar_points.h"
#include "kernels/pointset/sphere_points.h"
#include "support/catch.h"

using namespace meander;

namespace {

struct Expected {
  double slope;
  std::array<double, 3> values;  // at 1024, 4096, 12288; 0 where the table has none
};

// A measure of one set in run `run`, which seeds the points and the shapes.
using Measure = std::function<double(std::uint32_t count, std::uint64_t run)>;

struct Series {
  std::vector<double> counts, means, deviations;  // by count; deviation of one run
  std::uint64_t runs = 0;

  double slope() const { return fit_slope(counts, means).slope; }
  std::size_t at(double count) const {
    return static_cast<std::size_t>(std::find(counts.begin(), counts.end(), count) - counts.begin());
  }
};

Series run_series(const Measure& measure, std::uint64_t runs, std::uint32_t most) {
  Series series;
  series.runs = runs;
  for (const std::uint32_t count : survey_counts(most, 16)) {
    double sum = 0, squares = 0;
    for (std::uint64_t run = 1; run <= runs; ++run) {
      const double d = measure(count, run);
      sum += d;
      squares += d * d;
    }
    const auto n = static_cast<double>(runs);
    series.counts.push_back(count);
    series.means.push_back(sum / n);
    series.deviations.push_back(std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1)));
  }
  return series;
}

ShapeParameters shapes(std::uint32_t count, std::uint64_t seed) {
  ShapeParameters parameters;
  parameters.shapes = count;
  parameters.seed = seed;
  parameters.stable_rise = 0;
  return parameters;
}

// Slopes within 0.03. Values within 15 %, or within what runs differ by: the table's are means of 5 runs, so
// that three standard errors of the difference of the two means are deviation x 3 sqrt(1/5 + 1/runs). Only
// random points and maxima over few shapes of regular sets need that (random: one run deviates by 30 %).
void compare(const Series& series, const Expected& expected) {
  const SlopeFit fit = fit_slope(series.counts, series.means);
  CAPTURE(fit.slope, fit.standard_error, expected.slope);
  CHECK(std::abs(fit.slope - expected.slope) <= 0.03);
  const std::array<double, 3> at = {1024, 4096, 12288};
  for (std::size_t k = 0; k < 3; ++k) {
    if (expected.values[k] == 0) continue;
    const std::size_t i = series.at(at[k]);
    const double error = series.deviations[i] * std::sqrt(1.0 / 5 + 1.0 / static_cast<double>(series.runs));
    CAPTURE(at[k], series.means[i], expected.values[k], series.deviations[i]);
    CHECK(std::abs(series.means[i] - expected.values[k]) <= std::max(0.15 * expected.values[k], 3 * error));
  }
}

Measure star(PlanarMethod method) {
  return [method](std::uint32_t count, std::uint64_t run) {
    const PlanarPoints points = planar_points(method, count, run);
    return star_discrepancy_exact(points.x, points.y);
  };
}

Measure triangles(PlanarMethod method) {
  return [method](std::uint32_t count, std::uint64_t run) {
    const PlanarPoints points = planar_points(method, count, run);
    return triangle_discrepancy(build_point_index(points.x, points.y), shapes(1500, run)).discrepancy;
  };
}

Measure quarter_circles(PlanarMethod method) {
  return [method](std::uint32_t count, std::uint64_t run) {
    const PlanarPoints points = planar_points(method, count, run);
    return quarter_circle_discrepancy(points.x, points.y);
  };
}

Measure caps(SphereMethod method) {
  return [method](std::uint32_t count, std::uint64_t run) {
    const SpherePoints points = sphere_points(method, count, run);
    return cap_discrepancy(points.x, points.y, points.z, shapes(200, run)).discrepancy;
  };
}

Measure sphere_triangles(SphereMethod method) {
  return [method](std::uint32_t count, std::uint64_t run) {
    const SpherePoints points = sphere_points(method, count, run);
    return spherical_triangle_discrepancy(build_point_index(points.x, points.y, points.z), shapes(1500, run))
        .discrepancy;
  };
}

struct PlanarRow {
  PlanarMethod method;
  Expected box, triangle, quarter_circle;
};

const std::array<PlanarRow, 6> planar_table = {{
    {PlanarMethod::random,
     {-0.49, {.0401, .0174, .0132}},
     {-0.50, {.0374, .0147, .0119}},
     {-0.49, {.0288, .0130, .0098}}},
    {PlanarMethod::hilbert_stratified,
     {-0.65, {.0144, .0055, .0028}},
     {-0.71, {.0107, .0041, .0020}},
     {-0.67, {.0081, .0030, .0015}}},
    {PlanarMethod::hilbert_regular,
     {-0.47, {.0310, .0156, .0156}},
     {-0.59, {.0159, .0070, .0074}},
     {-0.64, {.0070, .0026, .0026}}},
    {PlanarMethod::jittered,
     {-0.68, {.0125, .0049, .0025}},
     {-0.73, {.0122, .0043, .0019}},
     {-0.70, {.0085, .0032, .0015}}},
    {PlanarMethod::halton,
     {-0.82, {.0066, .0019, .0009}},
     {-0.70, {.0117, .0042, .0022}},
     {-0.68, {.0096, .0035, .0017}}},
    {PlanarMethod::hammersley,
     {-0.88, {.0043, .0013, .0005}},
     {-0.54, {.0183, .0081, .0042}},
     {-0.71, {.0086, .0034, .0011}}},
}};

}  // namespace

TEST_CASE("survey: exact discrepancies of deterministic sets match the table to its last digit") {
  for (const PlanarRow& row : planar_table) {
    if (!is_deterministic(row.method)) continue;
    INFO(name_of(row.method));
    for (std::size_t k = 0; k < 2; ++k) {  // 12288 is left to the slow test
      const std::uint32_t count = k == 0 ? 1024 : 4096;
      CHECK(star(row.method)(count, 1) == Approx(row.box.values[k]).margin(6e-5).epsilon(0));
      CHECK(quarter_circles(row.method)(count, 1) ==
            Approx(row.quarter_circle.values[k]).margin(6e-5).epsilon(0));
    }
  }
}

TEST_CASE("survey: regular Hilbert is a grid at powers of four, which boxes detect") {
  for (const std::uint32_t side : {8u, 32u, 64u}) {
    const double inner = 1 - 0.5 / side;
    CHECK(star(PlanarMethod::hilbert_regular)(side * side, 1) == Approx(1 - inner * inner).epsilon(1e-5));
    CHECK(star(PlanarMethod::hilbert_stratified)(side * side, 1) < 0.8 * (1 - inner * inner));
  }
}

TEST_CASE("survey: rates on the plane, few points") {
  // N = 16 .. 768, 8 runs: the standard error of these slopes is about 0.02 (random) and 0.01.
  const auto slope = [](const Measure& measure) { return run_series(measure, 8, 768).slope(); };
  CHECK(slope(star(PlanarMethod::random)) == Approx(-0.50).margin(0.06));
  CHECK(slope(star(PlanarMethod::hilbert_stratified)) == Approx(-0.66).margin(0.05));
  CHECK(slope(star(PlanarMethod::hammersley)) == Approx(-0.87).margin(0.05));
  CHECK(slope(quarter_circles(PlanarMethod::hilbert_stratified)) == Approx(-0.67).margin(0.06));
  CHECK(slope(triangles(PlanarMethod::hilbert_stratified)) == Approx(-0.71).margin(0.05));
  CHECK(slope(caps(SphereMethod::fibonacci)) == Approx(-0.69).margin(0.05));
}

TEST_CASE("survey: slopes and values on the plane", "[slow]") {
  for (const PlanarRow& row : planar_table) {
    const std::uint64_t runs = row.method == PlanarMethod::random ? 48 : 8;
    INFO(name_of(row.method));
    {
      INFO("boxes");
      compare(run_series(star(row.method), runs, 12288), row.box);
    }
    {
      INFO("triangles");
      compare(run_series(triangles(row.method), runs, 12288), row.triangle);
    }
    {
      INFO("quarter circles");
      compare(run_series(quarter_circles(row.method), runs, 12288), row.quarter_circle);
    }
  }
}

TEST_CASE("survey: placing at curve vertices quantizes the pattern", "[slow]") {
  // Measured before: slope -0.51, D*(12288) 0.0086 with the smallest 4^m >= N leaves; -0.63, 0.0032 with
  // 64 N.
  for (const auto& [leaves, slope, value] : {std::tuple{1.0, -0.51, 0.0086}, {64.0, -0.63, 0.0032}}) {
    PlanarParameters parameters;
    parameters.leaves_per_point = leaves;
    const auto measure = [&](std::uint32_t count, std::uint64_t run) {
      const PlanarPoints points = planar_points(PlanarMethod::hilbert_vertex, count, run, parameters);
      return star_discrepancy_exact(points.x, points.y);
    };
    INFO(leaves << " leaves a point");
    compare(run_series(measure, 8, 12288), {slope, {0, 0, value}});
  }
}

TEST_CASE("survey: slopes and values on the sphere", "[slow]") {
  struct Row {
    SphereMethod method;
    Expected cap, triangle;
  };
  const std::array<Row, 5> table = {{
      // The rate of random points is -1/2; the table's -0.53 for triangles is one mean of 5 runs (next case).
      {SphereMethod::random, {-0.51, {0, .0203, 0}}, {-0.50, {0, .0157, 0}}},
      {SphereMethod::hilbert_stratified, {-0.70, {0, .0057, 0}}, {-0.74, {0, .0038, 0}}},
      {SphereMethod::hammersley, {-0.70, {0, .0039, 0}}, {-0.75, {0, .0024, 0}}},
      {SphereMethod::fibonacci, {-0.69, {0, .0035, 0}}, {-0.73, {0, .0022, 0}}},
      {SphereMethod::spiral, {-0.70, {0, 0, 0}}, {-0.72, {0, .0029, 0}}},
  }};
  for (const Row& row : table) {
    const std::uint64_t runs = row.method == SphereMethod::random ? 32 : 8;
    INFO(name_of(row.method));
    {
      INFO("caps");
      compare(run_series(caps(row.method), runs, 12288), row.cap);
    }
    {
      INFO("triangles");
      compare(run_series(sphere_triangles(row.method), runs, 12288), row.triangle);
    }
  }
}

TEST_CASE("survey: slopes of five runs of random points scatter around -1/2 as in the table", "[slow]") {
  // Measured before: -0.53 for triangles on the sphere, from 5 runs.
  constexpr std::uint64_t groups = 12, runs = 5;
  const Measure measure = sphere_triangles(SphereMethod::random);
  double sum = 0, squares = 0;
  for (std::uint64_t group = 0; group < groups; ++group) {
    const Series series =
        run_series([&](std::uint32_t count, std::uint64_t run) { return measure(count, run + runs * group); },
                   runs, 12288);
    sum += series.slope();
    squares += series.slope() * series.slope();
  }
  const double mean = sum / groups, deviation = std::sqrt((squares - sum * mean) / (groups - 1));
  CAPTURE(mean, deviation);
  CHECK(std::abs(mean + 0.5) < 0.015);
  CHECK(std::abs(mean + 0.53) < 3 * deviation);
}

TEST_CASE("survey: the cap discrepancy of the spiral depends on the axes drawn", "[slow]") {
  // The table has 0.0039 at 4096 from one set of 200 axes; eight sets here give 0.0030 to 0.0034. Few axes
  // see more: 2^14 of them reach twice that. So 0.0039 lies between what 200 axes find on average and what is
  // there.
  const SpherePoints points = sphere_points(SphereMethod::spiral, 4096, 1);
  const ShapeDiscrepancy all = cap_discrepancy(points.x, points.y, points.z, shapes(1u << 14, 1));
  CHECK(all.running_max.front() < 0.0039);
  CHECK(all.discrepancy > 0.0039);
}
