// Straight ways on a mesh: from a place in a triangle over its edges into others.
#pragma once

#include <cstdint>

#include "kernels/core/vector3.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// A point of a triangle by its weights of corners 1 and 2.
struct SurfacePlace {
  std::uint32_t triangle = 0;
  double b1 = 0, b2 = 0;
};

// Where it lies, in working units.
Vector3 position_of(const PreparedMesh& mesh, const SurfacePlace& place);
// The unit normal of a triangle; 0 where it has no area.
Vector3 triangle_normal(const PreparedMesh& mesh, std::uint32_t triangle);

// Goes `way` (working units; what is normal to the triangle is left out) straight on over the unfolded
// surface: at an edge the rest of the way turns with the surface, at a border it goes on along the border as
// far as it points there. Ends early at triangles without area, where two borders meet, and after 256 edges.
// mesh: with topology. Pure, thread-safe. O(edges).
SurfacePlace walk_on_surface(const PreparedMesh& mesh, SurfacePlace place, Vector3 way);

}  // namespace meander
