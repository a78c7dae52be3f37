// Radial mean and anisotropy of a square map around its center (Ulichney 1987, "Digital Halftoning").
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/tensor/tangent_tensor.h"

namespace meander {

// Rings of a map, in units of cells. A map that is symmetric about its center holds every value twice; each
// pair counts as one bin here, so that the variance is that of values that can differ.
struct RadialProfile {
  static constexpr std::uint32_t min_bins = 8;  // rings of fewer bins are noise: do not show them
  std::vector<double> radius;                   // of the middle of the ring, cells
  std::vector<double> mean;                     // NaN where the ring has no bin
  // 10 log10(s^2 / mean^2), s^2 being the unbiased variance over the ring; NaN with fewer than two bins or
  // mean 0, -inf if all are equal.
  std::vector<double> anisotropy_db;
  std::vector<std::uint32_t> bins;  // pairs of opposite cells

  std::size_t rings() const { return radius.size(); }
  bool reliable(std::size_t ring) const { return bins[ring] >= min_bins; }
};

// map: side x side values, symmetric about the middle of the square: value (i, j) equals value (side - 1 - i,
// side - 1 - j), of which only one is read. Ring k holds the cells whose centers lie at a distance in [first
// + k width, first + (k + 1) width) from the middle; first >= 0, width > 0, both in cells. Rings go as far as
// they fit into the square. O(side^2), serial, deterministic. Throws std::invalid_argument when the sizes do
// not fit together.
RadialProfile radial_profile(std::span<const double> map, std::size_t side, double first, double width);

// The same with elliptical rings: the distance of a cell at the offset d from the middle is |stretch d|, for
// a positive definite `stretch` (else std::invalid_argument). Rings go as far as the ellipse fits.
RadialProfile radial_profile(std::span<const double> map, std::size_t side, double first, double width,
                             TangentTensor stretch);

}  // namespace meander
