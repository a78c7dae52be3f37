// The source that elements are cut from, and the data that puts them in order.
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

// A surface with what all its regions share. A view, as its context.
struct ElementSource : SurfaceContext {
  ChartPlaces places;
  std::vector<std::uint32_t> group;  // sheet_groups
  std::vector<float> normal;         // 3 T, unit, for the balanced order in space; else empty

  // O(T) where there are charts or normals.
  ElementSource(const SurfaceContext& context, ElementOrder order);
  // The same with groups that are known.
  ElementSource(const SurfaceContext& context, ElementOrder order, std::vector<std::uint32_t> sheet_group);

  const Density& density() const { return measure.density; }
};

// What is put in order at a time: the whole surface, or a region of it.
struct SurfacePart {
  const SurfaceRegion* region = nullptr;  // null: the whole surface
  double limit = 0;                       // the largest mass of an element, or of a part of a wide piece
  // The cells of the part, which hold that many equal shares of its mass, each a whole number of them; and
  // the number of the first cell among those of the surface.
  std::uint64_t cells = 0, strata = 0, first_cell = 0;
};

// The pieces of the whole surface (see cut_all), or those that a region's pieces are cut into. Regions ignore
// the hits of rays.
template <class Make>
auto cut_source(const ElementSource& source, const SurfacePart& part, double limit, const Make& make) {
  if (part.region == nullptr)
    return cut_all(source.surface, source.density(), source.hints.hits, limit, make, source.cancel);
  auto record = make();
  record.reserve(part.region->expected_elements, part.region->mass);
  PieceCutter cutter(source.surface, source.density(), {}, limit, record);
  for (std::size_t i = 0; i < part.region->piece.size(); ++i) {
    if (i % sum_block == 0) source.cancel.check();
    cutter.cut(part.region->piece[i]);
  }
  return record;
}

struct ElementCells;

// The elements or cells of a part. Throw what build_elements and build_cells throw.
CurveElements elements_from(const ElementSource& source, const SurfacePart& part,
                            const ElementParameters& parameters);
ElementCells cells_from(const ElementSource& source, const SurfacePart& part,
                        const ElementParameters& parameters);

}  // namespace meander
