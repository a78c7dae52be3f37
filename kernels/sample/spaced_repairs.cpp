// Spaced samples of a level: those that are too near to another one.
#include "kernels/sample/spaced_level.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "kernels/core/parallel.h"

namespace meander::spaced {

namespace {

// After so many passes the samples around those that are too near are moved too, within this times that
// distance, where no more than one in so many is left.
constexpr std::uint32_t passes_alone = 4;
constexpr float make_room = 1.6f;
constexpr std::uint32_t few_left = 64;
// So many strata for each that looks for a place at the same time as others, so that few see another one
// leave; and how many do so at most.
constexpr std::uint32_t strata_per_leaving = 8192;
constexpr std::size_t max_batch = 1024;

}  // namespace

std::vector<std::uint32_t> SpacedLevel::too_near(const std::vector<std::uint32_t>& strata) const {
  std::vector<float> distance(strata.size());
  parallel_blocks(strata.size(), draw_block, [&](std::size_t begin, std::size_t end) {
    cancel_.check();
    Visit visit;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t s = strata[i];
      look_at_sample(s, visit);
      const float least = min_distance(s);
      distance[i] = 1;
      for_each_near(s, least, visit, [&](std::size_t, std::size_t, float nearer) {
        distance[i] = std::min(distance[i], nearer / least);
      });
    }
  });
  std::vector<std::pair<float, std::uint32_t>> near;
  for (std::size_t i = 0; i < strata.size(); ++i)
    if (distance[i] < 1 - 1e-6f) near.push_back({distance[i], strata[i]});
  std::sort(near.begin(), near.end());
  std::vector<std::uint32_t> result;
  for (const auto& [nearest, stratum] : near) result.push_back(stratum);
  return result;
}

std::vector<std::uint32_t> SpacedLevel::first_of(std::vector<std::uint32_t> strata, double share) const {
  const auto most = static_cast<std::size_t>(std::ceil(share * blocks_.count));
  strata.resize(std::min(strata.size(), most));
  return strata;
}

std::vector<std::uint32_t> SpacedLevel::to_repair(const std::vector<std::uint32_t>& strata,
                                                  std::uint32_t pass) const {
  std::vector<std::uint32_t> result =
      first_of(too_near(strata), parameters_.repair_share / ((pass + 1.0) * (pass + 1.0)));
  if (result.size() <= blocks_.count / few_left) add_partners(pass < passes_alone ? 1 : make_room, result);
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

void SpacedLevel::add_partners(float within, std::vector<std::uint32_t>& strata) const {
  std::vector<std::vector<std::uint32_t>> partners((strata.size() + check_interval - 1) / check_interval);
  parallel_tasks(partners.size(), [&](std::size_t task) {
    cancel_.check();
    Visit visit;
    const std::size_t end = std::min((task + 1) * check_interval, strata.size());
    for (std::size_t i = task * check_interval; i < end; ++i) {
      look_at_sample(strata[i], visit);
      for_each_near(strata[i], within * min_distance(strata[i]), visit,
                    [&](std::size_t, std::size_t sample, float) {
                      if (!is_held(visit.near[sample])) partners[task].push_back(visit.near[sample]);
                    });
    }
  });
  for (const std::vector<std::uint32_t>& of_task : partners)
    strata.insert(strata.end(), of_task.begin(), of_task.end());
}

void SpacedLevel::leave_strata(const std::vector<std::uint32_t>& strata, float max_fullness) {
  const std::size_t batch = std::clamp<std::size_t>(blocks_.count / strata_per_leaving, 1, max_batch);
  std::vector<std::optional<Leaving>> found(batch);
  std::vector<std::uint32_t> changed;  // whose sample has moved, and where it was and has come
  Visit visit;
  for (std::size_t first = 0; first < strata.size(); first += batch) {
    cancel_.check();
    const auto members = std::span(strata).subspan(first, std::min(batch, strata.size() - first));
    const auto look = [&](std::size_t i, Visit& of_task) {
      found[i].reset();
      if (fullness_[slot_of(members[i])] <= max_fullness) found[i] = find_place(members[i], of_task);
    };
    if (members.size() > 1)
      parallel_tasks((members.size() + check_interval - 1) / check_interval, [&](std::size_t task) {
        Visit of_task;
        const std::size_t end = std::min((task + 1) * check_interval, members.size());
        for (std::size_t i = task * check_interval; i < end; ++i) look(i, of_task);
      });
    changed.clear();
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (members.size() == 1 || sees_any(members[i], changed, visit)) look(i, visit);
      if (!found[i]) continue;
      const std::uint32_t before = host_of(members[i]);
      leave(members[i], *found[i]);
      changed.insert(changed.end(), {members[i], before, found[i]->place.host});
    }
  }
}

