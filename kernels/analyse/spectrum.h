// Power spectrum of planar point sets, averaged over sets (docs/METHODS.md 13.4; Ulichney 1987, "Digital
// Halftoning"; Bartlett 1948 for the averaging).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/radial_profile.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander {

// Sum of the periodograms P(f) = (1/N) |sum_k exp(-2 pi i f . x_k)|^2 of `sets` point sets at the integer
// frequencies |fx|, |fy| <= radius. Integers are the zeros of the unit square's own spectrum, so nothing
// leaks from f = 0, where P = N. White noise has P = 1 elsewhere.
struct PowerSpectrum {
  std::uint32_t radius = 0;
  std::uint32_t sets = 0;
  std::vector<double> sum;  // side x side, rows by fy ascending from -radius; symmetric: P(-f) = P(f)

  std::size_t side() const { return 2 * std::size_t{radius} + 1; }
  // Mean power at (fx, fy); sets > 0.
  double power(std::int64_t fx, std::int64_t fy) const {
    const auto r = static_cast<std::int64_t>(radius);
    return sum[static_cast<std::size_t>(fy + r) * side() + static_cast<std::size_t>(fx + r)] / sets;
  }
};

// An empty spectrum. radius 1..4096: memory is 8 (2 radius + 1)^2 bytes, twice that (plus 32 KiB radius)
// while a set is added.
PowerSpectrum make_power_spectrum(std::uint32_t radius);

// A radius of up to 2.5 sqrt(points), as far as 10^11 multiply-adds a set (some ten seconds of a core) allow.
std::uint32_t affordable_radius(std::size_t points);

// Adds the periodogram of one set. x, y: N coordinates each, in [0, 1) (the sum is periodic, so that others
// of up to about 1000 in size count by their fraction), any order; sets of different N may be averaged, each
// counts once. Error of P: below 1e-12 (1 + sqrt(P)) in units of white noise for radius <= 1000. The sums are
// products of two real matrices of cosines and sines, 4 (radius + 1)^2 N multiply-adds of 0.12 ns in all, in
// fixed order, parallel over rows of frequencies; bench/spectrum_bench.cpp has the time. Deterministic for
// every thread count. Throws std::invalid_argument when the lengths differ, are zero, or a coordinate is not
// finite.
void add_periodogram(PowerSpectrum& spectrum, std::span<const double> x, std::span<const double> y);

// Rings of width 1 of the mean power: ring k holds k + 1/2 <= |f| < k + 3/2, so f = 0 is left out and ring k
// has radius k + 1. White noise: mean 1 and anisotropy -10 log10 sets (dB). Plot over radius / sqrt(N).
// Throws std::invalid_argument without sets.
RadialProfile radial_power(const PowerSpectrum& spectrum);

// Pulled back by a constant tensor S (given as log S; its scale is immaterial: det S is made 1): the
// periodogram of the points S^-1 x at the frequency S f is that of x at f, so nothing needs to be summed
// again and the integers stay free of leakage. Rings are those of |S f|: ellipses of the plain spectrum.
// Where samples are stratified in the metric this is the profile of the isotropic sampling, with the
// anisotropy of white noise.
RadialProfile radial_power(const PowerSpectrum& spectrum, TangentTensor log_spacing);

// Is the pulled-back spectrum the same in all directions? Power in sectors of the angle of S f against e1
// (modulo pi; the first begins at 0), relative to the mean of its ring.
struct AngularPower {
  std::vector<double> sector;       // about 1 each
  std::vector<std::uint32_t> bins;  // pairs of opposite frequencies
  double deviation = 0;             // root mean square of sector - 1, weighted by bins
  // The deviation of an isotropic spectrum, power being exponential with variance mean^2 / sets:
  // sqrt((sectors - 1) / (sets x all bins)).
  double noise = 0;
};
// Rings of width 1 with low <= |S f| < high, counted from low, high at most the last that fits (that of
// radial_power); sectors 2..360. Throws std::invalid_argument without sets, bins or such parameters.
AngularPower angular_power(const PowerSpectrum& spectrum, TangentTensor log_spacing, double low, double high,
                           std::uint32_t sectors = 12);

}  // namespace meander
