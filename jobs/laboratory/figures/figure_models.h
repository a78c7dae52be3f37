// The meshes that figures make themselves.
#pragma once

#include <cstdint>

#include "jobs/laboratory/figures/figure_set.h"

namespace meander {

// A torus of radii 1 and 0.5: 2 around x across triangles.
FigureMesh torus_mesh(std::uint32_t around, std::uint32_t across);
// The unit sphere by latitude and longitude: rings x 2 rings quadrilaterals, one vertex at each pole.
FigureMesh sphere_mesh(std::uint32_t rings);
// Closed tubes, y up: a trefoil knot, and a loop like a lying 8 that passes over itself. 2 x around x across
// triangles.
FigureMesh knot_mesh(std::uint32_t around, std::uint32_t across);
FigureMesh eight_mesh(std::uint32_t around, std::uint32_t across);
// The unit square, z = 0: 2 x side x side triangles. And the unit cube, each face so.
FigureMesh square_mesh(std::uint32_t side);
FigureMesh cube_mesh(std::uint32_t side);

}  // namespace meander
