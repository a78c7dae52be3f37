// What elements are cut from and put in order by.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/density/density.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/measured_mesh.h"
#include "kernels/partition/chart_places.h"
#include "kernels/partition/elements.h"

namespace meander {

// A part of a surface.
struct SurfaceRegion {
  std::vector<SurfacePiece> piece;
  std::size_t expected_elements = 0;  // about so many, to make room for
  double mass = 0;                    // of all pieces
};

// The same for all regions of a surface. Mesh, density, charts and hits must outlive it.
struct ElementSource {
  MeasuredMesh surface;
  const Density& density;
  ChartPlaces places;
  std::span<const std::uint32_t> hits;  // TriangleHints::hits; regions take no notice of them
  std::vector<std::uint32_t> group;     // sheet_groups
  std::vector<float> normal;            // 3 T, unit, for the balanced order in space; else empty
  RandomKey key;

  // O(T) where there are charts or normals.
  ElementSource(const MeasuredMesh& measured, const Density& of_density, const ChartSet& charts,
                std::span<const std::uint32_t> ray_hits, std::vector<std::uint32_t> sheet_group,
                ElementOrder order, RandomKey random_key);
};

// The pieces of the whole surface (see cut_all), or those that a region's pieces are cut into.
template <class Make>
auto cut_source(const ElementSource& source, const SurfaceRegion* region, double limit, const Make& make,
                const CancelToken& cancel) {
  if (region == nullptr) return cut_all(source.surface, source.density, source.hits, limit, make, cancel);
  auto record = make();
  record.reserve(region->expected_elements, region->mass);
  PieceCutter cutter(source.surface, source.density, {}, limit, record);
  for (std::size_t i = 0; i < region->piece.size(); ++i) {
    if (i % sum_block == 0) cancel.check();
    cutter.cut(region->piece[i]);
  }
  return record;
}

struct ElementCells;

// The elements or cells of a region, or of the whole surface (null): what build_elements and build_cells
// return, of pieces of at most `limit` or, of a region, of wide pieces as wholes. `cells` cells hold `strata`
// equal shares of the mass between them, each a whole number; the first of them is number `first_cell` of
// all. Throw what these throw.
CurveElements elements_from(const ElementSource& source, const SurfaceRegion* region, double limit,
                            const ElementParameters& parameters, const CancelToken& cancel = {});
ElementCells cells_from(const ElementSource& source, const SurfaceRegion* region, std::uint64_t cells,
                        std::uint64_t strata, std::uint64_t first_cell, double limit,
                        const ElementParameters& parameters, const CancelToken& cancel = {});

}  // namespace meander
