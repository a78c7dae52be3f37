// Samples as vertices of the triangulation that they were taken from.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/core/cancel.h"
#include "kernels/remesh/edited_mesh.h"

namespace meander {

// Samples of one component, ascending by triangle; inside a triangle neighbors in the list are best
// neighbors in space.
struct InsertedSamples {
  std::span<const std::uint32_t> triangle;  // S, of the component
  std::span<const double> weights;          // 2 S: barycentric weights of corners 1 and 2
  std::span<const Vector3> position;        // S, where the vertices are put
};

// Makes vertex W + i of sample i, W being the number of vertices before: its triangle is cut into three
// around it, and edges inside the original triangle are flipped until they are Delaunay there. Decisions are
// exact signs in the plane of the original triangle, in barycentric coordinates, so the triangulation is
// valid whatever the positions are. Original edges stay whole: a sample on one, or on a corner, is taken for
// one next to it, as is the second of two at the same place. Triangles that the mesh had keep the edges that
// they had on the outside. About O(S log S) for lists in a good order, 1 us a sample. Returns the samples at
// places where others are, too close to be told apart.
std::uint32_t insert_samples(EditedMesh& mesh, const InsertedSamples& samples,
                             const CancelToken& cancel = {});

}  // namespace meander
