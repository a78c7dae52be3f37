// Coarsening: the same surface with fewer and larger triangles, to make charts on (docs/METHODS.md 2.3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

struct CoarsenParameters {
  double triangles_per_sample = 1.5;     // of the whole mesh, about; 0.25..1e12, which keeps all triangles
  std::uint32_t min_triangles = 3000;    // of the whole mesh, whatever the samples; >= 64
  std::uint32_t min_of_component = 256;  // of each component; >= 64
};

// A coarse mesh of C triangles under a fine one of T.
struct CoarseMesh {
  // The components of the fine mesh in its order, each of the same topology; their vertices are vertices of
  // the fine mesh. Of the file it keeps only center, unit and diagonal; all its polygons are number 0.
  PreparedMesh mesh;
  std::vector<std::uint32_t> triangle;  // T: the coarse triangle under each fine one, of its component
  std::vector<double> masses;           // C: the masses of the fine triangles over each, summed
  bool empty() const { return triangle.empty(); }
};

// Makes a mesh with fewer triangles for charts. Vertices move along an edge to a neighbor, so that their
// triangles there vanish, in rounds of vertices that are not neighbors of each other (Dobkin and Kirkpatrick
// 1985, as Lee et al. 1998 coarsen meshes: "MAPS: multiresolution adaptive parameterization of surfaces"). A
// vertex moves as long as its neighbor then stands for at most its part of the surface, triangles keep their
// shape and turn little, and the topology stays. Boundary vertices move along the boundary. The part is
// measured half by mass and half by area, so that triangles are small where samples are dense. Each component
// gets its part of all triangles; components of at most 1.5 times as many, or without area, are copied. The
// result is empty where all are copied.
//   masses: T masses (MeshMeasure), working units squared; samples: N >= 1
// O(T): at most 24 neighbors of a vertex are tried, and again only after one of them was removed. Parallel
// over components; deterministic for every thread count. Throws timeout / RunCanceled from `cancel`.
CoarseMesh coarsen_mesh(const PreparedMesh& mesh, std::span<const double> masses, std::uint64_t samples,
                        const CoarsenParameters& parameters, const CancelToken& cancel = {});

// The weights of corners 1 and 2 of a triangle at the foot of a point p on its plane: first . (p - origin)
// and second . (p - origin); all 0 for a triangle without a plane. O(1).
struct PlaneWeights {
  Vector3 origin, first, second;
};
PlaneWeights plane_weights(const PreparedMesh& mesh, std::size_t triangle);

}  // namespace meander
