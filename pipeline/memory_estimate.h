// What one model takes at its peak, for the admission by bytes.
#pragma once

#include <cstdint>

#include "io/mesh/mesh_reader.h"
#include "kernels/sample_mesh.h"

namespace meander {

// Upper bound of the bytes that are alive at once on the way from the mapped file to the encoded row: the
// largest of the stages' sums (mesh, cut and factorisation, rays, elements, row). Measured per vertex,
// triangle and sample; a test asserts it on every model of the collections at hand.
std::uint64_t estimate_bytes(const MeshEstimate& mesh, const SampleParameters& parameters);

}  // namespace meander
