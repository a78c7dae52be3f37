// Spaced samples of a level: what there is around each stratum, and how the surface attracts.
#include "kernels/sample/spaced_level.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/parallel.h"

namespace meander::spaced {

namespace {

// Steps to the distance within which no more sheets lie than let samples be so far apart: each halves the
// error.
constexpr int distance_steps = 5;
// Strata farther away than this, in spacings, attract by their moments.
constexpr float near_gap = 0.25f;
// Where the surface attracts with less than this part of a sample's kernel, as along a needle, samples are
// out of each other's reach, and no place is better than another one.
constexpr float min_attraction = 0.25f;
// Twice the trace of the second moments of groups of points is at least so large, so that its root has an
// inverse.
constexpr float min_trace = 1e-36f;
// Strata that are looked at around one: about 50 on a smooth surface, more where sheets are stacked. Where
// there are more, the stratum looks less far, by this factor each time.
constexpr std::size_t max_neighbors = 384;
constexpr float shorter_reach = 0.75f;
constexpr int max_shortenings = 8;
// Strata of a run along the path look for their neighbors together, unless the run is longer than this, in
// what they look across, or has more neighbors.
constexpr std::uint32_t run_strata = 16;
constexpr float longest_run = 4;
constexpr std::size_t max_candidates = 2048;

}  // namespace

// Scratch of a thread that finds neighbors.
struct SpacedLevel::Search {
  Search(const StratumGrid& over, std::size_t count) : grid(over) {
    places.resize(count);
    others.resize(count);
  }
  const StratumGrid& grid;
  StratumGrid::Scratch scratch;
  PointRows places, others;               // of a stratum, and of one near it
  std::vector<std::uint32_t> candidates;  // near any of a run of strata, ascending
  BoxRows boxes;                          // of the candidates
  std::vector<float> beyond;              // by candidate: <= 0 where it is near a stratum
  std::vector<std::uint32_t> found;
};

void SpacedLevel::find_neighbors() {
  // Cells begin at the least reach, unless the density differs by more than any stratum needs to see.
  double sum = 0, least = INFINITY;
  for (const float spacing : spacing_) {
    sum += spacing;
    least = std::min(least, static_cast<double>(spacing));
  }
  StratumGrid grid(kernel_reach * std::max(least, min_cell * sum / static_cast<double>(spacing_.size())));
  for (std::uint32_t s = 0; s < blocks_.count; ++s) {
    if (s % sum_block == 0) cancel_.check();
    PointBox box = grown(offered_.box(s), margin(s));
    if (is_held(s)) enclose(box, sample_at(s));
    grid.add(box, in_space(s, reach_of(s)));
  }
  grid.build();
  parallel_tasks((blocks_.count + draw_block - 1) / draw_block, [&](std::size_t block) {
    Search search(grid, offered_.places());
    const auto end =
        static_cast<std::uint32_t>(std::min<std::size_t>((block + 1) * draw_block, blocks_.count));
    for (auto first = static_cast<std::uint32_t>(block * draw_block); first < end; first += run_strata) {
      cancel_.check();
      const std::uint32_t last = std::min(first + run_strata, end);
      const bool together = find_candidates(first, last, search);
      for (std::uint32_t s = first; s < last; ++s) {
        search.found.clear();
        if (!is_held(s)) look_around(s, together && !is_torn(s), search);
        near_.write(s, search.found);
      }
    }
    near_.close(block);
  });
}

bool SpacedLevel::find_candidates(std::uint32_t first, std::uint32_t last, Search& search) const {
  PointBox run{};
  float distance = 0;
  bool any = false;
  for (std::uint32_t s = first; s < last; ++s) {
    if (is_held(s) || is_torn(s)) continue;
    const PointBox& box = offered_.box(s);
    if (!any) run = box;
    enclose(run, {box.low[0], box.low[1], box.low[2]});
    enclose(run, {box.high[0], box.high[1], box.high[2]});
    distance = std::max(distance, around(s));
    any = true;
  }
  const auto is_long = [&](std::size_t k) { return run.high[k] - run.low[k] > longest_run * distance; };
  if (!any || is_long(0) || is_long(1) || is_long(2)) return false;
  const auto is_near = [&](std::uint32_t other) {
    const float within = distance + margin(other);
    return squared_gap(offered_.box(other), run) <= within * within ||
           (is_held(other) && is_within(run, sample_at(other), distance));
  };
  if (!search.grid.find_around(run, distance, max_candidates, is_near, search.candidates)) return false;
  std::sort(search.candidates.begin(), search.candidates.end());
  const std::size_t count = search.candidates.size();
  search.boxes.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t other = search.candidates[i];
    const PointBox& box = offered_.box(other);
    for (std::size_t k = 0; k < 3; ++k) {
      search.boxes.low[k][i] = box.low[k];
      search.boxes.high[k][i] = box.high[k];
    }
    search.boxes.margin[i] = margin(other);
  }
  return true;
}

