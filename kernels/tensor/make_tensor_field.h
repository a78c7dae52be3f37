// The tensor field that anisotropic sampling follows, from a user's parameters.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

enum class TensorKind : std::uint8_t {
  curvature,         // long spacings along the direction of least absolute curvature
  isotropic,         // S = 1
  vertex_attribute,  // attributes of the file, by name
  face_attribute,
  constant,  // one ambient tensor
  table,     // one row per vertex of the file, given by the caller
  formula,   // formulas of the position
  unit_formula
};

// The meaning of six numbers: S (wanted spacings) or G = S^-2.
enum class TensorForm : std::uint8_t { spacing, metric };

// V rows of `columns` numbers each: 6 (xx, xy, xz, yy, yz, zz) or 3 (a vector), see make_tensor_field.
struct TensorTable {
  unsigned columns = 6;
  std::vector<double> values;

  std::size_t row_count() const { return values.size() / columns; }
};

struct TensorParameters {
  TensorKind kind = TensorKind::curvature;
  std::string attribute;                                // NAME, for the attribute kinds
  TensorForm form = TensorForm::spacing;                // of six numbers; three are always a vector
  double max_ratio = 8;                                 // largest s1 / s2; 1..64
  bool adaptive = false;                                // curvature: density follows the curvature
  double epsilon = 0.02;                                // curvature: see CurvatureFieldParameters
  unsigned smoothing = 3;                               // curvature: rounds; 0..64
  std::array<double, 6> constant = {1, 0, 0, 1, 0, 1};  // xx, xy, xz, yy, yz, zz, positive definite
  std::shared_ptr<const TensorTable> table;             // for the kind table
  std::string formula;                                  // three or six, separated by commas
};

constexpr bool is_formula(TensorKind kind) {
  return kind == TensorKind::formula || kind == TensorKind::unit_formula;
}
// Whether its formulas use texture coordinates. False for other kinds, and for formulas that cannot be
// compiled.
bool uses_coordinates(const TensorParameters& parameters);

// Returns one sentence for each value out of its range, a `constant` that is not positive definite, an
// attribute without a name, a missing table and formulas that cannot be compiled, each for its kind alone.
std::vector<std::string> validate(const TensorParameters& parameters);

struct TensorFieldReport {
  std::uint64_t clamped_triangles = 0;  // with area, and a corner whose ratio exceeded max_ratio
  double mean_ratio = 1;                // s1 / s2 over the area (corner means), after clamping
  double max_ratio = 1;                 // largest s1 / s2 at a corner, after clamping
};

// Makes the field on the working triangles, with its ratio clamped to max_ratio (s1 s2 is kept), then
// normalized (normalize_spacings: mean density 1).
//
// Attributes and tables, in file axes, are either
//   six numbers NAME_xx NAME_xy NAME_xz NAME_yy NAME_yz NAME_zz: a symmetric tensor in the given form, which
//   is restricted to the tangent plane and must be positive definite there, or
//   three numbers NAME_x NAME_y NAME_z: a vector along the primary direction, whose length is the ratio s1 /
//   s2 >= 1; s1 s2 = 1. Its part in the tangent plane gives the direction (zero: isotropic).
// Values at vertices hold in the plane of the vertex normal (vertex_frames) and are transported into the
// triangles; values on faces hold in the plane of each triangle. The constant is treated as a vertex value.
// Formulas (kernels/density/mesh_variables.h) give such three or six numbers at the corners of every
// triangle, which hold in its plane. Curvature: curvature_field.
//
// Throws ItemError: missing_attribute for attributes that do not exist; unreadable for tables of another
// length than the file's vertices, and for values that are not finite or not positive definite at a used
// element (the sentence names the attribute and the first bad element). Throws std::invalid_argument when
// `validate` finds a problem. O(T), curvature O(T + W log W); deterministic for every thread count,
// thread-safe.
TensorField make_tensor_field(const PolygonMesh& file, const PreparedMesh& mesh,
                              const TensorParameters& parameters, const CancelToken& cancel = {},
                              TensorFieldReport* report = nullptr);

}  // namespace meander
