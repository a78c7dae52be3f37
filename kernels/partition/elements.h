// Curve elements: the surface cut into small pieces of known mass and put in curve order (docs/METHODS.md
// 6.1 and 6.4).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/core/status.h"
#include "kernels/core/words.h"
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
  // 2 E barycentric weights (of corners 1, 2) of each element's curve vertex, or empty
  // (ElementUse::vertices).
  std::vector<float> vertex;
  // An element of a region of more mass than `limit` is a wide piece: samples have their places in its parts
  // of at most that mass (bisection_walk.h).
  std::vector<float> place;  // 3 E: the elements' centroids, in working units; empty if no piece is wide
  double limit = 0;
  std::size_t count() const { return triangle.size(); }
  double total() const { return cumulative.empty() ? 0.0 : cumulative.back(); }
};

// The order of the elements: along a space-filling curve, or the balanced order (balanced_order.h).
enum class ElementOrder : std::uint8_t { hilbert, peano, peano_meander, balanced };

struct ElementOrderRow : Word<ElementOrder> {  // its word on the command line and in stores
  CurveKind curve;  // that lays out a chart's leaves: those of the balanced order are for rays only
  Method in_space;  // what /items/method says where there are no charts; none: the order needs charts
};
inline constexpr std::array element_orders = std::to_array<ElementOrderRow>(
    {{{"hilbert", ElementOrder::hilbert}, CurveKind::hilbert, Method::direct},
     {{"peano", ElementOrder::peano}, CurveKind::peano, Method::none},
     {{"peano-meander", ElementOrder::peano_meander}, CurveKind::peano_meander, Method::none},
     {{"balanced", ElementOrder::balanced}, CurveKind::hilbert, Method::balanced}});
static_assert(is_in_order(element_orders));
constexpr CurveKind curve_of(ElementOrder order) { return row_of(element_orders, order).curve; }

// Larger sets are placed region by region (surface_regions.h).
inline constexpr std::uint64_t most_whole_samples = 131072;

// What the samples take of elements and cells.
enum class ElementUse : std::uint8_t {
  positions,  // points at positions along the order
  vertices,   // curve vertices: CurveElements::vertex is filled
  net,        // the point of the net in each cell: cells that can be cut exactly hold nothing else
  places      // points anywhere in each cell: cut across random axes, exact cells keep their polygons
};

struct ElementParameters {
  std::uint64_t samples = 2048;  // N, >= 1
  // Every element's mass <= total / (elements_per_sample N), >= 1; of build_cells in small cells only.
  double elements_per_sample = 4;
  ElementOrder order = ElementOrder::hilbert;
  ElementUse use = ElementUse::positions;
};

// What the locator learned about each triangle; both spans empty for the locator `elements`.
struct TriangleHints {
  // T: curve leaves whose ray met the triangle, which gets at least as many elements.
  std::span<const std::uint32_t> hits;
  // T: sheet number 0..15 of its chart; sheets are visited one after the other.
  std::span<const std::uint8_t> sheet;
};

// A surface and what decides its order: what elements, cells and regions are built of. A view.
struct SurfaceContext {
  MeasuredMesh surface;
  const MeshMeasure& measure;
  RandomKey key;
  ChartSet charts = {};  // empty: the order is that of space
  TriangleHints hints = {};
  CancelToken cancel = {};
};

// A surface in order: along a curve, in cells (element_cells.h) or in regions (surface_regions.h).
struct ElementCells;
struct SurfaceRegions;
using SurfaceOrder = std::variant<CurveElements, ElementCells, SurfaceRegions>;

// The most that an element may weigh. Throws ItemError(zero_density) when the total mass is zero.
double element_limit(const MeshMeasure& measure, const ElementParameters& parameters);
// Throws ItemError(too_large) for more elements than that.
void check_elements(std::size_t elements, std::size_t most);

// What the bytes of elements, cells and regions depend on.
struct OrderSizes {
  double triangles = 0;                    // of the surface
  bool in_space = true;                    // no charts
  bool uniform = true, in_metric = false;  // the density; lengths
  bool in_regions = false;                 // the surface is put in order region by region
  double freed_bytes = 0;                  // of the prepared surface, before elements are made
  int threads = 1;
};
// Upper bound of the number of elements.
constexpr double elements_at_most(const OrderSizes& sizes, double samples, double triangles,
                                  double per_sample) {
  // Elements weigh half the limit at least, but for needles in a metric.
  return triangles + (sizes.in_metric ? 4 : 2) * per_sample * samples;
}
// Upper bound of the bytes of elements along a curve, two arrays to sort them, and the result.
constexpr double element_bytes(const OrderSizes& sizes, double samples, double triangles, double per_sample) {
  constexpr double bytes_per_element = 120;
  return elements_at_most(sizes, samples, triangles, per_sample) * bytes_per_element;
}

// Bisects every triangle of positive mass by its longest edge (MeasuredMesh::length) until each piece is
// light enough, and, where the mesh has a metric, no needle in it (down to 1/8 of the mass); keys every piece
// by a uniformly random point of it (its curve vertex) and sorts: by component, sheet, curve key of the
// chart, 3-D Hilbert key, triangle, path (elements of a region, then as its pieces follow each other).
// Components whose chart is Method::none (and all, when `charts` is empty: the method `direct`, without
// regard to components) are ordered by the 3-D Hilbert key of their pieces' centroids alone. For
// ElementOrder::balanced see build_cells (element_cells.h). The masses of a triangle's elements sum to its
// exact mass. O(E log E). Throws ItemError(zero_density) when the total is zero. Deterministic for every
// thread count.
CurveElements build_elements(const SurfaceContext& context, const ElementParameters& parameters);

}  // namespace meander