void SpacedLevel::look_around(std::uint32_t stratum, bool among_candidates, Search& search) {
  const PointBox& box = offered_.box(stratum);
  offered_.load(stratum, search.places, 0);
  for (int shortening = 0; shortening <= max_shortenings; ++shortening) {
    const float distance = around(stratum);
    if (among_candidates) {
      pick_candidates(stratum, distance, search);
    } else {
      const auto is_near = [&](std::uint32_t other, const PointBox& place) {
        return other != stratum && (may_touch(other, place, distance + margin(other), search.others) ||
                                    (is_held(other) && is_within(place, sample_at(other), distance)));
      };
      search.grid.find(search.places.x, search.places.y, search.places.z, box, is_torn(stratum), distance,
                       max_neighbors, is_near, search.scratch, search.found);
    }
    if (search.found.size() < max_neighbors) break;
    reach_[stratum] *= shorter_reach;
  }
}

void SpacedLevel::pick_candidates(std::uint32_t stratum, float distance, Search& search) const {
  const PointBox box = offered_.box(stratum);
  const std::size_t count = search.candidates.size();
  find_gaps(search.boxes, box.low, box.high, distance, search.beyond);
  search.found.resize(count);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t other = search.candidates[i];
    bool near = search.beyond[i] <= 0;
    if (near && is_torn(other)) near = may_touch(other, box, distance + margin(other), search.others);
    if (!near && is_held(other)) near = is_within(box, sample_at(other), distance);
    search.found[found] = other;
    found += near && other != stratum ? 1 : 0;
  }
  search.found.resize(found);
}

bool SpacedLevel::may_touch(std::uint32_t stratum, const PointBox& box, float distance,
                            PointRows& places) const {
  if (squared_gap(offered_.box(stratum), box) > distance * distance) return false;
  if (!is_torn(stratum)) return true;
  places.resize(offered_.places());
  offered_.load(stratum, places, 0);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (is_within(box, {places.x[i], places.y[i], places.z[i]}, distance)) return true;
  return false;
}

bool SpacedLevel::takes(std::uint32_t stratum, const Point& at, PointRows& places) const {
  const PointBox point = {{at.x, at.y, at.z}, {at.x, at.y, at.z}};
  return may_touch(stratum, point, margin(stratum), places);
}

void SpacedLevel::to_metric(std::uint32_t stratum, PointRows& points, std::size_t count) const {
  if (metric_.empty()) return;
  const auto& rows = metric_[stratum].rows;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = points.x[i], y = points.y[i], z = points.z[i];
    points.x[i] = rows[0][0] * x + rows[0][1] * y + rows[0][2] * z;
    points.y[i] = rows[1][0] * x + rows[1][1] * y + rows[1][2] * z;
    points.z[i] = rows[2][0] * x + rows[2][1] * y + rows[2][2] * z;
  }
}

PointMoments SpacedLevel::to_metric(std::uint32_t stratum, const PointMoments& moments) const {
  const auto& rows = metric_[stratum].rows;
  const std::array<float, 6>& c = moments.central;
  const std::array<std::array<float, 3>, 3> central{
      {{c[0], c[5], c[4]}, {c[5], c[1], c[3]}, {c[4], c[3], c[2]}}};
  const auto along = [&](std::size_t i, std::size_t j) {
    float sum = 0;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l) sum += rows[i][k] * central[k][l] * rows[j][l];
    return sum;
  };
  PointMoments result{{}, {along(0, 0), along(1, 1), along(2, 2), along(1, 2), along(0, 2), along(0, 1)}};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) result.mean[i] += rows[i][k] * moments.mean[k];
  result.per_extent = inverse_extent(result.central);
  return result;
}

