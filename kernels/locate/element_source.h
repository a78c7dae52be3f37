// What elements are cut from and put in order by.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/density/density.h"
#include "kernels/locate/chart_places.h"
#include "kernels/locate/elements.h"
#include "kernels/locate/pieces.h"
#include "kernels/mesh/measured_mesh.h"

namespace meander {

// The same for all regions of a surface. A view but for groups and normals: what it is made of must outlive
// it.
struct ElementSource {
  MeasuredMesh surface;
  const Density& density;
  ChartPlaces places;
  std::span<const std::uint32_t> hits;  // TriangleHints::hits
  std::vector<std::uint32_t> group;     // sheet_groups
  std::vector<float> normal;            // 3 T, unit, for the balanced order in space; else empty
  RandomKey key;

  // O(T) where there are charts or normals.
  ElementSource(const MeasuredMesh& measured, const Density& of_density, const ChartSet& charts,
                std::span<const std::uint32_t> ray_hits, std::vector<std::uint32_t> sheet_group,
                ElementOrder order, RandomKey random_key);
};

// The pieces of the whole surface (see cut_all), or those that its pieces are cut into.
template <class Make>
auto cut_source(const ElementSource& source, const std::vector<SurfacePiece>* region, double limit,
                const Make& make, const CancelToken& cancel) {
  if (region == nullptr) return cut_all(source.surface, source.density, source.hits, limit, make, cancel);
  auto record = make();
  PieceCutter cutter(source.surface, source.density, {}, limit, record);
  for (const SurfacePiece& piece : *region) cutter.cut(piece);
  return record;
}

struct ElementCells;

// The elements or cells of a region, or of the whole surface (null): what build_elements and build_cells
// return, of pieces of at most `limit`. Throw what these throw.
CurveElements elements_from(const ElementSource& source, const std::vector<SurfacePiece>* region,
                            double limit, const ElementParameters& parameters,
                            const CancelToken& cancel = {});
ElementCells cells_from(const ElementSource& source, const std::vector<SurfacePiece>* region,
                        std::uint64_t cells, double limit, const ElementParameters& parameters,
                        const CancelToken& cancel = {});

}  // namespace meander
