// The meshes that figures sample, and samples of them at a stage that only the number of points changes.
#pragma once

#include <cstdint>

#include "jobs/figures/figure_set.h"
#include "kernels/sample_mesh.h"

namespace meander {

// A torus of radii 1 and 0.5: 2 around x across triangles.
FigureMesh torus_mesh(std::uint32_t around, std::uint32_t across);
// The unit sphere by latitude and longitude: rings x 2 rings quadrilaterals, one vertex at each pole.
FigureMesh sphere_mesh(std::uint32_t rings);

// A mesh up to its charts, made once; every set of samples starts from a copy. Throws ItemError.
ModelState flattened_model(const FigureMesh& mesh, const SampleParameters& parameters);
Row sample_flattened(const ModelState& prepared, SampleParameters parameters, std::uint32_t count,
                     std::uint64_t seed, const EmbreeDevice& device);

}  // namespace meander