float SpacedLevel::inverse_extent(const std::array<float, 6>& central) {
  return 1 / std::sqrt(std::max(2 * (central[0] + central[1] + central[2]), min_trace));
}

void SpacedLevel::find_moments() {
  const std::size_t places = offered_.places();
  const float share = 1 / static_cast<float>(places);
  moments_.resize(blocks_.count);
  parallel_blocks(blocks_.count, draw_block, [&](std::size_t begin, std::size_t end) {
    PointRows rows;
    rows.resize(places);
    for (std::size_t s = begin; s < end; ++s) {
      offered_.load(s, rows, 0);
      PointMoments& moments = moments_[s];
      auto& [x, y, z] = moments.mean;
      for (std::size_t k = 0; k < places; ++k) {
        x += share * rows.x[k];
        y += share * rows.y[k];
        z += share * rows.z[k];
      }
      for (std::size_t k = 0; k < places; ++k) {
        const float dx = rows.x[k] - x, dy = rows.y[k] - y, dz = rows.z[k] - z;
        moments.central[0] += share * dx * dx;
        moments.central[1] += share * dy * dy;
        moments.central[2] += share * dz * dz;
        moments.central[3] += share * dy * dz;
        moments.central[4] += share * dx * dz;
        moments.central[5] += share * dx * dy;
      }
      moments.per_extent = inverse_extent(moments.central);
    }
  });
}

void SpacedLevel::attract(std::uint32_t stratum, Visit& visit) const {
  const std::size_t places = offered_.places();
  const PointBox box = box_of(visit.places);
  const float far = in_space(stratum, reach_of(stratum)),
              close = in_space(stratum, near_gap * spacing_[stratum]);
  if (visit.background.size() < places) visit.background.resize(places);
  offered_.load(stratum, visit.background, 0);
  visit.weight.assign(1, stratum);
  visit.groups.clear();
  std::size_t count = places;
  for (const std::uint32_t other : visit.near) {
    const float gap = squared_gap(offered_.box(other), box);
    if (gap > far * far) continue;
    // A torn stratum has no middle.
    if (gap > close * close && !is_torn(other)) {
      find_group(stratum, other, visit.groups.emplace_back());
      continue;
    }
    if (visit.background.size() < count + places) visit.background.resize(count + places);
    offered_.load(other, visit.background, count);
    visit.weight.push_back(other);
    count += places;
  }
  to_metric(stratum, visit.background, count);
  places_to_metric(stratum, visit);
  visit.energy.assign(visit.places.size(), 0);
  KernelScale scale{1 / reach_of(stratum)};
  const auto add = [&](std::size_t first, std::size_t last) {
    scale.weight = mass_of(visit.weight[first]) / static_cast<float>(places);
    add_kernel(visit.places, visit.background, first * places, (last - first) * places, scale, visit.energy);
  };
  add(0, 1);
  visit.own = visit.energy;
  // Strata of one mass in one go.
  for (std::size_t first = 1, last; first < visit.weight.size(); first = last) {
    last = first + 1;
    while (last < visit.weight.size() &&
           (equal_ || blocks_.size(visit.weight[last]) == blocks_.size(visit.weight[first])))
      ++last;
    add(first, last);
  }
  add_group_kernel(visit.places, visit.groups, scale.per_reach, visit.energy);
}

float SpacedLevel::flat_attraction(std::uint32_t stratum) const {
  return static_cast<float>(std::numbers::pi / 6) * reach_[stratum] * reach_[stratum];
}

