// The lowest eigenvalues of the Laplacian as a descriptor of shape (Reuter, Wolter and Peinecke 2006,
// "Laplace-Beltrami spectra as 'Shape-DNA' of surfaces and solids").
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

inline constexpr std::size_t shape_dna_values = 40;

// The number of samples for remeshing the surface, and the minimum number of vertices of the result:
// triangles of smaller ones are cut in four.
inline constexpr std::uint32_t shape_dna_samples = 1000;
inline constexpr std::uint32_t shape_dna_min_vertices = 500;
// The maximum number of vertices for which eigenvalues are computed: topology can need any number of them (a
// plate with 100,000 holes).
inline constexpr std::uint32_t shape_dna_max_vertices = 10000;

// N samples of a prepared mesh.
struct SurfaceSamplePlaces {
  std::span<const std::uint32_t> triangle;  // N
  std::span<const float> weights;           // 2 N: barycentric weights of corners 1 and 2
  std::span<const std::uint32_t> rank;      // N: positions along the curve, a permutation of 0 .. N - 1
};

// The first 40 positive eigenvalues of the Laplacian of the surface (joint_spectrum of its components), each
// as sqrt(lambda_i area / (4 pi i)), i = 1 .. 40: its frequency over the one expected by the area (Weyl
// 1911), about 1 for large i. They change with neither position, direction, handedness nor size of a model,
// nor with the winding of its faces, and hardly when it is bent without stretching.
//
// The surface is remeshed first (remesh_surface, without creases), with shape_dna_samples of the samples as
// vertices, evenly chosen along the curve, or all where there are fewer; components without samples are left
// out. All values are NaN where the remeshed surface has more than shape_dna_max_vertices, or the eigenvalues
// of a component cannot be found. Deterministic. O(T) beside the remeshed surface. Throws as remesh_surface,
// and ItemError(internal) when a matrix cannot be factorized.
std::vector<float> shape_dna(const PreparedMesh& mesh, const SurfaceSamplePlaces& samples,
                             const CancelToken& cancel = {});

}  // namespace meander
