// Processor seconds of one model, to divide a run among processes and to tell the time that it has left.
#pragma once

#include <cstdint>

#include "io/mesh/mesh_reader.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

// Measured on a collection of 421 models of one megabyte or less; correct within a factor of two or so on
// processors of this decade. Without colors and certificates, and 0 for a mesh without triangles
// (a file that cannot be read takes no time).
double estimated_seconds(const MeshEstimate& mesh, const SampleParameters& parameters);
// The same for a file of which only the size is known: 30 bytes a triangle, as OFF and OBJ files have.
double estimated_seconds(std::uint64_t file_bytes, const SampleParameters& parameters);

}  // namespace meander
