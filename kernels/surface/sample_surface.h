// Sampling of parametric surfaces along an adaptive space-filling curve (docs/METHODS.md 10), after Quinn et
// al. 2006.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/curve/curve_key.h"
#include "kernels/sample/place_samples.h"
#include "kernels/surface/surface.h"

namespace meander {

// The density phi of a point. uniform: 1. mean, gaussian, max: the absolute curvature c of the point, as
// floor + (1 - floor) min(1, c / c_q)^exponent, with c_q the quantile by area (over the bent part alone where
// that is smaller); a flat surface is uniform. expression: a non-negative function of u, v, x, y, z as text
// (see expression.h); values from -1e-12 to 0 count as 0.
enum class SurfaceDensityKind : std::uint8_t { uniform, mean, gaussian, max, expression };

struct SurfaceDensity {
  SurfaceDensityKind kind = SurfaceDensityKind::uniform;
  std::string expression;  // for the kind expression: the text or the name of a preset
  double floor = 0.02;     // density of flat parts for the curvature kinds, in (0, 1]
  double exponent = 1.0;   // of the curvature kinds, 0.25..4
  double quantile = 0.99;  // share of the area with a density below 1, at whose curvature others are clamped
};

struct SurfaceSampleParameters {
  std::uint32_t samples = 2048;  // N, 1..2^31
  std::uint64_t seed = 1;
  CurveKind curve = CurveKind::hilbert;
  SequenceKind sequence = SequenceKind::shifted;
  OrderKind order = OrderKind::progressive;
  PlaceKind place = PlaceKind::element;         // vertex: the center of the leaf, as Quinn et al.
  double jitter = 0.25;                         // s of the shifted sequence, 0..1
  SpacingKind spacing = SpacingKind::standard;  // of the spaced sequence
  FinishKind finish = FinishKind::none;         // relax: see relax_on_surface
  SurfaceDensity density;
  double tolerance = 1e-3;  // relative error of the measures that the tree is built on, 1e-8..0.1
  // kappa, 1..1024: a leaf weighs at most total / (kappa N). 0: 4, or 64 for PlaceKind::vertex.
  double leaves_per_sample = 0;
  int min_depth = 5;            // in Hilbert levels (see curve_depth), 5..max_depth
  int max_depth = 24;           // min_depth..31
  bool reparameterize = false;  // lay the curve over the square warped by area x density (extreme stretch)
};

// Returns all problems of the parameters, one sentence each; empty when they are valid.
std::vector<std::string> validate(const SurfaceSampleParameters& parameters);

// Throws std::invalid_argument with all problems that `validate` finds.
void require_valid(const SurfaceSampleParameters& parameters);

// N points in file order (progressive, or along the curve).
struct SurfaceSamples {
  std::vector<float> points;              // 3 N, distinct; coordinates of the surface = loc + scale * point
  std::vector<float> normals;             // 3 N unit vectors along du x dv
  std::vector<float> density;             // N density values at the samples
  std::vector<double> uv;                 // 2 N, in [0, 1]; the points are f(uv) in float32, by `frame`
  std::vector<std::uint32_t> curve_rank;  // N positions along the curve, a permutation of 0 .. N - 1
  OutputFrame frame;                      // see float_frame; the box is that of a grid over the surface
  double area = 0, measure = 0;           // area; area x density: relative error about the tolerance or less
  std::uint64_t patches = 0;              // nodes at which the surface was evaluated
  std::uint64_t leaves = 0;               // leaves of the curve (nodes below a patch follow its polynomial)
  std::uint64_t unresolved_patches = 0;   // coarser than the tolerance: too deep or too many
  // Draws whose measure exceeded the bound of their leaf; not counted for the sequence spaced.
  std::uint64_t bound_violations = 0;
  std::uint64_t coincident_points = 0;  // samples that coincide in float32 after 64 redraws
  Notes notes;                          // of samples that the finish left where they were

  std::size_t count() const { return curve_rank.size(); }
};

// Samples a surface: E[samples in X] = N mu(X) / mu(M) for every part X, mu = area x density, up to the
// tolerance of the measures.
//
// The curve's tree grows level by level. A node's measure is the 3 x 3 Gauss-Legendre rule; it is split
// while the 2 x 2 rule, or the biquadratic polynomial through the nine values at the corners and the 2 x 2
// points, differs by more than the tolerance. Below such a patch the tree continues on the polynomial's
// exact integrals, down to leaves of total / (kappa N), without evaluating the surface. Inside a leaf the
// point is drawn by rejection against 1.1 x the largest value.
//
// Randomness is a pure function of (seed, content of the surface, index). Cost: about 20 evaluations a
// patch (a few thousand patches on smooth surfaces), and 1.1 to 1.5 a sample. Deterministic for every
// thread count, thread-safe.
//
// Throws std::invalid_argument when `validate` finds a problem; ItemError: zero_area, zero_density (the
// density is zero everywhere), non_finite (the surface), unreadable (the density is negative or not finite
// somewhere, with the point in the sentence); timeout and RunCanceled.
SurfaceSamples sample_surface(const ParametricSurface& surface, const SurfaceSampleParameters& parameters,
                              const CancelToken& cancel = {});

}  // namespace meander
