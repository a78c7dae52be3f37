// A density on a mesh by a formula.
#pragma once

#include "kernels/core/expression.h"
#include "kernels/density/density.h"

namespace meander {

constexpr bool is_formula(DensityKind kind) {
  return kind == DensityKind::formula || kind == DensityKind::unit_formula;
}
// The formula of such a density, in mesh_variables. Throws std::invalid_argument as Expression does.
Expression formula_of(const DensityParameters& parameters);

// Whether a density needs more of the model than its triangles. False for other kinds, and for formulas that
// cannot be compiled.
bool uses_curvature(const DensityParameters& parameters);
bool uses_coordinates(const DensityParameters& parameters);
// Whether it is made in pieces (density_in_pieces): textures, and formulas that are not linear over
// triangles.
bool is_in_pieces(const DensityParameters& parameters);

// A formula that is linear over triangles gives their corners its values, and masses are exact. Another is
// constant on pieces (density_in_pieces), whose pixels are squares of a 512th of the diagonal of the box: for
// a density f the mass of a piece is exact up to about |f"| h^2 / 36 of its area, h its longest edge, and
// within a piece points are uniform. Negative values of at most 1e-12 of the largest beside, or of 1, are
// rounding and count as 0.
//
// Throws ItemError: unreadable (negative, not finite, or more than float32 holds: the sentence names the
// first such place), zero_density, missing_attribute (texture coordinates that a face has not got). O(T +
// pieces). Deterministic for every thread count, thread-safe.
Density make_formula_density(const PolygonMesh& file, const PreparedMesh& mesh,
                             const DensityParameters& parameters, const CancelToken& cancel = {});

}  // namespace meander
