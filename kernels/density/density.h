// The density that samples follow: area x density is the measure.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/words.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

enum class DensityKind : std::uint8_t {
  uniform,
  mean,
  gaussian,
  max,
  vertex_attribute,
  face_attribute,
  texture,
  texture_inverse,
  formula,
  unit_formula
};

inline constexpr double largest_density = std::numeric_limits<float>::max();  // those of samples are float32

struct DensityParameters {
  DensityKind kind = DensityKind::uniform;
  std::string attribute;  // name, for the attribute kinds
  std::string formula;    // for these kinds (formula_density.h)
  double floor = 0.02;  // density of flat parts for the curvature kinds, of dark ones for textures, in (0, 1]
  double exponent = 1.0;   // of (curvature / quantile) or of luminance; 0.25..4
  double quantile = 0.99;  // curvature value that gets density 1 (larger ones are clamped to it); (0, 1]
};

// Linear on triangles: three values for each. Or, finer than triangles, constant on the pieces that bisection
// makes of them (kernels/density/pieces.h). Without either uniform, 1 everywhere.
struct Density {
  std::vector<double> corner;  // 3 T values >= 0 at the corners of each triangle, or empty
  // Or the means over the pieces, by path: those of triangle t begin at piece_begin[t], and its 2^d pieces
  // have the paths 2^d .. 2^(d + 1) - 1; those above are the means of their two halves, and 0 holds a bound
  // that none of them exceeds.
  std::vector<double> piece_mean;        // >= 0
  std::vector<std::size_t> piece_begin;  // T + 1, or empty

  bool in_pieces() const { return !piece_begin.empty(); }
  bool uniform() const { return corner.empty() && !in_pieces(); }
};

// A density and its integral over each triangle: T masses, working units squared (triangle_masses).
struct MeshMeasure {
  Density density;
  std::vector<double> masses;
  double mass_sum = 0;   // where they are not kept
  double total() const;  // O(T) if they are kept; the same value either way
};

// Curvature kinds: Meyer, Desbrun, Schroeder, Barr (2003) operators at the vertices (vertex_curvature), in
// units of 1 / diagonal (1 / diagonal^2 for gaussian) so that the result depends neither on scale nor on
// position; density = floor + (1 - floor) * min(1, curvature / quantile)^exponent, linear over triangles. The
// quantile is weighted by area; where it is zero (a flat surface with a few curved parts) it is taken over
// the curved part alone. A surface without curvature is uniform (an empty Density). Attribute kinds: the
// named scalar of the file, linear over triangles (vertex) or constant (face). Texture kinds:
// make_texture_density, formulas: make_formula_density. Throws ItemError: zero_density (zero everywhere on
// the area), missing_attribute (the file has no attribute of that name: the sentence names those that it
// has), unreadable (the attribute is negative, not finite or too large on a used face: the sentence names it
// and the first bad element). Cost: O(T + W log W). Deterministic for every thread count, thread-safe.
Density make_density(const PolygonMesh& file, const PreparedMesh& mesh, const DensityParameters& parameters,
                     const CancelToken& cancel = {});

// Upper bound of its bytes, where it is finer than triangles; those of others are counted with the mesh.
double density_bytes(const DensityParameters& parameters, double triangles);

// Everything that the program knows of a kind of density. Where a text follows its word, the word ends in a
// colon, and that member of the parameters takes the text.
struct DensityForm : Word<DensityKind> {
  std::string_view help;
  Density (*make)(const PolygonMesh& file, const PreparedMesh& mesh, const DensityParameters& parameters,
                  const CancelToken& cancel);
  std::string DensityParameters::*text_member = nullptr;
  bool is_shaped = false;       // by floor and exponent
  bool needs_topology = false;  // neighbors of triangles
  bool reads_textures = false;  // the images of a model, which its reader must then keep
};
// In the order of the enum: a new density is a maker and a row of density.cpp.
std::span<const DensityForm> density_forms();
inline const DensityForm& form_of(const DensityParameters& parameters) {
  return row_of(density_forms(), parameters.kind);
}
inline bool reads_textures(DensityKind kind) { return row_of(density_forms(), kind).reads_textures; }

// Integral of the density over each triangle (area x mean of the three corner values, or of the pieces),
// working units squared: T values.
std::vector<double> triangle_masses(const PreparedMesh& mesh, const Density& density);

// The density with its masses, or, for stages that need no more, with their sum alone. O(T).
MeshMeasure measure_of(const PreparedMesh& mesh, Density density, bool keep_masses = true);

// The sum of the masses in units of the file. Throws ItemError(non_finite) where it is more than double
// holds.
double file_measure(const PreparedMesh& mesh, double total);

}  // namespace meander
