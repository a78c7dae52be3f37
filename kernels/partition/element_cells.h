// Curve elements in the cells of balanced bisection (docs/METHODS.md 6.5).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/partition/balanced_order.h"
#include "kernels/partition/elements.h"

namespace meander {

// E pieces of triangles, and n cells made of them and their parts.
struct ElementCells {
  BalancedCells cells;
  std::vector<std::uint32_t> triangle, path;  // E; the path of a part continues that of its piece
  std::vector<float> vertex;  // 2 E, as in CurveElements; only filled when `vertex placement` is asked for
  std::size_t count() const { return cells.cell.size(); }
  std::uint32_t path_of(const CellEntry& entry) const;
  // Whether entries are polygons, which are clipped out of pieces.
  bool has_polygons() const { return !cells.polygon.empty(); }
};

// Parts that pieces are split into at most.
inline constexpr double split_parts = 4;
// Whether pieces are split: in space, of uniform density, without curve vertices, and unless pieces would be
// larger than two thirds of a sample's share.
constexpr bool splits_pieces(const ElementParameters& parameters, bool in_space, bool uniform) {
  return in_space && uniform && !parameters.keep_vertices &&
         parameters.elements_per_sample >= 1.5 * split_parts;
}

// Whether cells are cut exactly where triangles are few: pieces are as above, and samples form a net or are
// spaced.
constexpr bool cuts_exactly(const ElementParameters& parameters, bool in_space, bool uniform) {
  return (parameters.net_points != parameters.keep_polygons) && splits_pieces(parameters, in_space, uniform);
}
// Cells are cut exactly where that costs about what elements do (bench/README.md, "Exact cells"). A cell's
// clips grow with the root of the number of triangles that it holds. A point in a triangle of mass m shares
// its cell with W / (n m) triangles of that size; the mean of the root of this over the mass, squared, must
// be at most the first of these. It is (sum of sqrt(m))^2 / (W n): the number of triangles a sample where
// these are alike, less where most of the mass lies in a few. And as each triangle has a place in the tree
// and takes memory, however small it is, there may not be more than so many a sample, and so many in all.
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

// Bisects every triangle of positive mass as build_elements does, and puts the pieces in the order of
// balanced bisection by their centroids: chart by chart and sheet by sheet, or in space where `charts` is
// empty. The cells are parameters.samples. Pieces of uniform density in space are four times as heavy as
// elements may be, and split in small cells only; where triangles are few they are whole, and the cells are
// points of a net, or keep polygons unless these are too many. The masses of a triangle's entries, if there
// are any, sum to its exact mass. O(E log E); 80 bytes a piece, 70 more for one that is split, and 230 a
// sample, and where some are split 24 an entry, at the peak. Throws ItemError(zero_density) when the total is
// zero, ItemError(too_large) for more than 2^29 pieces. Deterministic for every thread count.
ElementCells build_cells(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                         const TriangleHints& hints, RandomKey key, const ElementParameters& parameters,
                         const CancelToken& cancel = {});

}  // namespace meander
