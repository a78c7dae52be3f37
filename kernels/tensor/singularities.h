// Points where a tensor field has no direction: indices, singularities, and cuts that join them
// (docs/METHODS.md 9.5).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

// Twice the index (Delmarcelle and Hesselink 1994) of the primary direction: +1 a wedge, -1 a trisector.
//
// The field has one value per corner. Corners of one triangle are compared in its plane, corners of two
// triangles at the same vertex after unfolding over their edge, always by the doubled angle, at most half a
// turn. These links bound three kinds of cells: triangles and edges (four corners), which are flat, and the
// corners around a vertex, whose holonomy is the angle defect. The winding of every cell is a whole number of
// turns. Each link is run through once in each direction, so all turns of a closed component sum to twice its
// Euler characteristic, exactly, whatever the field. A field from vertices has its singularities in triangles
// (vertices take up the curvature), a field that is constant on faces has them at vertices.
struct TensorIndices {
  std::vector<std::int32_t> triangle;  // T
  std::vector<std::int32_t> edge;      // 3 T: at the smaller half-edge of each interior edge, 0 elsewhere
  std::vector<std::int32_t> vertex;    // W; 0 on the boundary
};
// O(T), deterministic. Corners without a direction (isotropic, or of triangles without area) take the mean
// angle of those around them, from the rim of their region inwards. Throws timeout / RunCanceled.
TensorIndices tensor_indices(const PreparedMesh& mesh, const TensorField& field,
                             const CancelToken& cancel = {});

enum class SingularityPlace : std::uint8_t { triangle, edge, vertex };
struct Singularity {
  SingularityPlace place = SingularityPlace::triangle;
  std::uint32_t element = 0;        // triangle, half-edge or working vertex
  std::int32_t half_turns = 0;      // twice the index, not 0
  std::array<double, 3> weights{};  // triangle: barycentric position of the zero of the deviator
  Vector3 position;                 // working units
  std::uint32_t vertex = 0;         // the working vertex nearest to it, through which cuts pass
};

// Returns all cells of non-zero index, triangles first, then edges, then vertices, each ascending. With
// `drop_isotropic`, singularities in and beside isotropic regions (vertices with s1 / s2 < 1.05 at all
// corners) count as noise: each region keeps one, near its middle, with their sum, or none where that is 0,
// where the region reaches the boundary, or where it is a whole component. O(T).
std::vector<Singularity> find_singularities(const PreparedMesh& mesh, const TensorField& field,
                                            bool drop_isotropic = true, const CancelToken& cancel = {});

// The field with the mean of its corners on each triangle. Its singularities are all at vertices, so a sign
// of e1 chosen per triangle and carried over uncut edges is consistent once they are cut through.
TensorField mean_on_triangles(const TensorField& field);

struct SingularityCutParameters {
  double bend = 4;  // c: an edge at angle a to e1 costs |e| (1 + c sin^2 a); 0..1e6
};
// Returns interior half-edges (one of each pair, ascending) to cut, so that every singularity is joined to
// another one or to the boundary by a shortest path, and every connected set of cuts that does not reach the
// boundary has a whole index sum, as far as the singularities of its component allow. The cuts contain no
// cycle (the boundary counted as one point). Half-edges are those of the mesh: subtract 3 triangle_begin for
// open_seams. A cut of one edge between two inner vertices opens into a boundary of two edges.
// O(R T log T), R <= log2(singularities) + 1 rounds (Boruvka). Deterministic. Throws timeout / RunCanceled.
std::vector<std::uint32_t> connect_singularities(const PreparedMesh& mesh, const TensorField& field,
                                                 std::span<const Singularity> singularities,
                                                 const SingularityCutParameters& parameters = {},
                                                 const CancelToken& cancel = {});

}  // namespace meander
