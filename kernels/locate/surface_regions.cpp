#include "kernels/locate/surface_regions.h"

#include <algorithm>
#include <array>
#include <bit>

#include "kernels/locate/placed_pieces.h"

namespace meander {

namespace {

// Mass of a whole piece.
double mass_of(const MeasuredMesh& surface, const Density& density, std::uint32_t triangle,
               std::uint32_t path) {
  const TriangleSource source = source_of(surface.mesh(), density, triangle);
  const int bisections = std::bit_width(path) - 1;
  if (source.uniform) return source.area * share_after(bisections);
  return piece_mass(source, piece_of(bisection_corners(surface, triangle), path), bisections);
}

// Runs of elements, divided where a region ends within one.
void divide_curve(const CurveElements& elements, SurfaceRegions& regions) {
  const std::uint64_t strata = regions.parameters.samples;
  const std::size_t count = regions.first_stratum.size() - 1;
  const double total = elements.total();
  std::size_t e = 0;
  for (std::size_t r = 0; r < count; ++r) {
    const auto boundary = [&](std::size_t region) {
      return region == count
                 ? total
                 : total * (static_cast<double>(regions.first_stratum[region]) / static_cast<double>(strata));
    };
    const double begin = boundary(r), end = boundary(r + 1);
    while (e + 1 < elements.count() && elements.cumulative[e + 1] <= begin) ++e;
    for (std::size_t i = e; i < elements.count() && elements.cumulative[i] < end; ++i) {
      const double from = elements.cumulative[i], mass = elements.cumulative[i + 1] - from;
      const double held = std::min(end, from + mass) - std::max(begin, from);
      if (held > 0)
        regions.region[r].push_back({elements.triangle[i], elements.path[i], std::min(held / mass, 1.0)});
    }
  }
}

void take_cells(const ElementCells& cells, const MeasuredMesh& surface, const Density& density,
                SurfaceRegions& regions) {
  const std::uint64_t strata = regions.parameters.samples;
  const std::size_t count = cells.count();
  for (std::size_t r = 0; r < count; ++r) {
    const Cell& cell = cells.cells.cell[r];
    const std::uint64_t held = (cell.leaf + std::uint64_t{1}) * strata / count - cell.leaf * strata / count;
    regions.first_stratum[r + 1] = regions.first_stratum[r] + held;
    for (const CellEntry& entry : cells.cells.entries(cell)) {
      const std::uint32_t triangle = cells.triangle[entry.element()], path = cells.path_of(entry);
      const double share = cells.cells.mass(entry) / mass_of(surface, density, triangle, path);
      if (share > 0) regions.region[r].push_back({triangle, path, std::min(share, 1.0)});
    }
  }
}

}  // namespace

SurfaceRegions build_regions(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                             const TriangleHints& hints, RandomKey key, const ElementParameters& parameters,
                             const CancelToken& cancel) {
  const std::uint64_t strata = parameters.samples;
  const std::uint64_t most = samples_per_region(parameters.order);
  const std::uint64_t count = (strata + most - 1) / most;
  SurfaceRegions regions;
  regions.parameters = parameters;
  regions.limit = element_limit(measure, parameters);
  regions.group = sheet_groups(surface.mesh(), charts.charts, hints.sheet);
  regions.region.resize(count);
  regions.first_stratum.resize(count + 1);
  ElementParameters coarse = parameters;
  coarse.samples = count;
  coarse.elements_per_sample = static_cast<double>(most) / samples_per_piece;
  coarse.keep_vertices = false;
  if (parameters.order == ElementOrder::balanced) {
    coarse.strata = strata;
    take_cells(build_cells(surface, measure, charts, hints, key, coarse, cancel), surface, measure.density,
               regions);
  } else {
    for (std::uint64_t r = 0; r <= count; ++r) regions.first_stratum[r] = r * strata / count;
    divide_curve(build_elements(surface, measure, charts, hints, key, coarse, cancel), regions);
  }
  return regions;
}

CurveElements region_elements(const SurfaceRegions& regions, const ElementSource& source, std::size_t region,
                              const CancelToken& cancel) {
  return elements_from(source, &regions.region[region], regions.limit, regions.parameters, cancel);
}

ElementCells region_cells(const SurfaceRegions& regions, const ElementSource& source, std::size_t region,
                          const CancelToken& cancel) {
  return cells_from(source, &regions.region[region], regions.strata(region), regions.limit,
                    regions.parameters, cancel);
}

}  // namespace meander
