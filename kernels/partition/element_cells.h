// Elements in the cells of the balanced order, a k-d tree of equal masses (docs/METHODS.md 6.5).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/partition/balanced_order.h"
#include "kernels/partition/elements.h"

namespace meander {

// E pieces of triangles, and n cells made of them and their parts.
struct ElementCells {
  BalancedCells cells;
  std::vector<std::uint32_t> triangle, path;  // E; the path of a part continues that of its piece
  std::vector<float> vertex;                  // 2 E, as in CurveElements, or empty
  std::size_t count() const { return cells.cell.size(); }
  std::uint32_t path_of(const CellEntry& entry) const;
  // Whether entries are polygons, which are clipped out of pieces.
  bool has_polygons() const { return !cells.polygon.empty(); }
};

// Parts that pieces are split into at most.
inline constexpr double split_parts = 4;

// What the entries of cells are.
enum class CellForm : std::uint8_t {
  whole,  // pieces, and where a cut divides one, shares of its mass
  split,  // the same with the parts that pieces are split into
  exact   // as split; where triangles are few, polygons that are clipped out of them
};
// Whether pieces of elements that are used so may be split: in space, under a uniform density.
constexpr bool may_split(ElementUse use, bool in_space, bool uniform) {
  return in_space && uniform && use != ElementUse::vertices;
}
// Pieces that would be larger than two thirds of a sample's share stay whole.
constexpr CellForm cell_form(const ElementParameters& parameters, bool in_space, bool uniform) {
  if (!may_split(parameters.use, in_space, uniform) || parameters.elements_per_sample < 1.5 * split_parts)
    return CellForm::whole;
  return parameters.use == ElementUse::positions ? CellForm::split : CellForm::exact;
}

// Cells are cut exactly where that costs about what elements do (bench/README.md, "Exact cells"). A cell's
// clips grow with the root of the number of triangles that it holds. A point in a triangle of mass m shares
// its cell with W / (n m) triangles of that size; the mean of the root of this over the mass, squared, must
// be at most most_typical_triangles. It is (sum of sqrt(m))^2 / (W n): the number of triangles a sample where
// these are alike, less where most of the mass lies in a few. Every triangle takes memory, however small it
// is. Their number is therefore bounded, per sample and in total.
inline constexpr double most_typical_triangles = 4, most_clipped_per_sample = 16, most_clipped = 1 << 18;
// The number of triangles above which they are never clipped; up to most_typical_triangles a sample they
// always are. Of regions (`coarse`) these are coarse pieces, and both limits are the same.
constexpr double most_clipped_triangles(double samples, bool coarse) {
  const double always = most_typical_triangles * samples;
  return coarse ? always : std::max(always, std::min(most_clipped_per_sample * samples, most_clipped));
}

// Polygons that cells may keep of so many triangles. Compact cells of compact triangles have (sqrt T + sqrt
// n)^2; soups of long thin triangles have more than this, and their cells get elements.
inline double most_kept_polygons(double triangles, double samples) {
  const double side = std::sqrt(triangles) + std::sqrt(samples);
  return std::min(4 * side * side, triangles + 32 * samples);
}

// Bisects every triangle of positive mass as build_elements does, and puts the pieces in the balanced order
// by their centroids: chart by chart and sheet by sheet, or in space where there are no charts. There are
// parameters.samples cells. Split pieces are four times as heavy as elements may be; cell_form says what
// entries are. The masses of a triangle's entries, if there are any, sum to its exact mass. O(E log E).
// Throws ItemError(zero_density) when the total is zero, ItemError(too_large) for more than 2^29 pieces.
// Deterministic for every thread count.
ElementCells build_cells(const SurfaceContext& context, const ElementParameters& parameters);

// Upper bound of the bytes of cells and of what they are made of: for that many samples, with that many
// elements a sample or, where it is 0, none beside the triangles.
double cell_bytes(const OrderSizes& sizes, const ElementParameters& parameters, double samples,
                  double triangles, double per_sample);

}  // namespace meander
