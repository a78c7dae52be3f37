#include "kernels/partition/surface_regions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/partition/placed_pieces.h"

namespace meander {

namespace {

// Mass of a whole piece.
double mass_of(const ElementSource& source, std::uint32_t triangle, std::uint32_t path) {
  const TriangleSource from = source_of(source.surface.mesh(), source.density(), triangle);
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

void take_cells(const ElementCells& cells, const ElementSource& source, SurfaceRegions& regions) {
  const std::uint64_t strata = regions.parameters.samples;
  const std::size_t count = cells.count();
  for (std::size_t r = 0; r < count; ++r) {
    const std::uint64_t leaf = cells.cells.cell[r].leaf;
    regions.first_stratum[r + 1] =
        regions.first_stratum[r] + (leaf + 1) * strata / count - leaf * strata / count;
  }
  parallel_tasks(count, [&](std::size_t r) {
    source.cancel.check();
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

SurfaceRegions build_regions(const SurfaceContext& context, const ElementParameters& parameters) {
  const std::uint64_t strata = parameters.samples;
  const std::uint64_t most = samples_per_region(parameters);
  const std::uint64_t count = (strata + most - 1) / most;
  SurfaceRegions regions;
  regions.parameters = parameters;
  regions.limit = element_limit(context.measure, parameters);
  regions.region.resize(count);
  regions.first_stratum.resize(count + 1);
  ElementParameters coarse = parameters;
  coarse.samples = count;
  coarse.elements_per_sample = static_cast<double>(most) / samples_per_piece;
  coarse.use = ElementUse::positions;
  const SurfacePart all{.limit = element_limit(context.measure, coarse), .cells = count, .strata = strata};
  ElementSource source(context, parameters.order);
  source.hints.hits = {};
  if (parameters.order == ElementOrder::balanced) {
    take_cells(cells_from(source, all, coarse), source, regions);
  } else {
    for (std::uint64_t r = 0; r <= count; ++r) regions.first_stratum[r] = r * strata / count;
    divide_curve(elements_from(source, all, coarse), regions);
  }
  regions.group = std::move(source.group);
  const double stratum_mass = context.measure.total() / static_cast<double>(strata);
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

namespace {

SurfacePart part_of(const SurfaceRegions& regions, std::size_t region) {
  const std::uint64_t strata = regions.strata(region);
  return {&regions.region[region], regions.limit, strata, strata, regions.first_stratum[region]};
}

}  // namespace

CurveElements region_elements(const SurfaceRegions& regions, const ElementSource& source,
                              std::size_t region) {
  return elements_from(source, part_of(regions, region), regions.parameters);
}

ElementCells region_cells(const SurfaceRegions& regions, const ElementSource& source, std::size_t region) {
  return cells_from(source, part_of(regions, region), regions.parameters);
}

SurfaceOrder build_order(const SurfaceContext& context, const ElementParameters& parameters,
                         bool in_regions) {
  if (in_regions) return build_regions(context, parameters);
  if (parameters.order == ElementOrder::balanced) return build_cells(context, parameters);
  return build_elements(context, parameters);
}

OrderBytes order_bytes(const OrderSizes& sizes, const ElementParameters& parameters) {
  constexpr double bytes_per_region_piece = 32;  // in vectors that have grown
  const auto bytes = [&](double samples, double triangles, double per_sample) {
    return parameters.order == ElementOrder::balanced
               ? cell_bytes(sizes, parameters, samples, triangles, per_sample)
               : element_bytes(sizes, samples, triangles, per_sample);
  };
  const auto samples = static_cast<double>(parameters.samples);
  if (!sizes.in_regions) {
    const double whole = bytes(samples, sizes.triangles, parameters.elements_per_sample);
    return {whole, whole};
  }
  const auto region = static_cast<double>(samples_per_region(parameters));
  const double regions = std::ceil(samples / region), at_once = std::min<double>(sizes.threads, regions);
  const double pieces = elements_at_most(sizes, samples, sizes.triangles, 1 / samples_per_piece);
  const double own_triangles =
      std::min(sizes.triangles, elements_at_most(sizes, region, sizes.triangles * region / samples, 1));
  return {bytes(regions, pieces, 0),
          pieces * bytes_per_region_piece +
              at_once * bytes(region, own_triangles, parameters.elements_per_sample)};
}

}  // namespace meander
