// Large sets block by block: samples are placed as sites, and turned into rows of arrays when these are asked
// for (docs/METHODS.md 7.8).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/density/density.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/partition/surface_regions.h"
#include "kernels/sample/place_samples.h"
#include "kernels/sample/placer.h"
#include "kernels/sample/sample_sites.h"

namespace meander {

// Where a triangle lies, and what its samples have in common.
struct SharedBySamples {
  CornerFrame frame;
  TriangleRecord record;
};
// Triangles have these where they are this many times fewer than the samples.
inline constexpr std::size_t samples_per_shared_triangle = 8;

// N placed samples in 20 bytes each, 16 along the curve, and up to 13 for records of triangles. All else
// follows from these and the mesh.
struct PlacedSites {
  SampleSites sites;                 // N, by curve rank
  std::vector<std::uint32_t> order;  // N: the curve rank of the i-th sample of the file; empty: i
  // By triangle, where these are few beside the samples: what the samples of one have in common, in one place
  // in place of twenty. Else empty.
  std::vector<SharedBySamples> shared;
  std::size_t count() const { return sites.count(); }
  std::uint32_t rank(std::size_t i) const { return order.empty() ? static_cast<std::uint32_t>(i) : order[i]; }
};

// The samples that place_samples places in these regions. At most 24 bytes a sample (32 for the sequences
// owen and random, whose positions are sorted; 8 more at curve vertices), 60 for each that is drawn
// again, 13 where triangles have records, and what the regions that are worked on take. O(N + E log E).
// Throws what place_samples throws. frame: as there; samples_at takes the one that is left.
PlacedSites place_sites(const PolygonMesh& file, const MeasuredMesh& surface, const Density& density,
                        const ChartSet& charts, const SurfaceRegions& regions, RandomKey key,
                        const PlaceParameters& parameters, OutputFrame& frame, RepairCounts& repairs,
                        const CancelToken& cancel = {});

// Samples [begin, end) of the file, of what place_sites was given. Pure: blocks may be asked for in any
// order, by any thread, and together are what place_samples returns. O(end - begin).
Samples samples_at(const PlacedSites& placed, const PolygonMesh& file, const MeasuredMesh& surface,
                   const Density& density, RandomKey key, const PlaceParameters& parameters,
                   const OutputFrame& frame, std::size_t begin, std::size_t end);

}  // namespace meander
