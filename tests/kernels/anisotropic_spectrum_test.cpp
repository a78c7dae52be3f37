#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/analyse/spectrum.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "tests/support/metric_samples.h"

using namespace meander;
using namespace meander::test;

TEST_CASE("radial_profile: elliptical rings") {
  constexpr std::size_t side = 31;
  const TangentTensor stretch = exponential(log_spacing(3, 0.5));
  std::vector<double> map(side * side);
  for (std::size_t c = 0; c < map.size(); ++c) {
    const double dx = static_cast<double>(c % side) - 15, dy = static_cast<double>(c / side) - 15;
    map[c] = std::hypot(stretch.xx * dx + stretch.xy * dy, stretch.xy * dx + stretch.yy * dy);
  }
  const RadialProfile profile = radial_profile(map, side, 0, 1, stretch);
  // The last ring fits: |d| in an axis is at most rho sqrt of an entry of stretch^-2.
  const TangentTensor back = exponential(-2.0 * log_spacing(3, 0.5));
  CHECK(profile.rings() == static_cast<std::size_t>(15.5 / std::sqrt(std::max(back.xx, back.yy))));
  std::size_t bins = 0;
  for (std::size_t k = 0; k < profile.rings(); ++k) {
    if (profile.bins[k] == 0) continue;
    CHECK(profile.mean[k] >= static_cast<double>(k));
    CHECK(profile.mean[k] < static_cast<double>(k) + 1);
    bins += profile.bins[k];
  }
  // Half the cells of an ellipse of area pi rho^2: the stretch keeps area.
  const auto rho = static_cast<double>(profile.rings());
  CHECK(static_cast<double>(bins) == Approx(0.5 * std::numbers::pi * rho * rho).epsilon(0.1));
  CHECK_THROWS_AS(radial_profile(map, side, 0, 1, {1, 2, 1}), std::invalid_argument);
  CHECK_THROWS_AS(radial_profile(map, side, 0, 1, {-1, 0, -1}), std::invalid_argument);
}

TEST_CASE("angular_power: strata of the metric look isotropic once pulled back") {
  constexpr std::uint32_t sets = 10;
  for (const double ratio : {1.0, 2.0, 4.0, 8.0})
    for (const double angle : {0.0, 0.5, 2.2}) {
      if (sanitized && angle != (ratio < 4 ? 2.2 : 0.5))
        continue;  // release builds turn all ratios by all angles
      INFO("ratio " << ratio << " angle " << angle);
      const TangentTensor tensor = log_spacing(ratio, angle);
      PowerSpectrum spectrum = make_power_spectrum(96);
      double points = 0;
      for (std::uint64_t s = 0; s < sets; ++s) {
        // Turned grids, so that the fourfold symmetry of one does not show.
        const PlanarSamples set = jittered_samples(512, tensor, 0.3 * static_cast<double>(s), 20 + s);
        points += static_cast<double>(set.x.size()) / sets;
        add_periodogram(spectrum, set.x, set.y);
      }
      const TangentTensor scaled = tensor + TangentTensor{-4, 0, -4};  // the scale does not matter
      const RadialProfile rings = radial_power(spectrum, scaled);
      REQUIRE(rings.rings() > 30);
      // Jittered sampling, P = 1 - sinc^2 sinc^2.
      const double root = std::sqrt(points);
      const auto ring_at = [&](double f) { return static_cast<std::size_t>(std::lround(f * root)) - 1; };
      CHECK(rings.mean[ring_at(0.25)] == Approx(0.20).margin(0.09));
      CHECK(rings.mean[ring_at(0.5)] == Approx(0.58).margin(0.12));
      CHECK(rings.mean[ring_at(1)] == Approx(0.98).margin(0.1));
      CHECK(rings.anisotropy_db[ring_at(1)] == Approx(-10).margin(2));

      const double high = std::floor(0.8 * root);
      const AngularPower back = angular_power(spectrum, scaled, 2.5, high);
      REQUIRE(back.sector.size() == 12);
      // chi-square of 11 degrees over 11: within 0.2 .. 3 but for 2e-3.
      CHECK(back.deviation > 0.45 * back.noise);
      CHECK(back.deviation < 1.75 * back.noise);
      if (ratio == 1) continue;
      const AngularPower plain = angular_power(spectrum, {}, 2.5, high);
      CHECK(plain.deviation > 3 * plain.noise);
    }
}

TEST_CASE("angular_power: white noise under any tensor, and its noise estimate") {
  double squares = 0;
  constexpr int repeats = 30;
  for (std::uint64_t r = 0; r < repeats; ++r) {
    PowerSpectrum spectrum = make_power_spectrum(40);
    for (std::uint64_t s = 0; s < 3; ++s) {
      const PlanarSamples set = random_samples(200, 100 * r + s);
      add_periodogram(spectrum, set.x, set.y);
    }
    const AngularPower power = angular_power(spectrum, log_spacing(2, 1.0), 1.5, 20.5, 8);
    squares += power.deviation * power.deviation / (power.noise * power.noise * repeats);
  }
  // Mean of 30 x 7 squares of unit variance: standard deviation sqrt(2 / 210) = 0.1.
  CHECK(squares == Approx(1).margin(0.35));
}

TEST_CASE("angular_power: sectors are counted from e1") {
  // Lines across e1 = 0.4: power at frequencies along e1 only.
  PlanarSamples set = random_samples(4000, 9);
  PlanarSamples lines;
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    const double along = std::cos(0.4) * set.x[i] + std::sin(0.4) * set.y[i];
    if (along * 20 - std::floor(along * 20) > 0.5) continue;
    lines.x.push_back(set.x[i]);
    lines.y.push_back(set.y[i]);
  }
  PowerSpectrum spectrum = make_power_spectrum(48);
  add_periodogram(spectrum, lines.x, lines.y);
  // A tensor that is all but isotropic: only its direction matters.
  const AngularPower power = angular_power(spectrum, log_spacing(1.0001, 0.4), 15.5, 24.5, 9);
  const double first = power.sector.front() + power.sector.back();
  for (std::size_t k = 1; k < 8; ++k) CHECK(power.sector[k] < 0.25 * first);
}

TEST_CASE("angular_power: invalid arguments are refused") {
  PowerSpectrum spectrum = make_power_spectrum(8);
  CHECK_THROWS_AS(angular_power(spectrum, {}, 0.5, 4), std::invalid_argument);
  CHECK_THROWS_AS(radial_power(spectrum, TangentTensor{}), std::invalid_argument);
  const std::vector<double> x = {0.1, 0.4, 0.8};
  add_periodogram(spectrum, x, x);
  CHECK_NOTHROW(angular_power(spectrum, {}, 0.5, 8.5));
  CHECK_THROWS_AS(angular_power(spectrum, {}, 0.5, 9.5), std::invalid_argument);
  CHECK_THROWS_AS(angular_power(spectrum, log_spacing(4, 0), 0.5, 8.5), std::invalid_argument);
  CHECK_THROWS_AS(angular_power(spectrum, {}, 0, 4), std::invalid_argument);
  CHECK_THROWS_AS(angular_power(spectrum, {}, 2, 2.5), std::invalid_argument);
  CHECK_THROWS_AS(angular_power(spectrum, {}, 0.5, 4, 1), std::invalid_argument);
}
