// Spaced samples of a level: the largest holes between them.
#include "kernels/sample/spaced_level.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <tuple>

#include "kernels/core/parallel.h"
#include "kernels/core/vector3.h"

namespace meander::spaced {

namespace {

// Places farther than this from all samples, in spacings, are holes. In the hexagonal lattice none is farther
// than its distance over sqrt(3).
constexpr float max_hole = 1.42f * static_cast<float>(hexagonal_distance / std::numbers::sqrt3);
// One sample moves into a hole: from within the first number times its distance to within the second; and it
// leaves no place farther from all samples than the third.
constexpr float hole_movers = 2, hole_filled = 0.95f, hole_left = 0.97f;
// Holes are looked for around places at least so far from all samples, in parts of that distance: at centers
// of circles through three of the nearest samples, so many, within so many spacings. In larger ones than that
// a place is no farther away than the last number.
constexpr float probe_share = 0.8f, enlarging_way = 0.35f, beside_surface = 0.25f;
constexpr std::size_t hole_samples = 5;
// Ways to fill a hole that are tried, the offered and the new ones: those that add the least energy.
constexpr std::size_t max_fillings = 12;

}  // namespace

// A place far from all samples.
struct SpacedLevel::Hole {
  float distance = 0;  // of the nearest sample, in spacings
  std::uint32_t stratum = 0;
  Point at;
  bool operator<(const Hole& other) const {
    return distance < other.distance || (distance == other.distance && stratum > other.stratum);
  }
};

void SpacedLevel::fill_holes() {
  std::vector<std::vector<Hole>> of_task((blocks_.count + draw_block - 1) / draw_block);
  parallel_tasks(of_task.size(), [&](std::size_t task) {
    cancel_.check();
    Visit visit;
    std::vector<Hole> probes;
    const auto end = static_cast<std::uint32_t>(
        std::min((task + 1) * draw_block, static_cast<std::size_t>(blocks_.count)));
    for (auto s = static_cast<std::uint32_t>(task * draw_block); s < end; ++s) {
      if (!can_fill(s)) continue;
      find_probes(s, probes, visit);
      Hole largest;
      for (Hole& hole : probes) {
        enlarge(hole, visit);
        largest = std::max(largest, hole);
      }
      if (largest.distance > max_hole) of_task[task].push_back(largest);
    }
  });
  std::priority_queue<Hole> holes;
  for (const std::vector<Hole>& found : of_task)
    for (const Hole& hole : found) holes.push(hole);
  Visit visit;
  for (std::uint32_t filled = 0; !holes.empty() && filled < blocks_.count / few_leave; ++filled) {
    if (filled % check_interval == 0) cancel_.check();
    const Hole largest = holes.top();
    holes.pop();
    const Hole opened = fill(largest, visit);
    if (opened.distance > max_hole) holes.push(opened);
  }
}

void SpacedLevel::find_probes(std::uint32_t stratum, std::vector<Hole>& probes, Visit& visit) const {
  probes.clear();
  read_near(stratum, visit.near);
  visit.near.push_back(stratum);
  find_samples(stratum, visit);
  const auto add_places_of = [&](std::uint32_t of) {
    load_places(of, visit);
    find_hole(stratum, visit);
    for (std::uint32_t k = 0; k < offered_.places(); ++k)
      if (visit.energy[k] > probe_share * max_hole)
        probes.push_back({visit.energy[k], stratum, offered_.place(of, k)});
  };
  add_places_of(stratum);
  for (const std::uint32_t beside : {stratum - 1, stratum + 1})
    if (beside < blocks_.count && is_held(beside) && !is_torn(beside)) add_places_of(beside);
}

SpacedLevel::Hole SpacedLevel::find_hole(std::uint32_t stratum, Visit& visit) const {
  visit.energy.assign(visit.places.size(), INFINITY);
  find_nearest(visit.places, visit.samples, visit.near.size(), visit.energy);
  for (float& squared : visit.energy) squared = std::sqrt(squared) / spacing_[stratum];
  const auto k = static_cast<std::size_t>(std::ranges::max_element(visit.energy) - visit.energy.begin());
  return {visit.energy[k], stratum, {visit.places.x[k], visit.places.y[k], visit.places.z[k]}};
}

void SpacedLevel::enlarge(Hole& hole, Visit& visit) const {
  std::array<std::pair<float, std::size_t>, hole_samples> nearest;
  nearest.fill({INFINITY, 0});
  for (std::size_t i = 0; i < visit.near.size(); ++i) {
    const Point sample{visit.samples.x[i], visit.samples.y[i], visit.samples.z[i]};
    std::pair<float, std::size_t> next{squared_distance(hole.at, sample), i};
    for (auto& at : nearest)
      if (next.first < at.first) std::swap(next, at);
  }
  std::array<Vector3, hole_samples> sample;
  for (std::size_t k = 0; k < hole_samples; ++k) {
    const std::size_t i = nearest[k].second;
    sample[k] = {double(visit.samples.x[i]), double(visit.samples.y[i]), double(visit.samples.z[i])};
  }
  visit.places.resize(0);
  const Vector3 from{double(hole.at.x), double(hole.at.y), double(hole.at.z)};
  for (std::size_t i = 0; i < hole_samples; ++i)
    for (std::size_t j = i + 1; j < hole_samples; ++j)
      for (std::size_t k = j + 1; k < hole_samples; ++k) {
        const Vector3 u = sample[j] - sample[i], v = sample[k] - sample[i], normal = cross(u, v);
        const double square = dot(normal, normal);
        if (!(square > 0)) continue;
        // As high above the samples as the surface is.
        const Vector3 center =
            sample[i] + (0.5 / square) * (dot(v, v) * cross(normal, u) + dot(u, u) * cross(v, normal)) +
            (dot(from - sample[i], normal) / square) * normal;
        const Point at{float(center.x), float(center.y), float(center.z)};
        if (is_near(at, hole.at, enlarging_way * spacing_[hole.stratum]))
          visit.places.push_back(at.x, at.y, at.z);
      }
  if (visit.places.size() == 0) return;
  const Hole next = find_hole(hole.stratum, visit);
  if (next.distance > hole.distance && (next.distance <= max_hole || is_beside_surface(next, visit)))
    hole = next;
}

bool SpacedLevel::is_beside_surface(const Hole& hole, Visit& visit) const {
  for (const std::uint32_t s : visit.near) {
    load_places(s, visit);
    for (std::size_t k = 0; k < visit.places.size(); ++k)
      if (is_near({visit.places.x[k], visit.places.y[k], visit.places.z[k]}, hole.at,
                  beside_surface * spacing_[hole.stratum]))
        return true;
  }
  return false;
}

// A sample that can fill a hole, by what that adds to the energy.
struct SpacedLevel::Filling {
  float energy = 0;
  std::uint32_t stratum = 0;
  Choice choice{};
};

SpacedLevel::Hole SpacedLevel::fill(const Hole& hole, Visit& visit) {
  std::vector<std::uint32_t> beside;
  read_near(hole.stratum, beside);
  beside.push_back(hole.stratum);
  visit.near = beside;
  find_samples(hole.stratum, visit);
  ask_about(hole.at, visit);
  const float distance = find_hole(hole.stratum, visit).distance;
  if (distance <= max_hole) return {};
  const float far = distance * spacing_[hole.stratum];
  std::vector<Filling> fillings;
  std::optional<Filling> best;
  Hole least{hole_left * distance, hole.stratum, {}};
  for (const bool anew : {false, true}) {
    fillings.clear();
    for (const std::uint32_t s : beside)
      if (can_fill(s) && !taken_.contains(s) && is_near(sample_at(s), hole.at, hole_movers * far))
        add_fillings(s, anew, hole.at, hole_filled * far, visit, fillings);
    std::ranges::sort(fillings, {}, [](const Filling& filling) {
      return std::tuple(filling.energy, filling.stratum, filling.choice.number);
    });
    fillings.resize(std::min(fillings.size(), max_fillings));
    for (const Filling& filling : fillings) {
      const Hole opened = opened_by(filling, visit);
      if (opened.distance >= least.distance) continue;
      least = opened;
      best = filling;
      if (opened.distance <= max_hole) break;
    }
    if (best && least.distance <= max_hole) break;
  }
  if (!best) return {};
  move(best->stratum, best->choice);
  return least;
}

void SpacedLevel::add_fillings(std::uint32_t stratum, bool anew, const Point& hole, float distance,
                               Visit& visit, std::vector<Filling>& fillings) const {
  std::vector<Choice> choices;
  read_near(stratum, visit.near);
  ask_about(sample_at(stratum), visit);
  const auto ask = [&](std::uint32_t number, const Point& at) {
    if (!is_near(at, hole, distance)) return;
    visit.places.push_back(at.x, at.y, at.z);
    choices.push_back({number, at});
  };
  if (anew) {
    draw_new(stratum, parameters_.candidates, leave_places, visit);
    for (std::size_t k = 0; k < leave_places; ++k)
      if (takes(stratum, point_at(visit.points[k]), visit.torn))
        ask(visit.draws[k].number, point_at(visit.points[k]));
  } else {
    for (std::uint32_t k = 0; k < offered_.places(); ++k) ask(k, offered_.place(stratum, k));
  }
  if (choices.empty()) return;
  find_samples(stratum, visit);
  attract(stratum, visit);
  const float share = own_share(stratum);
  for (std::size_t k = 0; k < visit.places.size(); ++k)
    visit.energy[k] = share * visit.own[k] - visit.energy[k];
  repel(stratum, 0, visit);
  std::vector<std::uint8_t> too_near(visit.places.size(), 0);
  for_each_near(stratum, min_distance(stratum), visit,
                [&](std::size_t place, std::size_t, float) { too_near[place] = 1; });
  for (std::size_t k = 0; k < choices.size(); ++k)
    if (!too_near[k + 1]) fillings.push_back({visit.energy[k + 1] - visit.energy[0], stratum, choices[k]});
}

SpacedLevel::Hole SpacedLevel::opened_by(const Filling& filling, Visit& visit) {
  const std::uint32_t s = filling.stratum;
  const Choice before{number_[s], sample_at(s)};
  move(s, filling.choice);
  std::vector<std::uint32_t> beside;
  read_near(s, beside);
  beside.push_back(s);
  const PointBox left = {{before.at.x, before.at.y, before.at.z}, {before.at.x, before.at.y, before.at.z}};
  Hole largest;
  std::vector<Hole> probes;
  for (const std::uint32_t other : beside) {
    if (is_held(other) || !may_touch(other, left, hole_movers * max_hole * spacing_[other], visit.torn))
      continue;
    const auto is_new = [&](const Hole& hole) {
      return is_near(hole.at, before.at, hole.distance * spacing_[other]);
    };
    find_probes(other, probes, visit);
    for (Hole& hole : probes) {
      if (!is_new(hole)) continue;
      enlarge(hole, visit);
      if (is_new(hole) && largest < hole) largest = hole;
    }
  }
  move(s, before);
  return largest;
}

}  // namespace meander::spaced
