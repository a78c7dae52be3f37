// Curve elements: the surface cut into small pieces of known mass and put in curve order (docs/METHODS.md
// 6.1 and 6.4).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/curve/curve_key.h"
#include "kernels/density/density.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/partition/chart_places.h"

namespace meander {

// E elements in curve order. An element is a piece of a triangle, named by the choices of a longest-edge
// bisection: path = 1 followed by one bit per bisection (density/pieces.h). cumulative[i] is the mass before
// element i; cumulative[E] is the total, the exact area x density of the surface. Masses are in working units
// squared.
struct CurveElements {
  std::vector<std::uint32_t> triangle;  // E triangles of the PreparedMesh
  std::vector<std::uint32_t> path;      // E
  std::vector<double> cumulative;       // E + 1
  std::vector<float> vertex;  // 2 E barycentric weights (of corners 1, 2) of each element's curve vertex;
                              // only filled when `vertex placement` is asked for, else empty
  // Of a region: an element of more than `limit` is a wide piece, in whose parts of at most that samples have
  // their places (bisection_walk.h).
  std::vector<float> place;  // 3 E: the elements' centroids, in working units; empty if no piece is wide
  double limit = 0;
  std::size_t count() const { return triangle.size(); }
  double total() const { return cumulative.empty() ? 0.0 : cumulative.back(); }
};

// The order of the elements: along a space-filling curve, or by balanced bisection (balanced_order.h).
enum class ElementOrder : std::uint8_t { hilbert, peano, peano_meander, balanced };
// The curve that lays out a chart's leaves. Balanced: hilbert, for the rays that look for triangles and
// sheets.
constexpr CurveKind curve_of(ElementOrder order) {
  return order == ElementOrder::peano           ? CurveKind::peano
         : order == ElementOrder::peano_meander ? CurveKind::peano_meander
                                                : CurveKind::hilbert;
}

// Larger sets are placed region by region (surface_regions.h).
inline constexpr std::uint64_t most_whole_samples = 131072;

struct ElementParameters {
  std::uint64_t samples = 2048;    // N, >= 1
  double elements_per_sample = 4;  // every element's mass <= total / (elements_per_sample N), >= 1 (of
                                   // build_cells in small cells only)
  ElementOrder order = ElementOrder::hilbert;
  bool keep_vertices = false;  // fill CurveElements::vertex
  bool random_axes = false;    // of build_cells: cut across axes that the key has turned, not those of space
  // Of build_cells: what cells that can be cut exactly become, their points of the net or polygons.
  bool net_points = false, keep_polygons = false;
};

// What the locator learned about each triangle; both spans empty for the locator `elements`.
struct TriangleHints {
  std::span<const std::uint32_t>
      hits;  // T: curve leaves whose ray met the triangle: it gets at least as many elements
  std::span<const std::uint8_t>
      sheet;  // T: sheet number 0..15 of its chart; sheets are visited one after the other
};

// Bisects every triangle of positive mass by its longest edge (MeasuredMesh::length) until each piece is
// light enough, and, where the mesh has a metric, no needle in it (down to 1/8 of the mass); keys every piece
// by a uniformly random point of it (its curve vertex) and sorts: by component, sheet, curve key of the
// chart, 3-D Hilbert key, triangle, path (elements of a region, then as its pieces follow each other).
// Components whose chart is Method::none (and all, when `charts` is empty: the method `direct`, without
// regard to components) are ordered by the 3-D Hilbert key of their pieces' centroids alone. For
// ElementOrder::balanced see build_cells (element_cells.h). The masses of a triangle's elements sum to its
// exact mass. O(E log E); 100 bytes an element at the peak. Throws ItemError(zero_density) when the total is
// zero. Deterministic for every thread count.
CurveElements build_elements(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                             const TriangleHints& hints, RandomKey key, const ElementParameters& parameters,
                             const CancelToken& cancel = {});

}  // namespace meander
