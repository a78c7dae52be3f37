// The metric of a tensor field as edge lengths, for everything that works on lengths alone: seams, charts and
// pieces (docs/METHODS.md 9.3).
#pragma once

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

// Sets mesh.metric_length to the field's lengths (metric_edge_lengths). Where a field changes much within a
// triangle, its lengths may break the triangle inequality: the longest side is shortened by half of the
// excess and the others are lengthened by a quarter each, in rounds over the mesh, until every triangle has a
// margin of 1e-3 of its longest side, or for 100 rounds (flattening mollifies the rest). Triangles that have
// no area in space are left alone. O(T) a round; deterministic. Throws timeout / RunCancelled.
void set_surface_metric(PreparedMesh& mesh, const TensorField& field, const CancelToken& cancel = {});

}  // namespace meander
