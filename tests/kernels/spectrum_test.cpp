#include "kernels/analyse/spectrum.h"

#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "kernels/core/random.h"
#include "kernels/model/model_sampler.h"
#include "support/catch.h"
#include "support/metric_samples.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

double direct_power(const PlanarSamples& set, double fx, double fy) {
  std::complex<double> sum = 0;
  for (std::size_t i = 0; i < set.x.size(); ++i)
    sum += std::polar(1.0, -2 * std::numbers::pi * (fx * set.x[i] + fy * set.y[i]));
  return std::norm(sum) / static_cast<double>(set.x.size());
}

double squared_sinc(double t) {
  if (t == 0) return 1;
  const double s = std::sin(std::numbers::pi * t) / (std::numbers::pi * t);
  return s * s;
}

}  // namespace

TEST_CASE("add_periodogram: equals the direct sum") {
  double worst = 0;
  for (const std::size_t n :
       {std::size_t{1}, std::size_t{2}, std::size_t{255}, std::size_t{256}, std::size_t{1500}})
    for (const std::uint32_t radius : {1u, 2u, 21u}) {
      const PlanarSamples set = random_samples(n, n + radius);
      PowerSpectrum spectrum = make_power_spectrum(radius);
      add_periodogram(spectrum, set.x, set.y);
      const int r = static_cast<int>(radius);
      for (int fy = -r; fy <= r; ++fy)
        for (int fx = -r; fx <= r; ++fx) {
          const double direct = direct_power(set, fx, fy), found = spectrum.power(fx, fy);
          worst = std::max(worst, std::abs(found - direct) / (1 + std::sqrt(direct)));
          REQUIRE(found == Approx(direct).epsilon(1e-12).margin(1e-12));
        }
      CHECK(spectrum.power(0, 0) == Approx(static_cast<double>(n)).epsilon(1e-14));
    }
  CHECK(worst < 1e-12);
}

TEST_CASE("add_periodogram: high frequencies keep their precision") {
  const PlanarSamples set = random_samples(300, 5);
  PowerSpectrum spectrum = make_power_spectrum(400);
  add_periodogram(spectrum, set.x, set.y);
  double worst = 0;
  for (int k = 0; k < 400; ++k) {
    const int fx = (k * 379) % 801 - 400, fy = (k * 211) % 801 - 400;
    const double direct = direct_power(set, fx, fy);
    worst = std::max(worst, std::abs(spectrum.power(fx, fy) - direct) / (1 + std::sqrt(direct)));
  }
  CHECK(worst < 2e-12);  // the direct sum errs itself
}

TEST_CASE("add_periodogram: has the expected symmetries and invariances") {
  const PlanarSamples set = random_samples(700, 9);
  PlanarSamples shifted = set, mirrored = set, swapped{set.y, set.x};
  for (double& x : shifted.x) x = x + 0.375 - std::floor(x + 0.375);
  for (double& x : mirrored.x) x = 1 - x;
  PowerSpectrum a = make_power_spectrum(12), b = a, c = a, d = a;
  add_periodogram(a, set.x, set.y);
  add_periodogram(b, shifted.x, shifted.y);
  add_periodogram(c, mirrored.x, mirrored.y);
  add_periodogram(d, swapped.x, swapped.y);
  for (int fy = -12; fy <= 12; ++fy)
    for (int fx = -12; fx <= 12; ++fx) {
      CHECK(a.power(-fx, -fy) == a.power(fx, fy));
      CHECK(b.power(fx, fy) == Approx(a.power(fx, fy)).margin(1e-11));
      CHECK(c.power(-fx, fy) == Approx(a.power(fx, fy)).margin(1e-11));
      CHECK(d.power(fy, fx) == Approx(a.power(fx, fy)).margin(1e-11));
    }
}

TEST_CASE("add_periodogram: a lattice has N at its reciprocal lattice and nothing elsewhere") {
  PlanarSamples set;
  for (int i = 0; i < 16; ++i)
    for (int j = 0; j < 16; ++j) {
      set.x.push_back((i + 0.3) / 16);
      set.y.push_back((j + 0.7) / 16);
    }
  PowerSpectrum spectrum = make_power_spectrum(33);
  add_periodogram(spectrum, set.x, set.y);
  for (int fy = -33; fy <= 33; ++fy)
    for (int fx = -33; fx <= 33; ++fx)
      CHECK(spectrum.power(fx, fy) == Approx(fx % 16 == 0 && fy % 16 == 0 ? 256 : 0).margin(1e-11));
}

