// Discrete curvature at the vertices of a triangle mesh.
#pragma once

#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// The part of a triangle (p, q, r) of the given area that belongs to p: its Voronoi area, or, where the
// triangle is obtuse, half (at p) or a quarter (elsewhere). The three parts sum to the area.
double mixed_area_share(Vector3 p, Vector3 q, Vector3 r, double area);

// W values each, working units: area is squared, mean is 1 / length, gaussian 1 / length^2.
struct VertexCurvature {
  std::vector<double> mixed_area;  // tiles the mesh: the sum is the area
  std::vector<double> mean;        // |H| >= 0
  std::vector<double> gaussian;    // K, signed
};

// Mixed area, mean curvature (the gradient of the area, which is the cotangent formula without cotangents,
// so that needles cause no cancellation) and angle defect of Meyer, Desbrun, Schroeder, Barr 2003, "Discrete
// differential-geometry operators for triangulated 2-manifolds".
//
// Safeguards:
// - triangles of no area add their angles (0 or pi) alone;
// - vertices that own less than 1e-6 of the mean mixed area are divided by that much instead;
// - curvature within the rounding error of float32 coordinates counts as zero: an area gradient
//   of at most 8 r, r = 2^-24 of the largest coordinate, or an angle defect that such a displacement
//   explains;
// - boundary vertices, and vertices without area, take the mean of their neighbors that have a value: the
//   interior ones first, then round by round (at most 64) inwards from those; 0 where no neighbor has one.
// O(T). Deterministic for every thread count. Throws timeout / RunCanceled.
VertexCurvature vertex_curvature(const PreparedMesh& mesh, const CancelToken& cancel = {});

}  // namespace meander
