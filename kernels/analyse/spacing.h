// Distances between neighboring samples, and from a domain to its samples: how well spread a set is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace meander {

// All distances are exact (double, k-d tree; the same as comparing all pairs), in the units of the points.
// Points are taken as x, y spans in the plane, or as 3 n interleaved coordinates in space. A period > 0 makes
// that axis of the plane a circle (coordinates are then taken by their remainder; distances are to the
// nearest image). All throw std::invalid_argument when lengths do not fit or a number is not finite. About
// 0.5 us a point; deterministic, parallel in fixed blocks.

// Distance of every point to the nearest other point; 0 for repeated points. n >= 2.
std::vector<double> nearest_distances(std::span<const double> x, std::span<const double> y,
                                      double period_x = 0, double period_y = 0);
std::vector<double> nearest_distances(std::span<const double> points);

// Distance of every reference point to the nearest sample; at least one sample.
std::vector<double> distances_to_samples(std::span<const double> x, std::span<const double> y,
                                         std::span<const double> reference_x,
                                         std::span<const double> reference_y, double period_x = 0,
                                         double period_y = 0);
std::vector<double> distances_to_samples(std::span<const double> points, std::span<const double> reference);

// Largest distance that n points can keep on area A when edges do not matter: sqrt(2 A / (sqrt(3) n)), the
// hexagonal lattice (Lagae and Dutre 2008, "A comparison of methods for generating Poisson disk
// distributions"). area > 0, n > 0.
double hexagonal_spacing(double area, std::uint64_t n);
// The largest and the mean distance of the plane to that lattice, whose Voronoi cells are regular hexagons:
// spacing / sqrt(3), and that times 1 / 3 + log(3) / 4. No set of the plane has less of either (Fejes Toth
// 1953, "Lagerungen in der Ebene, auf der Kugel und im Raum").
double hexagonal_hole(double area, std::uint64_t n);
double hexagonal_mean_distance(double area, std::uint64_t n);

struct Spacing {
  double min = 0, mean = 0;  // of the nearest-neighbor distances
  double rho = 0;            // min / hexagonal_spacing: 0 random, 0.65-0.85 good Poisson disk, 1 hexagonal
};
// distances: of nearest_distances; area: of the domain (surface area in space). On curved or bounded domains
// rho can exceed the flat limit a little for small n.
Spacing spacing_of(std::span<const double> distances, double area);

}  // namespace meander