TEST_CASE("radial_power: white noise has power 1 and anisotropy -10 log10 K") {
  constexpr int sets = 10;
  PowerSpectrum spectrum = make_power_spectrum(40);
  for (std::uint64_t seed = 0; seed < sets; ++seed) {
    const PlanarSamples set = random_samples(1024, 100 + seed);
    add_periodogram(spectrum, set.x, set.y);
  }
  const RadialProfile profile = radial_power(spectrum);
  REQUIRE(profile.rings() == 40);
  double ratio = 0, weight = 0;
  for (std::size_t k = 0; k < profile.rings(); ++k) {
    CHECK(profile.radius[k] == static_cast<double>(k + 1));
    if (!profile.reliable(k)) continue;
    // A bin has mean 1 and variance 1 / K.
    CHECK(profile.mean[k] == Approx(1).margin(4.5 / std::sqrt(sets * profile.bins[k])));
    ratio += profile.bins[k] * std::pow(10, 0.1 * profile.anisotropy_db[k]);
    weight += profile.bins[k];
  }
  CHECK_FALSE(profile.reliable(0));
  CHECK_FALSE(profile.reliable(1));
  CHECK(profile.reliable(2));
  // Bins in all: 2500; the relative deviation of their variance is sqrt((2 + 6 / K) / 2500) = 0.032.
  CHECK(ratio / weight == Approx(1.0 / sets).epsilon(4 * 0.032));
}

TEST_CASE("radial_power: jittered grids follow 1 - sinc^2 sinc^2") {
  constexpr std::size_t side = 16;
  constexpr int sets = 60;
  constexpr int radius = 32;
  PowerSpectrum spectrum = make_power_spectrum(radius);
  for (std::uint64_t seed = 0; seed < sets; ++seed) {
    const PlanarSamples set = grid_samples(side, 300 + seed);
    add_periodogram(spectrum, set.x, set.y);
  }
  // At the integers the mean of the sum over strata vanishes (but for multiples of the side in both axes,
  // where sinc does as well unless f = 0), so this is the expectation exactly.
  double chi = 0;
  std::size_t bins = 0;
  std::vector<double> expected(spectrum.sum.size(), 1.0);
  for (int fy = -radius; fy <= radius; ++fy)
    for (int fx = -radius; fx <= radius; ++fx) {
      const double e =
          1 - squared_sinc(fx / static_cast<double>(side)) * squared_sinc(fy / static_cast<double>(side));
      expected[static_cast<std::size_t>(fy + radius) * spectrum.side() +
               static_cast<std::size_t>(fx + radius)] = e;
      if (fx == 0 && fy == 0) continue;
      const double z = (spectrum.power(fx, fy) / e - 1) * std::sqrt(sets);
      chi += z * z;
      ++bins;
    }
  // Bins on the axes and at half the side are not circular and vary up to twice as much: 5 % of them.
  CHECK(chi / static_cast<double>(bins) == Approx(1.03).margin(0.12));
  const RadialProfile found = radial_power(spectrum);
  const RadialProfile exact = radial_profile(expected, spectrum.side(), 0.5, 1);
  for (std::size_t k = 2; k < found.rings(); ++k)
    CHECK(found.mean[k] ==
          Approx(exact.mean[k]).epsilon(5 / std::sqrt(static_cast<double>(sets) * found.bins[k])));
}

TEST_CASE("radial_power: the spikes of a regular lattice show as anisotropy") {
  PlanarSamples set;
  for (int i = 0; i < 256; ++i) {
    set.x.push_back((i % 16 + 0.5) / 16);
    set.y.push_back((i / 16 + 0.5) / 16);
  }
  PowerSpectrum spectrum = make_power_spectrum(20);
  add_periodogram(spectrum, set.x, set.y);
  const RadialProfile profile = radial_power(spectrum);
  CHECK(profile.anisotropy_db[15] > 10);  // |f| = 16: 2 of 50 bins hold 256, the others 0
  CHECK(profile.mean[15] == Approx(512.0 / profile.bins[15]));
}

