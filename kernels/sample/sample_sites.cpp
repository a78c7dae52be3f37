#include "kernels/sample/sample_sites.h"

#include <algorithm>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/partition/bisection_walk.h"
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

// The first element from `at` on, `last` at most, that ends behind the target. Few steps find most; where
// elements are many more than positions, steps that double do.
std::size_t element_behind(std::span<const double> cumulative, std::size_t at, std::size_t last,
                           double target) {
  constexpr std::size_t few = 16;
  const std::size_t near = std::min(last, at + few);
  while (at < near && cumulative[at + 1] <= target) ++at;
  if (at < near || at == last) return at;
  std::size_t begin = at, step = few;
  while (step < last - begin && cumulative[begin + step + 1] <= target) {
    begin += step;
    step *= 2;
  }
  const auto first = cumulative.begin() + 1;
  const auto from = first + static_cast<std::ptrdiff_t>(begin),
             to = first + static_cast<std::ptrdiff_t>(std::min(last, begin + step));
  return static_cast<std::size_t>(std::upper_bound(from, to, target) - first);
}

// Calls take(r, element, mass before the position) for every position. Half-open; positions ascend.
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
    at = element_behind(elements.cumulative, at, last, target);
    take(r, at, target);
  }
}

// Places samples in the parts of the wide pieces of a region, which are elements, from rank `first` on.
void place_in_parts(const CurveElements& elements, const MeasuredMesh& surface,
                    std::span<const double> position, std::size_t first, RandomKey key, SampleSites& found,
                    const CancelToken& cancel) {
  BisectionWalk walk(surface, elements);
  at_positions(elements, position, cancel, [&](std::size_t r, std::size_t at, double target) {
    const double begin = elements.cumulative[at], mass = elements.cumulative[at + 1] - begin;
    const BisectionWalk::Part& part = walk.part_at(at, std::clamp((target - begin) / mass, 0.0, 1.0));
    const std::size_t rank = first + r;
    found.set(rank, elements.triangle[at], part.path);
    found.set_point(rank, drawn_point(part.weights, static_cast<std::uint32_t>(rank), key));
  });
}

// Samples of uniform density, each at the point of its piece or at a uniform one.
void draw_points(const MeasuredMesh& surface, std::size_t begin, std::size_t end, RandomKey key,
                 SampleSites& sites) {
  PieceWalk walk(surface);
  for (std::size_t r = begin; r < end; ++r) {
    const SampleSite& site = sites.site[r];
    const Piece& piece = walk.to(site.triangle, site.path);
    sites.set_point(r, site.b1 == SampleSite::nowhere ? drawn_point(piece, static_cast<std::uint32_t>(r), key)
                                                      : point_in(piece, site));
  }
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

SampleSites elements_in_net(const SurfaceRegions& regions, const ElementSource& source, bool vertices) {
  SampleSites found(regions.parameters.samples, vertices);
  found.drawn = source.density().uniform() && !vertices;
  parallel_tasks(regions.count(), [&](std::size_t region) {
    const std::size_t begin = regions.first_stratum[region];
    find_in_net(region_cells(regions, source, region), begin, source.key, vertices, found, source.cancel);
    if (found.drawn) draw_points(source.surface, begin, begin + regions.strata(region), source.key, found);
  });
  return found;
}

// Regions have whole strata: positions in strata, less those before, are those in the region.
SampleSites elements_at(const SurfaceRegions& regions, const ElementSource& source,
                        std::span<const double> position, bool vertices) {
  SampleSites found(position.size(), vertices);
  found.drawn = source.density().uniform() && !vertices;
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
                    elements_at(region_cells(regions, source, region), local, vertices, source.cancel));
    } else {
      const CurveElements elements = region_elements(regions, source, region);
      if (!elements.place.empty()) {  // of uniform density, without vertices
        place_in_parts(elements, source.surface, local, begin, source.key, found, source.cancel);
        return;
      }
      found.set_all(begin, elements_at(elements, local, vertices, source.cancel));
    }
    if (found.drawn) draw_points(source.surface, begin, end, source.key, found);
  });
  return found;
}

}  // namespace meander
