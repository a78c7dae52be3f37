// Distances between two triangle meshes by sampling, in the manner of Metro (Cignoni, Rocchini, Scopigno
// 1998, "Metro: measuring error on simplified surfaces"). See docs/METHODS.md 13.8.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/vector3.h"
#include "kernels/rays/embree_locator.h"

namespace meander {

// A triangle mesh as arrays: V positions, 3 T vertex numbers.
struct TriangleSpans {
  std::span<const double> x, y, z;
  std::span<const std::uint32_t> triangles;
};

struct MeshDistanceParameters {
  std::uint64_t samples = 0;  // on each surface; 0: by the density below. At most 2^32 - 1
  double density = 100000;    // samples per squared bounding-box diagonal of the surface sampled
  std::uint64_t seed = 1;
};

// From one surface to the other, in file units. The three are different measures: what the literature calls
// (symmetric) Hausdorff distance is the (larger) max; some authors report the mean under that name.
struct OneSidedDistance {
  double mean = 0, rms = 0;   // over area: the vertices do not take part
  double max = 0;             // over the area samples and all vertices in use: a lower bound of the Hausdorff
  Vector3 farthest;           // distance, too small by at most the coverage radius of the samples (about
  std::uint64_t samples = 0;  // 1.4 x sample_spacing). farthest: where
  std::uint64_t vertices = 0;
  double sample_spacing = 0;  // sqrt(area / samples)
};

struct MeshDistance {
  OneSidedDistance forward, backward;  // I to II, II to I
  double diagonal = 0;                 // of the bounding box of the used vertices of I

  double percent(double distance) const { return 100 * distance / diagonal; }
  double max() const { return forward.max > backward.max ? forward.max : backward.max; }
};

// Area samples are stratified: the area, in order along the 3-D Hilbert curve over the triangles, is cut into
// equal parts with one sample each, and the samples of one triangle form a low-discrepancy set with a random
// shift. Distances are exact for each sample (see SurfaceLocator). Pure in (meshes, parameters); parallel in
// fixed blocks; about 1 us a sample and direction. Throws ItemError(zero_area) where a mesh has no area, and
// what SurfaceLocator throws.
MeshDistance mesh_distance(const EmbreeDevice& device, const TriangleSpans& first,
                           const TriangleSpans& second, const MeshDistanceParameters& parameters = {},
                           const CancelToken& cancel = {});

// The points that mesh_distance measures from, 3 n interleaved: stratified by area, without the vertices.
std::vector<double> area_samples(const TriangleSpans& mesh, std::uint64_t samples, std::uint64_t seed);

}  // namespace meander
