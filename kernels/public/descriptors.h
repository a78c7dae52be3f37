// <meander/descriptors.h>: distances between descriptors (histograms, moments, spectra).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// The distance of rows a and b of B numbers:
//   l1      sum |a - b|: twice the total variation of histograms of sum 1
//   l2      sqrt(sum (a - b)^2)
//   emd     sum |A - B| over the running sums A, B: the earth mover's distance in one dimension, in bins, of
//           rows of equal sum (Vallender 1974; Rubner, Tomasi and Guibas 2000); for others the running sums
//           are compared all the same, so that it stays a metric
//   chi2    1/2 sum (a - b)^2 / (|a| + |b|), bins that are zero in both left out; no metric (its root is one
//           for rows that are not negative)
//   cosine  1 - cos(angle between a and b); no metric. A row of zeros has distance 1/2 from every other
//           row but rows of zeros, 0 from those
// All are symmetric and exactly zero between equal rows.
enum class DistanceKind : std::uint8_t { l1, l2, emd, chi2, cosine };

// The distance between two rows of equal length. Relative error about 1e-6, the same bits on every machine.
// Throws std::invalid_argument when the lengths differ, are 0, or a number is not finite. O(B).
float descriptor_distance(std::span<const float> a, std::span<const float> b, DistanceKind kind);

// All distances between n rows of equal length: n x n, row by row. Throws as above, and for no rows. O(n^2
// B), in parallel.
std::vector<float> descriptor_distances(std::span<const std::vector<float>> rows, DistanceKind kind);

}  // namespace meander
