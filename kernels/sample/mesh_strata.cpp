#include "kernels/sample/mesh_strata.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kernels/sample/median_place.h"

namespace meander {

namespace {

// Acceptance of a linear density is at least 1/3 a trial: 64 misses in a row happen once in 10^11 draws.
constexpr std::uint32_t max_trials = 64;
// Cells that fewer points are wanted of are not put in order for them.
constexpr std::size_t ordered_draws = 3;

double unit_from(std::uint32_t word) { return word * 0x1p-32; }

}  // namespace

void MeshStrata::open(std::uint32_t triangle, std::uint32_t path, OpenElement& element) const {
  if (element.triangle == triangle && element.path == path) return;
  if (element.triangle != triangle) element.source = source_of(surface_.mesh(), density_, triangle);
  element.triangle = triangle;
  element.path = path;
  element.piece =
      path == 1 ? Piece{{0, 1, 0}, {0, 0, 1}} : piece_of(bisection_corners(surface_, triangle), path);
  if (element.source.uniform || element.source.means != nullptr) return;
  element.largest = 0;
  for (std::size_t k = 0; k < 3; ++k)
    element.largest =
        std::max(element.largest, element.source.density_at(element.piece.b1[k], element.piece.b2[k]));
}

StratumPoint MeshStrata::point_in(const OpenElement& element, const PointDraw& draw) const {
  const TriangleSource& source = element.source;
  StratumPoint point;
  point.triangle = element.triangle;
  point.path = element.path;
  // words[0] has chosen the element.
  std::array<std::uint32_t, 3> words = {draw.words[1], draw.words[2], draw.words[3]};
  bool placed = source.means != nullptr;
  if (placed) {
    const WorkPiece part = part_by_mass(source, element.path, unit_from(words[2]));
    const auto weights = uniform_point(part.weights, unit_from(words[0]), unit_from(words[1]));
    point.first = weights[0];
    point.second = weights[1];
    point.density = std::max(static_cast<float>(source.mean_of(part.path)), 1e-30f);
  }
  for (std::uint32_t trial = 1; !placed; ++trial) {
    const auto weights = uniform_point(element.piece, unit_from(words[0]), unit_from(words[1]));
    point.first = weights[0];
    point.second = weights[1];
    placed = source.uniform || trial == max_trials ||
             unit_from(words[2]) * element.largest <= source.density_at(point.first, point.second);
    if (placed) break;
    const PhiloxBlock next =
        random_words(key_, Stream::stratum_retry, draw.index, draw.number * max_trials + trial);
    words = {next[0], next[1], next[2]};
  }
  const Vector3 at = source.at(point.first, point.second) - origin_;
  point.at = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
  if (!source.uniform && source.means == nullptr)
    point.density = std::max(static_cast<float>(source.density_at(point.first, point.second)), 1e-30f);
  return point;
}

StratumPoint MeshStrata::point_in(const OpenElement& element, std::span<const std::array<float, 2>> polygon,
                                  const PointDraw& draw) const {
  StratumPoint point;
  point.triangle = element.triangle;
  point.path = element.path;
  const auto weights = uniform_point(polygon, unit_from(draw.words[1]), unit_from(draw.words[2]));
  point.first = weights[0];
  point.second = weights[1];
  const Vector3 at = element.source.at(point.first, point.second) - origin_;
  point.at = {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
  return point;
}

template <class TriangleOf>
void MeshStrata::set_origin(std::size_t count, const TriangleOf& triangle_of) {
  const PreparedMesh& mesh = surface_.mesh();
  origin_ = median_place(
      count, [&](std::size_t i) { return mesh.position(mesh.triangles[3 * std::size_t{triangle_of(i)}]); });
}

CurveStrata::CurveStrata(const CurveElements& elements, std::uint32_t count, const MeasuredMesh& surface,
                         const Density& density, RandomKey key, const MetricAt& metric)
    : MeshStrata(surface, density, key, metric),
      elements_(elements),
      count_(count),
      shift_(random_pair(key, Stream::sequence_shift, 0).first),
      last_(elements.count() - 1) {
  while (last_ > 0 && !(elements.cumulative[last_ + 1] > elements.cumulative[last_])) --last_;
  // By mass, not by element.
  set_origin(count_, [&](std::size_t stratum) {
    const double target = (static_cast<double>(stratum) + 0.5) / count_ * elements_.total();
    const auto above = std::upper_bound(elements_.cumulative.begin() + 1, elements_.cumulative.end(), target);
    const auto element = static_cast<std::size_t>(above - elements_.cumulative.begin()) - 1;
    return elements_.triangle[std::min(element, last_)];
  });
}

void CurveStrata::draw(std::span<const PointDraw> draws, std::span<StratumPoint> points) const {
  const std::vector<double>& sums = elements_.cumulative;
  OpenElement opened;
  std::size_t element = 0;
  double before = INFINITY;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    double at = draws[i].at + shift_;
    if (at >= count_) at -= count_;
    const double target = at / count_ * elements_.total();
    // The next point is in the same element or near it, but for the first one and where the curve ends.
    constexpr std::size_t near = 16;
    std::size_t steps = 0;
    if (target >= before)
      for (; steps < near && element < last_ && sums[element + 1] <= target; ++steps) ++element;
    if (!(target >= before) || steps == near) {
      const auto above = std::upper_bound(sums.begin() + 1, sums.end(), target);
      element = std::min(static_cast<std::size_t>(above - sums.begin()) - 1, last_);
    }
    before = target;
    open(elements_.triangle[element], elements_.path[element], opened);
    points[i] = point_in(opened, draws[i]);
  }
}

CellStrata::CellStrata(const ElementCells& cells, const MeasuredMesh& surface, const Density& density,
                       RandomKey key, const MetricAt& metric)
    : MeshStrata(surface, density, key, metric), cells_(cells) {
  if (!cells.cells.point.empty())
    throw std::invalid_argument("strata: cells are points of a net, and have no elements");
  double mass = 0;
  for (const CellEntry& entry : cells.cells.entries(cells.cells.cell.front()))
    mass += cells.cells.mass(entry);
  measure_ = mass * static_cast<double>(cells.count());
  set_origin(cells.count(), [&](std::size_t cell) {
    return cells_.triangle[cells_.cells.entries(cells_.cells.cell[cell]).front().element()];
  });
}

void CellStrata::draw(std::span<const PointDraw> draws, std::span<StratumPoint> points) const {
  const auto cell_of = [&](const PointDraw& draw) {
    return std::min(static_cast<std::size_t>(draw.at), cells_.count() - 1);
  };
  OpenElement opened;
  const auto place = [&](const Cell& cell, const CellEntry& entry, std::size_t i) {
    open(cells_.triangle[entry.element()], cells_.path_of(entry), opened);
    if (cells_.has_polygons()) {
      const auto number = static_cast<std::size_t>(&entry - cells_.cells.block[cell.block].data());
      points[i] = point_in(opened, cells_.cells.polygon[cell.block][number], draws[i]);
    } else {
      points[i] = point_in(opened, draws[i]);
    }
  };
  std::vector<std::uint64_t> scratch;
  std::vector<std::uint32_t> order;
  for (std::size_t begin = 0, end = 0; begin < draws.size(); begin = end) {
    const std::size_t c = cell_of(draws[begin]);
    while (end < draws.size() && cell_of(draws[end]) == c) ++end;
    const Cell& cell = cells_.cells.cell[c];
    const auto share = [&](std::size_t i) {
      return std::clamp(draws[i].at - static_cast<double>(c), 0.0, 1.0);
    };
    if (end - begin < ordered_draws) {
      for (std::size_t i = begin; i < end; ++i)
        place(cell, entry_at(cells_.cells, cell, share(i), scratch), i);
      continue;
    }
    // The same entries, all at once.
    const std::span<const CellEntry> entries = cells_.cells.entries(cell);
    order_entries(cells_.cells, cell, order);
    std::uint64_t total = 0;
    for (const CellEntry& entry : entries) total += entry.mass;
    std::uint64_t below = entries[order[0]].mass;
    std::size_t at = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto target =
          std::min(static_cast<std::uint64_t>(share(i) * static_cast<double>(total)), total - 1);
      while (below <= target && at + 1 < order.size()) below += entries[order[++at]].mass;
      place(cell, entries[order[at]], i);
    }
  }
}

}  // namespace meander
