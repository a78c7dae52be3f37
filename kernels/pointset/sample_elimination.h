// Poisson disk sets on surfaces, to compare samplings with.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// Weighted sample elimination (Yuksel 2015, "Sample Elimination for Generating Poisson Disk Sample Sets"):
// of M points in space those are left out, one after the other, that have the most others near them, until
// `count` remain; with the parameters of poisson_disk_points (iterative_points.h). Distances are those in
// space. The points are independent samples of the surface, five times as many as wanted being his choice.
// points: 3 M finite coordinates; area: of the surface, > 0; count: 1..M. Returns the numbers of the points
// that remain, ascending. About 10 us a point that is wanted, 1 KB of memory; serial but for the search of
// neighbors; deterministic. Throws std::invalid_argument for other values.
std::vector<std::uint32_t> eliminate_samples(std::span<const double> points, std::uint32_t count,
                                             double area);

}  // namespace meander
