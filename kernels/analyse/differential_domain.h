// Differential domain analysis: the distribution of differences between samples, for sets whose density or
// anisotropy varies or that lie on surfaces, where no Fourier spectrum exists (Wei and Wang 2011,
// "Differential domain analysis for non-uniform sampling"; docs/METHODS.md 13.5). On surfaces differences are
// approximate geodesic vectors (Bowers, Wang, Wei, Maletz 2010, "Parallel Poisson disk sampling with spectrum
// analysis on surfaces").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernels/analyse/radial_profile.h"
#include "kernels/analyse/tangent_samples.h"
#include "kernels/core/vector3.h"

namespace meander {

struct DifferenceParameters {
  double range = 4;           // the map covers [-range, range]^2, in units of the mean spacing; > 0
  std::uint32_t cells = 128;  // cells along each side of the map, 2..4096
  double kernel = 1;          // standard deviation of the Gaussian kernel, in cells, > 0; cut off at 3
};

// Sum over the point sets added of the density of differences: for every ordered pair of samples k != l a
// Gaussian of mass 1 around its difference. Rows by y ascending; symmetric about the middle.
struct DifferenceMap {
  DifferenceParameters parameters;
  std::uint32_t sets = 0;
  std::vector<double> sum;  // cells x cells: pairs per cell

  std::size_t side() const { return parameters.cells; }
  double cell() const { return 2 * parameters.range / parameters.cells; }  // units of mean spacing
};

// An empty map. Throws std::invalid_argument when a parameter is out of range.
DifferenceMap make_difference_map(const DifferenceParameters& parameters = {});

// The plane, or a torus where a period is given.
struct PlaneDomain {
  double period_x = 0, period_y = 0;  // 0: no period
};

// Common to the functions that add a set of N samples: every pair within reach (sqrt(2) (range + 3 kernels) x
// the smaller spacing) is visited once, in k-d trees, O(N log N + pairs). About 5 us a sample with the
// default map, 14 us on surfaces. Blocks of samples are fixed, so the result does not depend on the thread
// count; each of at most 32 blocks has a map of its own meanwhile. Pairs whose difference lies outside the
// map reach in with the tail of their kernel. N = 0 or 1 adds nothing but the set. All throw
// std::invalid_argument when lengths differ, a number is not finite, a spacing is not positive, or a period
// is smaller than twice the reach.

// Uniform sets: q = (s - s') / spacing, with spacing = sqrt(A / N) for an area A.
void add_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y, double spacing,
                     const PlaneDomain& domain = {});

// Isotropic density: spacing[k] is the wanted mean distance at sample k, proportional to phi^(-1/2);
// q = 2 (s - s') / (r + r'). Pairs with |s - s'| > reach x min(r, r') are left out, so where r varies much
// within the range the outer part of the map is below that of uniform sets: compare with a reference map.
void add_density_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                             std::span<const double> spacing, const PlaneDomain& domain = {});

// Anisotropic: inverse_jacobian holds 4 N numbers, row-major 2 x 2 matrices J^-1 that take a difference to
// units of the mean spacing at the sample; q = (J^-1(s) + J^-1(s')) / 2 (s - s'), as the authors' own code
// does. Pairs are kept while both |J^-1(s) (s - s')| and |J^-1(s') (s - s')| are within reach. Singular
// matrices are refused (std::invalid_argument).
void add_anisotropic_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                                 std::span<const double> inverse_jacobian, const PlaneDomain& domain = {});

enum class DifferenceUnits : std::uint8_t {
  spacings,  // S^-1 d: sets that are stratified in the metric have the same round map for every tensor
  area,      // d / sqrt(s1 s2): the shape of neighborhoods on the surface, see pair_density.h
};

// Tensor fields in the plane: log_spacing holds log S at every sample in the x and y axes of the plane, where
// s1 s2 is the area per sample there (sample_spacing_scale). q = (S^-1(s) + S^-1(s')) / 2 (s - s'), or with
// 1 / sqrt(s1 s2) instead of S^-1, kept while both terms are within reach.
struct TensorDifferenceParameters {
  DifferenceUnits units = DifferenceUnits::spacings;
  // In the plane: x of the map is e1 of either sample; false: x of the plane. On surfaces it is always e1.
  bool principal_axes = true;
  // One value per sample, or empty: pairs count, each for one half, in the frame of samples with values other
  // than 0.
  std::span<const std::uint8_t> counted = {};
  double min_normal_cosine = 0.2;  // on surfaces, as in SurfaceDifferenceParameters
};
void add_anisotropic_differences(DifferenceMap& map, std::span<const double> x, std::span<const double> y,
                                 std::span<const TangentTensor> log_spacing,
                                 const TensorDifferenceParameters& parameters = {},
                                 const PlaneDomain& domain = {});

