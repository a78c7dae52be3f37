#include "kernels/partition/surface_regions.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/partition/placed_pieces.h"

namespace meander {

namespace {

// Mass of a whole piece.
double mass_of(const ElementSource& source, std::uint32_t triangle, std::uint32_t path) {
  const TriangleSource from = source_of(source.surface.mesh(), source.density, triangle);
  if (from.uniform || from.means != nullptr) return piece_mass(from, {}, path);
  return piece_mass(from, piece_of(bisection_corners(source.surface, triangle), path), path);
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
        regions.region[r].piece.push_back(
            {elements.triangle[i], elements.path[i], std::min(held / mass, 1.0)});
    }
  }
}

void take_cells(const ElementCells& cells, const ElementSource& source, SurfaceRegions& regions,
                const CancelToken& cancel) {
  const std::uint64_t strata = regions.parameters.samples;
  const std::size_t count = cells.count();
  for (std::size_t r = 0; r < count; ++r) {
    const std::uint64_t leaf = cells.cells.cell[r].leaf;
    regions.first_stratum[r + 1] =
        regions.first_stratum[r] + (leaf + 1) * strata / count - leaf * strata / count;
  }
  parallel_tasks(count, [&](std::size_t r) {
    cancel.check();
    const Cell& cell = cells.cells.cell[r];
    regions.region[r].piece.reserve(cell.entries);
    for (const CellEntry& entry : cells.cells.entries(cell)) {
      const std::uint32_t triangle = cells.triangle[entry.element()], path = cells.path_of(entry);
      const double share = cells.cells.mass(entry) / mass_of(source, triangle, path);
      if (share > 0) regions.region[r].piece.push_back({triangle, path, std::min(share, 1.0)});
    }
  });
}

}  // namespace

SurfaceRegions build_regions(const MeasuredMesh& surface, const MeshMeasure& measure, const ChartSet& charts,
                             std::span<const std::uint8_t> sheet, RandomKey key,
                             const ElementParameters& parameters, const CancelToken& cancel) {
  const std::uint64_t strata = parameters.samples;
  const std::uint64_t most = samples_per_region(parameters);
  const std::uint64_t count = (strata + most - 1) / most;
  SurfaceRegions regions;
  regions.parameters = parameters;
  regions.limit = element_limit(measure, parameters);
  regions.region.resize(count);
  regions.first_stratum.resize(count + 1);
  ElementParameters coarse = parameters;
  coarse.samples = count;
  coarse.elements_per_sample = static_cast<double>(most) / samples_per_piece;
  coarse.keep_vertices = coarse.net_points = coarse.keep_polygons = false;
  const double limit = element_limit(measure, coarse);
  ElementSource source(surface, measure.density, charts, {},
                       sheet_groups(surface.mesh(), charts.charts, sheet), parameters.order, key);
  if (parameters.order == ElementOrder::balanced) {
    take_cells(cells_from(source, nullptr, count, strata, 0, limit, coarse, cancel), source, regions, cancel);
  } else {
    for (std::uint64_t r = 0; r <= count; ++r) regions.first_stratum[r] = r * strata / count;
    divide_curve(elements_from(source, nullptr, limit, coarse, cancel), regions);
  }
  regions.group = std::move(source.group);
  const double stratum_mass = measure.total() / static_cast<double>(strata);
  for (std::size_t r = 0; r < regions.count(); ++r) {
    SurfaceRegion& region = regions.region[r];
    const auto held = static_cast<double>(regions.strata(r));
    // Pieces of large triangles weigh between half the limit and all of it.
    region.expected_elements =
        region.piece.size() + static_cast<std::size_t>(1.5 * parameters.elements_per_sample * held);
    region.mass = stratum_mass * held;
  }
  return regions;
}

CurveElements region_elements(const SurfaceRegions& regions, const ElementSource& source, std::size_t region,
                              const CancelToken& cancel) {
  return elements_from(source, &regions.region[region], regions.limit, regions.parameters, cancel);
}

ElementCells region_cells(const SurfaceRegions& regions, const ElementSource& source, std::size_t region,
                          const CancelToken& cancel) {
  const std::uint64_t strata = regions.strata(region);
  return cells_from(source, &regions.region[region], strata, strata, regions.first_stratum[region],
                    regions.limit, regions.parameters, cancel);
}

}  // namespace meander
