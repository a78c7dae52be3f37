// Relaxed samples: a finish for any set of samples on a mesh (docs/METHODS.md 7.9).
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/density/density.h"
#include "kernels/mesh/surface_walk.h"

namespace meander {

// Moves samples over the surface towards the least energy of their repulsion and of the attraction by the
// surface (in the plane: Schmaltz et al. 2010, "Electrostatic halftoning"; Fattal 2011, "Blue-noise point
// sampling using kernel density model"), the kernel being that of sum_pull; then those apart that are nearer
// to each other than .78 of the spacing of the hexagonal lattice, and those around holes that are 1.15 times
// as large as in the lattice into them. A sample moves on the triangles that its own is connected to, so that
// every component keeps its samples; near a border it moves along the border only, so that these keep their
// share too. Where several sheets lie within a spacing and face the same way (1.6 times the surface of a
// plane or more), samples stay where they are: there are as many as the result.
//
// places: in the order of a path, where those that follow each other are neighbors; of 1,024 of them each
// sees where those before it have gone, the others' moves in the next pass. mesh: with topology. density:
// samples follow it. The same for every number of threads; no randomness. Cost: about 6 us a sample on one
// core, and O(T log T); about 600 bytes a sample at the peak.
std::uint32_t relax_samples(const PreparedMesh& mesh, const MeshMeasure& measure,
                            std::span<SurfacePlace> places, const CancelToken& cancel = {});

// Upper bound of what it allocates.
double relaxation_bytes(double samples, double triangles);

}  // namespace meander
