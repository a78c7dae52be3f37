#include "kernels/sample/sample_sites.h"

#include <algorithm>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/locate/bisection_walk.h"
#include "kernels/sample/cell_net.h"
#include "kernels/sample/sequence.h"

namespace meander {

namespace {

constexpr std::size_t cell_block = 256, least_part = 256;

// The cells are those from rank `first` on.
void find_in_net(const ElementCells& cells, std::size_t first, RandomKey key, bool vertices,
                 SampleSites& found, const CancelToken& cancel) {
  const DigitalShift shift = digital_shift(key);
  const auto find_block = [&](std::size_t begin, CellNetScratch& scratch) {
    cancel.check();
    const std::size_t end = std::min(cells.count(), begin + cell_block);
    for (std::size_t c = begin; c < end; ++c) {
      if (!cells.cells.point.empty()) {
        const CellPoint& point = cells.cells.point[c];
        found.site[first + c] = {cells.triangle[point.name], cells.path[point.name], point.first,
                                 point.second};
        continue;
      }
      const double choice = random_pair(key, Stream::sequence, first + c).first;
      const CellEntry& entry = entry_in_net(cells.cells, cells.cells.cell[c], shift, choice, scratch);
      found.set(first + c, cells.triangle[entry.element()], cells.path_of(entry));
      if (vertices)
        found.set_vertex(first + c, &cells.vertex[2 * std::size_t{entry.element()}], cells.cells.mass(entry));
    }
  };
  // Cells of large meshes have many entries each. Every task copies those of its largest cell: several tasks
  // only where all these copies are little beside the entries themselves.
  std::size_t entries = 0, most = 0;
  for (const Cell& cell : cells.cells.cell) {
    entries += cell.entries;
    most = std::max<std::size_t>(most, cell.entries);
  }
  const std::size_t blocks = (cells.count() + cell_block - 1) / cell_block;
  if (entries >= parallel_threshold && most <= entries / least_part) {
    parallel_tasks(blocks, [&](std::size_t block) {
      CellNetScratch scratch;
      find_block(block * cell_block, scratch);
    });
    return;
  }
  CellNetScratch scratch;
  for (std::size_t block = 0; block < blocks; ++block) find_block(block * cell_block, scratch);
}

// Calls take(r, element) for every position. Half-open; positions ascend: one linear merge.
template <class Take>
void at_positions(const CurveElements& elements, std::span<const double> position, const CancelToken& cancel,
                  const Take& take) {
  const double total = elements.total();
  std::size_t at = 0;
  std::size_t last =
      elements.count() -
      1;  // positions that rounding pushes past the end belong to the last element of positive mass
  while (last > 0 && !(elements.cumulative[last + 1] > elements.cumulative[last])) --last;
  for (std::size_t r = 0; r < position.size(); ++r) {
    if (r % sum_block == 0) cancel.check();
    const double target = position[r] * total;
    while (at < last && elements.cumulative[at + 1] <= target) ++at;
    take(r, at, target);
  }
}

// Of a region, whose wide pieces are elements.
SampleSites parts_at(const CurveElements& elements, const MeasuredMesh& surface,
                     std::span<const double> position, const CancelToken& cancel) {
  SampleSites found(position.size(), false);
  BisectionWalk walk(surface, elements);
  at_positions(elements, position, cancel, [&](std::size_t r, std::size_t at, double target) {
    const double begin = elements.cumulative[at], mass = elements.cumulative[at + 1] - begin;
    found.set(r, elements.triangle[at], walk.path_at(at, std::clamp((target - begin) / mass, 0.0, 1.0)));
  });
  return found;
}

}  // namespace

SampleSites elements_at(const CurveElements& elements, std::span<const double> position, bool vertices,
                        const CancelToken& cancel) {
  SampleSites found(position.size(), vertices);
  at_positions(elements, position, cancel, [&](std::size_t r, std::size_t at, double) {
    found.set(r, elements.triangle[at], elements.path[at]);
    if (vertices)
      found.set_vertex(r, &elements.vertex[2 * at], elements.cumulative[at + 1] - elements.cumulative[at]);
  });
  return found;
}

SampleSites elements_at(const ElementCells& cells, std::span<const double> position, bool vertices,
                        const CancelToken& cancel) {
  if (!cells.cells.point.empty())
    throw std::invalid_argument("elements_at: cells are points of a net, and have no elements");
  SampleSites found(position.size(), vertices);
  const auto count = static_cast<double>(cells.count());
  parallel_blocks(position.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    std::vector<std::uint64_t> scratch;
    for (std::size_t r = begin; r < end; ++r) {
      const double at = position[r] * count;
      const std::size_t c = std::min(static_cast<std::size_t>(at), cells.count() - 1);
      const CellEntry& entry =
          entry_at(cells.cells, cells.cells.cell[c], std::min(at - static_cast<double>(c), 1.0), scratch);
      found.set(r, cells.triangle[entry.element()], cells.path_of(entry));
      if (vertices)
        found.set_vertex(r, &cells.vertex[2 * std::size_t{entry.element()}], cells.cells.mass(entry));
    }
  });
  return found;
}

SampleSites elements_in_net(const ElementCells& cells, RandomKey key, bool vertices,
                            const CancelToken& cancel) {
  SampleSites found(cells.count(), vertices);
  find_in_net(cells, 0, key, vertices, found, cancel);
  return found;
}

SampleSites elements_in_net(const SurfaceRegions& regions, const ElementSource& source, RandomKey key,
                            bool vertices, const CancelToken& cancel) {
  SampleSites found(regions.parameters.samples, vertices);
  parallel_tasks(regions.count(), [&](std::size_t region) {
    find_in_net(region_cells(regions, source, region, cancel), regions.first_stratum[region], key, vertices,
                found, cancel);
  });
  return found;
}

// Regions have whole strata: positions in strata, less those before, are those in the region.
SampleSites elements_at(const SurfaceRegions& regions, const ElementSource& source,
                        std::span<const double> position, bool vertices, const CancelToken& cancel) {
  SampleSites found(position.size(), vertices);
  const auto samples = static_cast<double>(regions.parameters.samples);
  const auto rank_at = [&](std::size_t region) {
    if (region == regions.count()) return position.size();
    const auto first = static_cast<double>(regions.first_stratum[region]);
    const auto at =
        std::partition_point(position.begin(), position.end(), [&](double p) { return p * samples < first; });
    return static_cast<std::size_t>(at - position.begin());
  };
  parallel_tasks(regions.count(), [&](std::size_t region) {
    const std::size_t begin = rank_at(region), end = rank_at(region + 1);
    if (begin == end) return;
    const auto first = static_cast<double>(regions.first_stratum[region]);
    const auto strata = static_cast<double>(regions.strata(region));
    std::vector<double> local(end - begin);
    for (std::size_t i = 0; i < local.size(); ++i)
      local[i] = std::min((position[begin + i] * samples - first) / strata, below_one);
    if (regions.parameters.order == ElementOrder::balanced) {
      found.set_all(begin,
                    elements_at(region_cells(regions, source, region, cancel), local, vertices, cancel));
      return;
    }
    const CurveElements elements = region_elements(regions, source, region, cancel);
    found.set_all(begin, elements.place.empty() ? elements_at(elements, local, vertices, cancel)
                                                : parts_at(elements, source.surface, local, cancel));
  });
  return found;
}

}  // namespace meander
