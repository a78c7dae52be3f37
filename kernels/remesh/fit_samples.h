// Bringing a remeshed surface nearer to the one that it stands for.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/remesh/edited_mesh.h"

namespace meander {

struct FitParameters {
  double largest_shift = 0.2;  // of a vertex along its normal, over the mean edge around it; 0..1
  std::uint32_t rounds = 3;    // of flips and heights; 0..16
  double stiffness = 0.02;     // weight of a vertex's height over that of the points around it; > 0
  double least_angle = 16;     // degrees: flips make no angle smaller, unless one was smaller before
};

// A place on the surface to be matched.
struct FitPoint {
  Vector3 position, normal;  // unit normal of the surface, or 0
  double weight = 0;         // the area that it stands for
  std::uint32_t vertex = 0;  // of the mesh, near it
};

// Flips edges where that lowers the distance of the points to the mesh, and of the edge to the surface around
// the nearest point (after Hoppe, DeRose, Duchamp, McDonald, Stuetzle 1993, "Mesh optimization"), then moves
// the vertices first .. last - 1 that are on no line along their normals, by the heights that are best in the
// sense of least squares (conjugate gradients, a bounded number of steps); in rounds. Lines stay. Returns the
// largest shift over the mean edge around the vertex. About 3 us a point and round. Throws what `cancel`
// throws.
double fit_samples(EditedMesh& mesh, std::uint32_t first, std::uint32_t last,
                   std::span<const FitPoint> points, const FitParameters& parameters,
                   const CancelToken& cancel = {});

}  // namespace meander
