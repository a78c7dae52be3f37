// References for differences between the samples of a mesh (differential_domain.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/kd_tree.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Adds `sets` sets of `count` independent points, uniform by area in working coordinates, with the normals of
// their triangles. Deterministic by seed. O(sets count log T) and what add_surface_differences takes.
void add_random_surface_differences(DifferenceMap& map, const PreparedMesh& mesh, std::size_t count,
                                    std::uint64_t seed, std::uint32_t sets);

// Points of a surface and what was wanted at them: a density and, of anisotropic ones, a tensor.
struct FieldSamples {
  std::vector<double> points, normals;  // 3 N each, working coordinates; normals of any positive length
  std::vector<double> density;          // N, > 0, up to a common factor
  std::vector<double> axes;             // 3 N directions along the longer spacing, or none: isotropic
  std::vector<double> ratio;            // as many ratios s1 / s2 of the spacings along and across, or none
  std::vector<double> frames;  // 3 N first axes of maps of isotropic sets, or none: random directions

  std::size_t count() const { return density.size(); }
  void append(const FieldSamples& other);  // of the same kind
};

// A field over a mesh that is known only at samples: everywhere it is that of the nearest sample, where
// opposite normals count as a distance of 4 mean spacings, which keeps sheets apart. Sets of n samples of it
// are measured, and random ones of as many points; the map of independent samples over that of the random
// ones is 1. Both are in units of spacings sqrt(integral / (n density)): of sets with the integral of the
// density that was sampled, as their neighbors have it, and of the random ones with that of the field above.
// Spacings over 8 times sqrt(area / n) and densities over 1000 times the mean are taken for these.
class SampledField {
 public:
  // samples: of one or several sets; count: n, of each set. O((N + T + 32 n) log). Keeps the mesh by
  // reference.
  SampledField(const PreparedMesh& mesh, FieldSamples samples, std::size_t count, double integral,
               std::uint64_t seed);

  // Adds a set in units of its spacings: the plain ones of an isotropic field, those along and across.
  void add(DifferenceMap& map, const FieldSamples& set) const { add(map, set, integral_); }
  // Adds independent sets of that field. Deterministic by seed; a point takes max / mean density draws.
  void add_random(DifferenceMap& map, std::uint64_t seed, std::uint32_t sets) const;

 private:
  void add(DifferenceMap& map, const FieldSamples& set, double integral) const;
  std::vector<std::uint32_t> nearest(const std::vector<double>& points,
                                     const std::vector<double>& normals) const;

  const PreparedMesh& mesh_;
  FieldSamples samples_;
  std::size_t count_;
  std::vector<double> cumulative_;  // areas of triangles
  double reach_;                    // half of the distance that opposite normals are worth
  double most_ = 0;                 // largest density
  double integral_, own_ = 0;       // of the density, and of the field that random sets have
  KdTree<6> tree_;                  // of points and of their unit normals times reach_
};

}  // namespace meander