TEST_CASE("radial_profile: rings, variance and mirror of a small map") {
  // 5 x 5, the middle excluded: ring 0 has the pairs at distance 1 and sqrt 2, ring 1 those at 2 and sqrt 5.
  std::vector<double> map(25, 0.0);
  const auto set = [&](int x, int y, double value) {
    map[static_cast<std::size_t>(5 * (y + 2) + x + 2)] = value;
    map[static_cast<std::size_t>(5 * (2 - y) + 2 - x)] = value;
  };
  set(0, 0, 100);
  set(1, 0, 1);
  set(0, 1, 2);
  set(1, 1, 3);
  set(-1, 1, 6);
  const RadialProfile profile = radial_profile(map, 5, 0.5, 1);
  REQUIRE(profile.rings() == 2);
  CHECK(profile.radius[0] == 1);
  CHECK(profile.bins[0] == 4);
  CHECK(profile.mean[0] == 3);
  CHECK(profile.anisotropy_db[0] == Approx(10 * std::log10((4 + 1 + 0 + 9) / 3.0 / 9)));
  CHECK(profile.bins[1] == 6);
  CHECK(profile.mean[1] == 0);
  CHECK(std::isnan(profile.anisotropy_db[1]));
  // From 0 the middle is a bin of its own; with rings of half a cell it is alone.
  const RadialProfile fine = radial_profile(map, 5, 0, 0.5);
  CHECK(fine.bins[0] == 1);
  CHECK(fine.mean[0] == 100);
  CHECK(fine.bins[1] == 0);
  CHECK(std::isnan(fine.mean[1]));
  // An even map has no cell in the middle.
  const RadialProfile even = radial_profile(std::vector<double>(16, 2.0), 4, 0, 1);
  CHECK(even.bins == std::vector<std::uint32_t>{2, 4});
  CHECK(even.anisotropy_db[1] == -std::numeric_limits<double>::infinity());
}

TEST_CASE("radial_power: stratified samples along the Hilbert curve have the spectrum of stratified noise") {
  const PolygonMesh square = test::grid_plane(8, 8);
  std::vector<double> positions;
  for (std::size_t v = 0; v < square.x.size(); ++v)
    positions.insert(positions.end(), {square.x[v], square.y[v], square.z[v]});
  std::vector<std::uint32_t> faces;
  for (std::size_t p = 0; p < square.polygon_count(); ++p) {
    REQUIRE(square.polygon_begin[p + 1] - square.polygon_begin[p] == 3);
    faces.insert(faces.end(), square.corners.begin() + square.polygon_begin[p],
                 square.corners.begin() + square.polygon_begin[p + 1]);
  }
  constexpr int sets = 10;
  PowerSpectrum spectrum = make_power_spectrum(66);
  for (std::uint64_t seed = 1; seed <= sets; ++seed) {
    SampleParameters parameters = parameters_for("conformal");
    parameters.seed = seed;
    parameters.samples = 1024;
    parameters.sequence = SequenceKind::stratified;
    const Row row = ModelSampler(parameters).sample(polygon_mesh_of({positions, faces}));
    PlanarSamples set;
    for (std::size_t i = 0; i < 1024; ++i) {
      set.x.push_back(row.samples.points[3 * i]);
      set.y.push_back(row.samples.points[3 * i + 1]);
    }
    add_periodogram(spectrum, set.x, set.y);
  }
  const RadialProfile profile = radial_power(spectrum);
  const double at[7] = {0.1, 0.25, 0.5, 0.75, 1, 1.5, 2};
  const double expected[7] = {0.038, 0.20, 0.61, 0.87, 0.98, 0.96, 1.00};
  for (std::size_t k = 0; k < 7; ++k) {
    const auto ring = static_cast<std::size_t>(std::lround(32 * at[k])) - 1;
    // The expectation is itself measured, from few runs: 10 %.
    CHECK(profile.mean[ring] ==
          Approx(expected[k]).epsilon(0.1 + 4 / std::sqrt(static_cast<double>(sets) * profile.bins[ring])));
  }
}

TEST_CASE("add_periodogram: one thread and many give the same bits") {
  const PlanarSamples set = random_samples(3000, 77);
  PowerSpectrum many = make_power_spectrum(50), one = many;
  add_periodogram(many, set.x, set.y);
  oneapi::tbb::task_arena(1).execute([&] { add_periodogram(one, set.x, set.y); });
  CHECK(many.sum == one.sum);
}

TEST_CASE("spectrum: invalid arguments are refused") {
  CHECK_THROWS_AS(make_power_spectrum(0), std::invalid_argument);
  CHECK_THROWS_AS(make_power_spectrum(5000), std::invalid_argument);
  PowerSpectrum spectrum = make_power_spectrum(3);
  CHECK_THROWS_AS(radial_power(spectrum), std::invalid_argument);
  const std::vector<double> one{0.5}, two{0.5, 0.25}, bad{std::nan("")};
  CHECK_THROWS_AS(add_periodogram(spectrum, one, two), std::invalid_argument);
  CHECK_THROWS_AS(add_periodogram(spectrum, {}, {}), std::invalid_argument);
  CHECK_THROWS_AS(add_periodogram(spectrum, one, bad), std::invalid_argument);
  CHECK(spectrum.sets == 0);
  CHECK_THROWS_AS(radial_profile(two, 2, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(radial_profile(one, 1, 0, 0), std::invalid_argument);
}