std::optional<SpacedLevel::Leaving> SpacedLevel::find_place(std::uint32_t stratum, Visit& visit) const {
  std::optional<Leaving> result;
  read_near(stratum, visit.near);
  Point at = sample_at(stratum);
  for (const bool anew : {false, true}) {
    offer_around(stratum, at, anew, visit);
    find_samples(stratum, visit);
    places_to_metric(stratum, visit);
    find_room(stratum, visit);
    const std::size_t best = roomiest(visit);
    if (best > 0) {
      const TakenPlace place{visit.host[best], visit.number[best]};
      const PointDraw draw = offer_.draw({level_, place.host, place.number});
      StratumPoint point;
      strata_.draw(std::span(&draw, 1), std::span(&point, 1));
      at = point_at(point);
      result = {place, at};
    }
    if (visit.energy[best] >= 1) break;
  }
  return result;
}

bool SpacedLevel::sees_any(std::uint32_t stratum, const std::vector<std::uint32_t>& others,
                           Visit& visit) const {
  if (others.empty()) return false;
  near_.read(stratum, visit.near);
  return std::ranges::any_of(others, [&](std::uint32_t other) {
    return other == stratum || std::ranges::binary_search(visit.near, other);
  });
}

void SpacedLevel::offer_around(std::uint32_t stratum, const Point& sample, bool anew, Visit& visit) const {
  const float distance = in_space(stratum, std::min(leave_within, reach_[stratum] - 1) * spacing_[stratum]);
  ask_about(sample, visit);
  visit.number.assign(1, number_[stratum]);
  visit.host.assign(1, stratum);
  if (distance <= 0) return;
  const auto offer = [&](std::uint32_t host, std::uint32_t number, const Point& at) {
    if (!may_touch(stratum, {{at.x, at.y, at.z}, {at.x, at.y, at.z}}, distance, visit.torn)) return;
    visit.places.push_back(at.x, at.y, at.z);
    visit.number.push_back(number);
    visit.host.push_back(host);
  };
  for (const std::uint32_t other : visit.near) {
    if (!may_host(other, stratum)) continue;
    if (anew) {
      draw_new(other, parameters_.candidates, leave_places, visit);
      for (std::size_t k = 0; k < leave_places; ++k)
        offer(other, visit.draws[k].number, point_at(visit.points[k]));
    } else {
      for (std::uint32_t k = 0; k < offered_.places(); ++k) offer(other, k, offered_.place(other, k));
    }
  }
}

bool SpacedLevel::may_host(std::uint32_t host, std::uint32_t stratum) const {
  return !is_held(host) && own_share(host) == 0 && spacing_[host] <= leave_factor * spacing_[stratum] &&
         spacing_[stratum] <= leave_factor * spacing_[host];
}

void SpacedLevel::add_hosted(std::uint32_t stratum, std::vector<std::uint32_t>& near) const {
  if (is_host_.empty()) return;
  const std::size_t count = near.size();
  const auto add = [&](std::uint32_t host) {
    if (is_host_[host] == 0) return;
    const auto [first, last] = hosted_.equal_range(host);
    for (auto at = first; at != last; ++at)
      if (at->second != stratum && !std::ranges::binary_search(std::span(near).first(count), at->second))
        near.push_back(at->second);
  };
  add(stratum);
  for (std::size_t i = 0; i < count; ++i) add(near[i]);
}

std::uint32_t SpacedLevel::host_of(std::uint32_t stratum) const {
  const auto at = taken_.find(stratum);
  return at == taken_.end() ? stratum : at->second.host;
}

void SpacedLevel::leave(std::uint32_t stratum, const Leaving& leaving) {
  if (const auto before = taken_.find(stratum); before != taken_.end()) {
    auto at = hosted_.equal_range(before->second.host).first;
    while (at->second != stratum) ++at;
    hosted_.erase(at);
  }
  is_host_.resize(blocks_.count);
  is_host_[leaving.place.host] = 1;
  hosted_.insert({leaving.place.host, stratum});
  taken_[stratum] = leaving.place;
  put(stratum, leaving.at);
}

void SpacedLevel::find_room(std::uint32_t stratum, Visit& visit) const {
  const float least = min_distance(stratum);
  visit.energy.assign(visit.places.size(), metric_.empty() ? least * least : 1.0f);
  if (metric_.empty()) {
    find_nearest(visit.places, visit.samples, visit.samples.size(), visit.energy);
    for (float& room : visit.energy) room = std::sqrt(room) / least;
    return;
  }
  for_each_near(stratum, least, visit, [&](std::size_t place, std::size_t, float nearer) {
    visit.energy[place] = std::min(visit.energy[place], nearer / least);
  });
}

std::size_t SpacedLevel::roomiest(const Visit& visit) {
  const std::vector<float>& room = visit.energy;
  std::size_t best = 0;
  float distance = 0;
  for (std::size_t k = 1; k < room.size(); ++k) {
    const float x = visit.places.x[k] - visit.places.x[0], y = visit.places.y[k] - visit.places.y[0],
                z = visit.places.z[k] - visit.places.z[0], squared = x * x + y * y + z * z;
    if (room[k] < room[best] || (room[k] == room[best] && squared >= distance)) continue;
    best = k;
    distance = squared;
  }
  return best;
}

}  // namespace meander::spaced