// Tensor fields on surfaces: v, the geodesic vector from a sample to another one, is geodesic_length() in the
// projected direction; S of the other sample is brought into the tangent plane by the smallest rotation. The
// map is in the frame (e1, e2) of either sample. Cost grows with the largest ratio s1 / s2: balls of s1 are
// searched.
void add_anisotropic_surface_differences(DifferenceMap& map, const TangentSamples& samples,
                                         const TensorDifferenceParameters& parameters = {});

struct SurfaceDifferenceParameters {
  double min_normal_cosine =
      0.2;                 // pairs whose normals differ more are left out: other sheets, folds; [-1, 1]
  std::uint64_t seed = 1;  // of the random tangent frames
};

// Surfaces: points and normals 3 N each (normals of any positive length); spacing N values; frames 3 N first
// axes of the tangent frames (of any length, made orthogonal to the normal; their sign does not matter as the
// map is symmetric), or empty for random frames, which is all that isotropic analysis needs. Each pair counts
// in the frame of either sample: geodesic_length() / mean of the two spacings, in the direction of the other
// sample projected to the tangent plane. Left out: pairs by the rule above, pairs of no direction, and
// lengths beyond reach x min(r, r'). Two layers closer than the range with like normals still count each
// other.
void add_surface_differences(DifferenceMap& map, std::span<const double> points,
                             std::span<const double> normals, std::span<const double> spacing,
                             std::span<const double> frames = {},
                             const SurfaceDifferenceParameters& parameters = {});

// Length of the geodesic from p to q whose unit normals are n_p and n_q: d (asin c1 - asin c2) / (c1 - c2),
// c = n . (p - q) / d, and d / sqrt(1 - c^2) where c1 = c2 (Bowers et al. 2010). Exact on spheres and planes,
// approximate elsewhere; evaluated without cancellation. 0 for p = q; infinite where both normals point
// along p - q the same way (the formula's limit). Pure.
double geodesic_length(Vector3 p, Vector3 n_p, Vector3 q, Vector3 n_q);

// The geodesic vector from p to q in the frame of p: that length in the direction of the chord projected to
// the tangent plane. (0, 0) for p = q; none where the chord has no tangential part. Pure.
std::optional<std::array<double, 2>> geodesic_vector(Vector3 p, const TangentFrame& frame, Vector3 q,
                                                     Vector3 n_q);

// r_k = sqrt(measure / (N phi_k)), the mean spacing of N samples of density phi whose integral over the
// domain is `measure`; at most `largest`. Scaling phi and measure together changes nothing. Throws
// std::invalid_argument when phi is negative or not finite, or measure is not positive; phi = 0 needs a
// finite `largest`.
std::vector<double> spacing_from_density(std::span<const double> density, double measure, double largest);

// The average map of independent uniform samples (sets = 1), to divide by. N samples with spacing = sqrt(A /
// N) on a torus or a closed surface that is nearly flat at the range: N (N - 1) / N pairs per unit of q-area,
// the same in every cell.
DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples);

// The same for a rectangle width x height without period: (1 - |dx| / width)(1 - |dy| / height) times that
// (the rectangle's set covariance), under the same kernel. Error below 1e-3 for cells < 0.1.
DifferenceMap expected_differences(const DifferenceParameters& parameters, std::uint64_t samples,
                                   double width, double height);

// The ratio of mean maps, cells x cells: white noise is 1 (where the expectation is 0: NaN). `expected` comes
// from expected_differences or is a map to which many sets of independent samples of the same density, number
// and domain were added. Throws std::invalid_argument when the parameters differ or either map has no set.
std::vector<double> normalized_differences(const DifferenceMap& map, const DifferenceMap& expected);

// Rings of `width` cells (>= 1) of a normalized map around the middle, the first from 0: multiply radius by
// map.cell() for units of mean spacing. Values of cells closer than the kernel are correlated and the
// number of pairs decides the noise, so the anisotropy of white noise is that of a reference, not -10 log10
// K.
RadialProfile radial_differences(const DifferenceMap& map, std::span<const double> normalized,
                                 double width = 1);

}  // namespace meander
