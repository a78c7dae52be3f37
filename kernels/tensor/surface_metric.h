// The metric of a tensor field as edge lengths, for kernels that work on lengths alone: seams, charts and
// pieces (docs/METHODS.md 9.3).
#pragma once

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

// The field's lengths of half-edges (metric_edge_lengths), 3 T, equal on both sides of an edge. Where a field
// changes much within a triangle, its lengths may break the triangle inequality: the longest side is
// shortened by half of the excess and each of the others is lengthened by a quarter, in rounds over the mesh,
// until every triangle has a margin of 1e-3 of its longest side, or for 100 rounds (flattening mollifies the
// rest). Triangles without area in space are left alone. O(T) a round; deterministic. Throws timeout /
// RunCanceled.
std::vector<double> surface_metric(const PreparedMesh& mesh, const TensorField& field,
                                   const CancelToken& cancel = {});

}  // namespace meander
