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

// Cuts the surface into coarse pieces and puts these in the order that the elements shall have. `sheet`:
// TriangleHints::sheet; the hits do not matter, as elements of large sets are small beside the leaves of the
// curve. Masses below 2^-53 of the total may be lost. O(E log E) for E = T + N / 16 pieces; 200 bytes a piece
// at the peak. Throws what build_elements and build_cells throw. Deterministic for every thread count.
SurfaceRegions build_regions(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                             std::span<const std::uint8_t> sheet, RandomKey key,
                             const ElementParameters& parameters, const CancelToken& cancel = {});

// The elements of one of them, in the order of a curve, of uniform density in space with wide pieces as
// wholes (CurveElements::place); or its cells, one a stratum. Pure: regions may be asked for in any order, by
// any thread. O(E log E) for its own E elements.
CurveElements region_elements(const SurfaceRegions& regions, const ElementSource& source, std::size_t region,
                              const CancelToken& cancel = {});
ElementCells region_cells(const SurfaceRegions& regions, const ElementSource& source, std::size_t region,
                          const CancelToken& cancel = {});

}  // namespace meander
