// Samples for one direction of view: dense along the silhouette, none on the back, and as many as the model
// looks large. All views thin one progressive set, so that samples come and go but never move.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

// n samples in progressive order, by component: sample i is the i-th of the set.
struct ViewedSamples {
  std::span<const float> nx, ny, nz;  // n unit normals that point outwards
  std::span<const float> area;        // n: of the surface that a sample stands for
};

struct ViewDetailParameters {
  double least = 0.1;           // weight of a sample that faces the eye, that of the silhouette being 1; 0..1
  bool both_sides = false;      // samples that face away are weighted by |n . v| too, instead of left out
  double fade = 0.35;           // of those that face away: where n . v reaches -fade none is left, 0..1
  double samples_per_area = 1;  // samples of a view over the projected area of the model, > 0
};

// The weight of a sample: least + (1 - least) (1 - |n . v|)^4; unless both_sides, a sample that faces away
// has (1 - |n . v| / fade)^2, and 0 from n . v = -fade on. The fade keeps a margin behind the silhouette that
// no picture shows. Without it a flat part, whose samples all turn over the silhouette in the same step,
// would lose them at once, and one that comes into view take the samples of all others: a pure function of
// the view has no other way to let them come and go by and by. v: any length.
float view_weight(Vector3 normal, Vector3 v, const ViewDetailParameters& parameters);

// The mean of view_weight over all directions of v.
double mean_view_weight(const ViewDetailParameters& parameters);

struct ViewDetail {
  double weight_sum = 0;            // over all samples
  double projected_area = 0;        // sum of area x |n . v| of those that face the eye, whatever hides them
  double share = 0;                 // per unit weight: a sample is kept with the share min(1, share x weight)
  std::vector<std::uint32_t> kept;  // ascending
};

// Keeps sample i if (i + 1/2) / n < share x weight: around every point the kept samples are the first ones of
// the progressive set, and they stay while the share does. share = samples_per_area x projected_area /
// weight_sum, so that this number is kept unless the set is too small for the densest parts. towards: from
// the model to the eye, any length. O(n) in one pass of independent terms, sums in fixed blocks; parallel,
// the same for any number of threads. Throws std::invalid_argument when the sizes do not fit.
ViewDetail view_detail(const ViewedSamples& samples, Vector3 towards,
                       const ViewDetailParameters& parameters = {});

// How many of `before` are in `after` too; both ascending.
std::size_t samples_that_stay(std::span<const std::uint32_t> before, std::span<const std::uint32_t> after);

}  // namespace meander
