// Spaced samples of a level: how places are chosen, and in which order.
#include "kernels/sample/spaced_level.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/sample/sequence.h"

namespace meander::spaced {

namespace {

// Where the short kernel ends: so many times the distance that repairs ask for, and at least at this one, in
// spacings.
constexpr float short_factor = 1.1f, min_short_reach = 0.715f * static_cast<float>(hexagonal_distance);
// Strata of at least so many leaves count as equal where some have one more.
constexpr std::uint32_t nearly_equal_leaves = 256;
// Repairs offer up to so many times as many places as the first one.
constexpr std::uint32_t max_repair_factor = 4;
// Their short kernel doubles so often: what repels a sample outweighs everything else in the end.
constexpr unsigned max_doublings = 3;
// Where more than this share of the samples is too near, as in heaps of sheets, there is no room to leave
// for, and less beside samples that were placed before: only those on sheets that lie alone leave.
constexpr double crowded = 1.0 / 3, crowded_beside_held = 1.0 / 8;
// The weight of distances while samples settle around those that have left, over that of repairs.
constexpr float settling = 64;

}  // namespace

SpacedLevel::SpacedLevel(const Strata& strata, const OfferedStrata& offered, int level, double repair_below,
                         const Offer& offer, const CancelToken& cancel)
    : strata_(strata),
      offered_(offered.places),
      spacing_(offered.spacing),
      metric_(offered.metric),
      blocks_(offer.levels.blocks(level)),
      level_(static_cast<std::uint32_t>(level)),
      offer_(offer),
      parameters_(offer.parameters),
      too_near_(static_cast<float>(hexagonal_distance * repair_below)),
      cancel_(cancel),
      equal_(blocks_.leaves % blocks_.count == 0 || blocks_.leaves / blocks_.count >= nearly_equal_leaves),
      reach_(blocks_.count, static_cast<float>(kernel_reach)),
      torn_(blocks_.count),
      near_(blocks_.count, draw_block),
      number_(blocks_.count) {
  sample_.resize(blocks_.count + StratumLists::max_run);
  for (std::uint32_t s = 0; s < blocks_.count; ++s)
    torn_[s] = offered_.extent(s) > torn_extent * in_space(s, spacing_[s]);
}

void SpacedLevel::space_out() {
  std::vector<std::uint32_t> free;
  for (std::uint32_t s = 0; s < blocks_.count; ++s) {
    if (number_[s] == held) continue;
    free.push_back(s);
    const std::uint64_t index = Offer::index_of({level_, s, 0});
    number_[s] = random_words(offer_.key, Stream::stratum_start, index)[0] % parameters_.candidates;
    put(s, offered_.place(s, number_[s]));
  }
  find_neighbors();
  find_moments();
  find_attraction(free);
  for (std::uint32_t sweep = 0; sweep < parameters_.sweeps; ++sweep) {
    // Random places, as those before the first sweep, have nothing to say from afar.
    if (sweep == 1) find_far_field();
    visit_groups(free, sweep, [&](std::uint32_t s, Visit& visit) { return choose(s, visit); });
  }
  std::vector<std::uint32_t> all = free;
  const double few = (free.size() < blocks_.count ? crowded_beside_held : crowded) * double(free.size());
  for (std::uint32_t pass = 0; pass < parameters_.repairs; ++pass) {
    free = to_repair(free, pass);
    const auto move = [&](std::uint32_t s, Visit& visit) {
      // Fewer are left in each pass, and those need more places.
      const std::uint32_t more = std::min(pass + 1, max_repair_factor);
      return choose_new(s, first_number(pass), more * parameters_.repair_candidates,
                        stacked_weight(s) * static_cast<float>(1u << std::min(pass, max_doublings)), visit);
    };
    move_in_pass(free, pass, pass + 1 == parameters_.repairs, move);
  }
  const std::uint32_t rounds = is_early() ? max_leave_rounds : parameters_.leave_rounds;
  for (std::uint32_t round = 0; round < rounds; ++round) {
    all = too_near(all);
    const bool is_crowded = static_cast<double>(all.size()) > few;
    leave_strata(first_of(all, 1.0 / few_leave), is_crowded ? alone_to : max_leave_fullness);
    if (!is_crowded) settle(parameters_.repairs + round, round + 1 == rounds);
  }
  if (blocks_.count == blocks_.leaves && metric_.empty())
    for (std::uint32_t round = 0; round < parameters_.hole_rounds; ++round) fill_holes();
}

void SpacedLevel::find_samples(std::uint32_t stratum, Visit& visit) const {
  const std::size_t count = visit.near.size();
  visit.samples.resize(count);
  float *const x = visit.samples.x.data(), *const y = visit.samples.y.data(),
               *const z = visit.samples.z.data();
  for (std::size_t i = 0; i < count; ++i) {
    const Point sample = sample_at(visit.near[i]);
    x[i] = sample.x;
    y[i] = sample.y;
    z[i] = sample.z;
  }
  to_metric(stratum, visit.samples, count);
}

void SpacedLevel::gather_samples(std::uint32_t stratum, Visit& visit) const {
  const std::size_t count = near_.size(stratum);
  visit.samples.resize(count + StratumLists::max_run);
  near_.gather(stratum, {{sample_.x.data(), visit.samples.x.data()},
                         {sample_.y.data(), visit.samples.y.data()},
                         {sample_.z.data(), visit.samples.z.data()}});
  visit.samples.resize(count);
  to_metric(stratum, visit.samples, count);
}

void SpacedLevel::repel(std::uint32_t stratum, float weight, Visit& visit) const {
  const float within = min_distance(stratum) * std::max(short_factor, min_short_reach / too_near_);
  const KernelScale scale{1 / reach_of(stratum), 1 / within, 1, metric_.empty() ? weight : 0};
  add_kernel(visit.places, visit.samples, 0, visit.samples.size(), scale, visit.energy);
  if (metric_.empty()) return;
  for_each_near(stratum, within, visit, [&](std::size_t place, std::size_t, float distance) {
    const float left = 1 - distance / within;
    visit.energy[place] += weight * left * left;
  });
}

void SpacedLevel::find_far_field() {
  if (!metric_.empty()) return;
  const auto takes_part = [&](std::uint32_t s) {
    return !is_torn(s) && reach_[s] == static_cast<float>(kernel_reach);
  };
  far_ = FarField(moments_, spacing_, takes_part, cancel_);
  for (std::uint32_t s = 0; s < blocks_.count; ++s) {
    const std::array<float, 3>& mean = moments_[s].mean;
    far_.move(s, {mean[0], mean[1], mean[2]}, sample_at(s));
  }
}

void SpacedLevel::repel_from_afar(std::uint32_t stratum, Visit& visit) const {
  if (!far_.reaches(stratum)) return;
  const std::array<float, 3>& mean = moments_[stratum].mean;
  const Point at = sample_at(stratum);
  far_.add(stratum, moments_[stratum], spacing_[stratum], {at.x - mean[0], at.y - mean[1], at.z - mean[2]},
           1 - own_share(stratum), visit.places, visit.dipoles, visit.energy);
}

float SpacedLevel::length_in_metric(std::uint32_t stratum, const Point& v) const {
  float squared = 0;
  for (const auto& row : metric_[stratum].rows) {
    const float along = row[0] * v.x + row[1] * v.y + row[2] * v.z;
    squared += along * along;
  }
  return std::sqrt(squared);
}

SpacedLevel::Choice SpacedLevel::choose(std::uint32_t stratum, Visit& visit) const {
  const std::size_t places = offered_.places();
  visit.places.resize(places);
  offered_.load(stratum, visit.places, 0);
  gather_samples(stratum, visit);
  places_to_metric(stratum, visit);
  visit.energy.resize(places);
  attraction_.read(slot_of(stratum), visit.energy);
  for (float& energy : visit.energy) energy = -energy;
  repel(stratum, sweep_weight(stratum), visit);
  repel_from_afar(stratum, visit);
  std::uint32_t best = number_[stratum];
  for (std::uint32_t k = 0; k < places; ++k)
    if (visit.energy[k] < visit.energy[best]) best = k;
  return {best, offered_.place(stratum, best)};
}

void SpacedLevel::draw_new(std::uint32_t stratum, std::uint32_t first, std::uint32_t count,
                           Visit& visit) const {
  visit.draws.resize(count);
  visit.points.resize(count);
  for (std::uint32_t k = 0; k < count; ++k) visit.draws[k] = offer_.draw({level_, stratum, first + k});
  std::sort(visit.draws.begin(), visit.draws.end(),
            [](const PointDraw& a, const PointDraw& b) { return a.at < b.at; });
  strata_.draw(visit.draws, visit.points);
}

SpacedLevel::Choice SpacedLevel::choose_new(std::uint32_t stratum, std::uint32_t first, std::uint32_t count,
                                            float weight, Visit& visit) const {
  draw_new(stratum, first, count, visit);
  read_near(stratum, visit.near);
  ask_about(sample_at(stratum), visit);
  visit.number.assign(1, number_[stratum]);
  for (std::uint32_t k = 0; k < count; ++k) {
    if (!takes(stratum, point_at(visit.points[k]), visit.torn)) continue;
    visit.places.push_back(visit.points[k].at[0], visit.points[k].at[1], visit.points[k].at[2]);
    visit.number.push_back(k);
  }
  find_samples(stratum, visit);
  attract(stratum, visit);
  const float share = own_share(stratum);
  for (std::size_t k = 0; k < visit.number.size(); ++k)
    visit.energy[k] = share * visit.own[k] - visit.energy[k];
  repel(stratum, weight, visit);
  repel_from_afar(stratum, visit);
  const auto best = static_cast<std::size_t>(std::min_element(visit.energy.begin(), visit.energy.end()) -
                                             visit.energy.begin());
  if (best == 0) return {number_[stratum], sample_at(stratum)};
  const std::uint32_t k = visit.number[best];
  return {visit.draws[k].number, point_at(visit.points[k])};
}

void SpacedLevel::look_at_sample(std::uint32_t stratum, Visit& visit) const {
  read_near(stratum, visit.near);
  ask_about(sample_at(stratum), visit);
  find_samples(stratum, visit);
  places_to_metric(stratum, visit);
}

std::uint32_t SpacedLevel::first_number(std::uint32_t pass) const {
  return parameters_.candidates + pass * max_repair_factor * parameters_.repair_candidates;
}

void SpacedLevel::settle(std::uint32_t pass, bool is_last) {
  std::vector<std::uint32_t> around, near;
  const auto add_around = [&](std::uint32_t stratum) {
    read_near(stratum, near);
    near.push_back(stratum);
    for (const std::uint32_t s : near)
      if (!is_held(s) && !taken_.contains(s)) around.push_back(s);
  };
  for (const auto& [stratum, place] : taken_) {
    add_around(stratum);
    add_around(place.host);
  }
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  move_in_pass(around, pass, is_last, [&](std::uint32_t s, Visit& visit) {
    return choose_new(s, first_number(pass), parameters_.repair_candidates, settling * stacked_weight(s),
                      visit);
  });
}

template <class Choose>
void SpacedLevel::move_in_pass(const std::vector<std::uint32_t>& strata, std::uint32_t pass, bool is_last,
                               const Choose& choose) {
  if (is_last)
    visit_in_turn(strata, choose);
  else
    visit_groups(strata, max_sweeps + pass, choose);
}

template <class Choose>
void SpacedLevel::visit_in_turn(const std::vector<std::uint32_t>& strata, const Choose& choose) {
  Visit visit;
  for (std::size_t i = 0; i < strata.size(); ++i) {
    if (i % check_interval == 0) cancel_.check();
    move(strata[i], choose(strata[i], visit));
  }
}

template <class Choose>
void SpacedLevel::visit_groups(const std::vector<std::uint32_t>& strata, std::uint32_t turn,
                               const Choose& choose) {
  std::array<std::size_t, groups + 1> begin{};
  const std::vector<std::uint32_t> order = grouped(strata, turn, begin);
  std::vector<Choice> choices;
  for (std::size_t g = 0; g < groups; ++g) {
    const std::span<const std::uint32_t> members =
        std::span(order).subspan(begin[g], begin[g + 1] - begin[g]);
    choices.resize(members.size());
    const std::size_t tasks = (members.size() + draw_block - 1) / draw_block;
    parallel_tasks(tasks, [&](std::size_t task) {
      cancel_.check();
      Visit visit;
      const std::size_t end = std::min((task + 1) * draw_block, members.size());
      for (std::size_t i = task * draw_block; i < end; ++i) {
        choices[i] = choose(members[i], visit);
      }
    });
    for (std::size_t i = 0; i < members.size(); ++i) move(members[i], choices[i]);
  }
}

std::vector<std::uint32_t> SpacedLevel::grouped(const std::vector<std::uint32_t>& strata, std::uint32_t turn,
                                                std::array<std::size_t, groups + 1>& begin) const {
  std::vector<std::uint8_t> group(strata.size());
  for (std::size_t i = 0; i < strata.size(); ++i) {
    const std::uint64_t index = Offer::index_of({level_, strata[i], 0});
    group[i] = static_cast<std::uint8_t>(
        random_words(offer_.key, Stream::stratum_start, index, first_turn + turn)[0] % groups);
    ++begin[group[i] + 1u];
  }
  for (std::size_t g = 0; g < groups; ++g) begin[g + 1] += begin[g];
  std::vector<std::uint32_t> order(strata.size());
  std::array<std::size_t, groups + 1> next = begin;
  for (std::size_t i = 0; i < strata.size(); ++i) order[next[group[i]]++] = strata[i];
  return order;
}

}  // namespace meander::spaced
