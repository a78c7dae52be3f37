// A surface in regions: for sets whose elements would not fit into memory at once (docs/METHODS.md 6.8).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/partition/element_cells.h"
#include "kernels/partition/element_source.h"
#include "kernels/partition/elements.h"

namespace meander {

// Samples of a region, at most. Regions of cells can be small. Along a curve they are larger: what it visits
// at other times than the rest of a region makes strata of scattered parts, all along the border
// (docs/METHODS.md 6.8 has the numbers); but not where samples have many elements.
constexpr std::uint64_t samples_per_region(const ElementParameters& parameters) {
  constexpr std::uint64_t of_cells = 16384, of_curve = 65536;
  return parameters.order == ElementOrder::balanced || parameters.elements_per_sample >= 16 ? of_cells
                                                                                            : of_curve;
}
// Samples of a coarse piece, at most. The borders of regions are as ragged as these are large.
inline constexpr double samples_per_piece = 16;

// R regions that follow each other along the path, each of whole strata: shares of 1 / samples of the mass.
struct SurfaceRegions {
  std::vector<SurfaceRegion> region;         // R
  std::vector<std::uint64_t> first_stratum;  // R + 1
  std::vector<std::uint32_t> group;          // ElementSource::group
  ElementParameters parameters;
  double limit = 0;  // the most that an element, or a part of a wide piece, may weigh
  std::size_t count() const { return region.size(); }
  std::uint64_t strata(std::size_t r) const { return first_stratum[r + 1] - first_stratum[r]; }
};

// Cuts the surface into coarse pieces and puts these in the order that the elements will have. Ignores the
// hits of rays, as elements of large sets are small beside the leaves of the curve. Masses below 2^-53 of the
// total may be lost. O(E log E) for E = T + N / 16 pieces. Throws what build_elements and build_cells throw.
// Deterministic for every thread count.
SurfaceRegions build_regions(const SurfaceContext& context, const ElementParameters& parameters);

// The elements of a region along a curve, under a uniform density in space with wide pieces undivided
// (CurveElements::place); or its cells, one a stratum. Pure: any thread may ask for regions in any order.
// O(E log E) for the E elements of the region.
CurveElements region_elements(const SurfaceRegions& regions, const ElementSource& source, std::size_t region);
ElementCells region_cells(const SurfaceRegions& regions, const ElementSource& source, std::size_t region);

// The surface in order, region by region for large sets. Throws what build_elements and build_cells throw.
SurfaceOrder build_order(const SurfaceContext& context, const ElementParameters& parameters, bool in_regions);

// Upper bounds of the bytes of elements, cells or regions.
struct OrderBytes {
  double building = 0;  // while they are made
  double placing = 0;   // while samples are placed by them, without the samples
};
OrderBytes order_bytes(const OrderSizes& sizes, const ElementParameters& parameters);

}  // namespace meander
