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

// N placed samples. All else follows from these and the mesh.
struct PlacedSites {
  SampleSites sites;                 // N, by curve rank
  std::vector<std::uint32_t> order;  // N: the curve rank of the i-th sample of the file; empty: i
  // Data that the samples of a triangle share, by triangle. Empty unless triangles are few beside the
  // samples.
  std::vector<SharedBySamples> shared;
  std::size_t count() const { return sites.count(); }
  std::uint32_t rank(std::size_t i) const { return order.empty() ? static_cast<std::uint32_t>(i) : order[i]; }
};

// The samples that place_samples places in these regions. O(N + E log E). Throws what place_samples throws.
// frame: as there; samples_at takes the resulting one.
PlacedSites place_sites(const PlaceContext& context, const SurfaceRegions& regions, OutputFrame& frame,
                        RepairCounts& repairs);

// Samples [begin, end) of the file, from the context that place_sites was given. Pure: any thread may ask for
// blocks in any order; together they are what place_samples returns. O(end - begin).
Samples samples_at(const PlacedSites& placed, const PlaceContext& context, const OutputFrame& frame,
                   std::size_t begin, std::size_t end);

// Upper bound of the bytes of the samples of regions; `as_sites`: of their sites, and of the blocks that
// samples_at makes and that are encoded, one a thread.
double region_sample_bytes(const PlaceParameters& parameters, bool as_sites, double triangles, int threads);

}  // namespace meander
