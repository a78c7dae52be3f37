// Direction-resolved pair density g(q) of samples: how often samples lie at the offset q from another,
// relative to independent ones, and the ellipse that the dip around q = 0 has (docs/METHODS.md 13.6).
//
// Two statements follow from maps of differential_domain.h. In units of area (DifferenceUnits::area) the dip
// is an ellipse whose axis ratio is the ratio s1 / s2 of the field, long along e1: for constant ratios, or
// for the samples of one class of ratios (`counted`). In units of spacings it is round whatever the ratio:
// the scale-free statement, for fields of any kind.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/analyse/differential_domain.h"

namespace meander {

struct DipParameters {
  double start = 0.5;               // standard deviation of the first window, in units of the map, > 0
  double least_signal = 5;          // a dip of less signal-to-noise counts as none; > 0
  bool measured_reference = false;  // `expected` was measured on samples: its noise counts too
  std::uint32_t iterations = 200;   // at most; a window that has not settled by then counts as none
};

// The dip 1 - g around the middle of a map, g being scaled to 1 on average beyond 0.6 of the range: let the
// map reach at least 3 times the dip's standard deviation along (1.2 at ratio 8 in units of area: range 3.5).
struct Dip {
  bool found = false;
  double signal_to_noise = 0;  // of the dip under the first window: about N(0, 1) for independent samples
  // The depth of the dip, as a Gaussian; 1: no sample has another right beside it. If no dip is found, the
  // mean of 1 - g under the first window.
  double depth = 0;
  // Where found, else 0: standard deviations (moments) or half-axes (contour) along and across the long axis,
  // units of the map; their ratio >= 1; the angle of the long axis against the map's x axis in (-pi/2, pi/2].
  double first = 0, second = 0, ratio = 0, angle = 0;
};

// By adaptive moments (Bernstein and Jarvis 2002, "Shapes and shears, stars and smears"): second moments of
// the dip under a Gaussian window that is refined until its own covariance is the dip's. The result turns and
// stretches with the dip: an affine image of a dip with fourfold symmetry gives the ratio of that map. The
// kernel's spread is taken off; it should be small against the dip (at ratio 8 that is 0.15 across, in units
// of area). Root mean square error of log ratio: at most about 2 / signal_to_noise (jittered samples of
// ratios 1 to 8, signals 9 to 60; round dips come out above 1 by as much), two to four times that by the
// contour. `expected` as for normalized_differences; on domains with a boundary it should be measured on
// independent samples in the same field. O(cells^2 iterations). Throws std::invalid_argument when a parameter
// is out of range, the maps' parameters differ or one has no set.
Dip dip_moments(const DifferenceMap& map, const DifferenceMap& expected,
                const DipParameters& parameters = {});

// By the contour at half the depth of the dip: where rays in 64 directions (even in the frame where the dip
// of dip_moments is round) first meet it, and the ellipse with the second moments of the area inside. Free of
// the dip's outskirts and of rings around it, but noisier, and widened by the kernel. What is not given by
// the contour is that of dip_moments; without a contour inside the map nothing is found.
Dip dip_contour(const DifferenceMap& map, const DifferenceMap& expected,
                const DipParameters& parameters = {});

// Points of the ellipse at half the depth of a Gaussian dip whose standard deviations are those of `dip`, in
// units of the map around its middle: `count` points counter-clockwise, evenly by eccentric angle, the first
// on the long axis. Needs a dip that was found. Pure.
std::vector<std::array<double, 2>> half_depth_ellipse(const Dip& dip, std::size_t count);

// Classes of the ratio s1 / s2: the number of edges <= ratio per sample; edges ascending. With it choose the
// samples to count. Throws std::invalid_argument when lengths differ or edges do not ascend.
std::vector<std::uint32_t> ratio_classes(std::span<const double> s1, std::span<const double> s2,
                                         std::span<const double> edges);

// The expectation for `counted` of `samples` samples on a surface without boundary that is nearly flat at the
// range: expected_differences times their share.
DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples,
                                   std::uint64_t counted);

}  // namespace meander
