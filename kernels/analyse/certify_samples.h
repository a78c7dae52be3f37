// The quality of a model's own samples, as descriptors of its row.
#pragma once

#include <string>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

// The measures of certify_samples, as names of descriptors.
inline constexpr const char* certificate_box_error = "box_rms_ratio";  // see box_error_ratio
inline constexpr const char* certificate_box_limit = "box_limit";      // see box_error_limit
inline constexpr const char* certificate_over_limit = "over_limit";    // box_rms_ratio over box_limit
inline constexpr const char* certificate_rho = "rho";                  // see spacing_of

// Why samples made with these parameters cannot be certified, one sentence each; empty when they can.
std::vector<std::string> certificate_problems(const SampleParameters& parameters);

// Appends four descriptors of one value to a row with samples: the error over 1000 rotated boxes relative to
// random samples, the least that is known to be possible on this surface, their ratio, and rho. NaN where the
// surface has no such boxes, or one sample has no neighbor. `mesh`: the surface that they were sampled from.
// Throws what `cancel` throws. O(F + N log N), and for each box the triangles that its faces cross.
void certify_samples(Row& row, const PreparedMesh& mesh, const CancelToken& cancel);

}  // namespace meander