void SpacedLevel::find_attraction(const std::vector<std::uint32_t>& strata) {
  const std::size_t places = offered_.places();
  if (strata.size() < blocks_.count) {
    slot_.resize(blocks_.count);
    for (std::size_t i = 0; i < strata.size(); ++i) slot_[strata[i]] = static_cast<std::uint32_t>(i);
  }
  attraction_ = PackedRows(strata.size(), places);
  fullness_.resize(strata.size());
  around_.resize(strata.size());
  visit_all(strata, [&](std::size_t i, std::uint32_t s, Visit& visit) {
    load_places(s, visit);
    attract(s, visit);
    float mean = 0;
    for (const float energy : visit.energy) mean += energy / static_cast<float>(places);
    fullness_[i] = mean / flat_attraction(s);
    around_[i] = 1;
    const float share = own_share(s);
    for (std::size_t k = 0; k < places; ++k)
      visit.energy[k] = mean < min_attraction ? 0 : visit.energy[k] - share * visit.own[k];
    attraction_.write(i, visit.energy);
  });
  // Beside samples of earlier levels there is no room for more than between sheets that coincide: too many
  // would be too near to leave.
  if (blocks_.count == blocks_.leaves && slot_.empty() &&
      std::ranges::any_of(strata, [&](std::uint32_t s) { return sheets_at(s) > 1; }))
    apart_.resize(strata.size());
  visit_all(strata, [&](std::size_t i, std::uint32_t s, Visit& visit) {
    if (!apart_.empty()) apart_[i] = distance_among_sheets(s, visit.near);
    const float before = own_share(s);
    around_[i] = mean_fullness(visit.near);
    const float more = own_share(s) - before;
    if (more == 0 || fullness_[i] * flat_attraction(s) < min_attraction) return;
    load_places(s, visit);
    visit.near.clear();
    attract(s, visit);
    attraction_.read(i, visit.energy);
    for (std::size_t k = 0; k < places; ++k) visit.energy[k] -= more * visit.own[k];
    attraction_.write(i, visit.energy);
  });
}

template <class VisitStratum>
void SpacedLevel::visit_all(const std::vector<std::uint32_t>& strata, const VisitStratum& visit_stratum) {
  parallel_tasks((strata.size() + draw_block - 1) / draw_block, [&](std::size_t block) {
    cancel_.check();
    Visit visit;
    const std::size_t end = std::min((block + 1) * draw_block, strata.size());
    for (std::size_t i = block * draw_block; i < end; ++i) {
      near_.read(strata[i], visit.near);
      visit_stratum(i, strata[i], visit);
    }
  });
}

float SpacedLevel::mean_fullness(const std::vector<std::uint32_t>& strata) const {
  float sum = 0, count = 0;
  for (const std::uint32_t s : strata) {
    if (is_held(s)) continue;
    sum += fullness_[slot_of(s)];
    count += 1;
  }
  return count > 0 ? sum / count : 1.0f;
}

float SpacedLevel::distance_among_sheets(std::uint32_t stratum,
                                         const std::vector<std::uint32_t>& near) const {
  const float coincident = distance_on_sheets(stratum);
  if (coincident == 1) return 1;
  const float thickness = thickness_around(stratum, near) / spacing_[stratum];
  float distance = coincident;
  for (int step = 0; step < distance_steps; ++step)
    distance = coincident * std::sqrt(std::max(thickness / distance, 1.0f));
  return std::min(distance, 1.0f);
}

float SpacedLevel::thickness_around(std::uint32_t stratum, const std::vector<std::uint32_t>& near) const {
  PointGroup own, group;
  find_group(stratum, stratum, own);
  const float far = reach_of(stratum);
  double mass = own.mass;
  std::array<double, 3> sum{};
  std::array<double, 6> square{};  // xx, yy, zz, yz, xz, xy
  for (const std::uint32_t other : near) {
    find_group(stratum, other, group);
    const double x = double(group.mean[0]) - double(own.mean[0]),
                 y = double(group.mean[1]) - double(own.mean[1]),
                 z = double(group.mean[2]) - double(own.mean[2]);
    if (x * x + y * y + z * z > double(far) * double(far)) continue;
    const double m = group.mass;
    mass += m;
    sum = {sum[0] + m * x, sum[1] + m * y, sum[2] + m * z};
    square = {square[0] + m * x * x, square[1] + m * y * y, square[2] + m * z * z,
              square[3] + m * y * z, square[4] + m * x * z, square[5] + m * x * y};
  }
  const auto central = [&](std::size_t k, std::size_t a, std::size_t b) {
    return square[k] / mass - sum[a] / mass * (sum[b] / mass);
  };
  const double xx = central(0, 0, 0), yy = central(1, 1, 1), zz = central(2, 2, 2), yz = central(3, 1, 2),
               xz = central(4, 0, 2), xy = central(5, 0, 1);
  const double minors = xx * yy - xy * xy + yy * zz - yz * yz + xx * zz - xz * xz;
  const double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  return minors > 0 && determinant > 0 ? static_cast<float>(2 * std::sqrt(3 * determinant / minors)) : 0.0f;
}

}  // namespace meander::spaced
