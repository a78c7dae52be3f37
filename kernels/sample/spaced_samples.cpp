#include "kernels/sample/spaced_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "kernels/core/check_range.h"
#include "kernels/core/parallel.h"
#include "kernels/sample/offered_places.h"
#include "kernels/sample/room.h"
#include "kernels/sample/sequence.h"
#include "kernels/sample/stratum_grid.h"

namespace meander {

using namespace spaced;

namespace {

// Spacing of the hexagonal lattice, in sqrt(area of a stratum): sqrt(2 / sqrt(3)).
constexpr double hexagonal_spacing = 1.0745699318235418;
// A place at a border has fewer samples around it than the mass there would let one expect, and would win too
// often by this share of the room of a disc in the plane (measured: docs/METHODS.md 7.5).
constexpr float border_share = 0.015f;
// Among samples that are fixed less room is enough, in parts of what is else: there is no more to be had.
constexpr double held_room = 0.7;
// Strata of at least so many leaves count as equal where some have one more.
constexpr std::uint32_t nearly_equal_leaves = 256;
// Cells are at least so large, in mean reaches.
constexpr double least_cell = 1.0 / 1024;
// Strata larger than this, in reaches, are torn.
constexpr float torn_extent = 2;
// How far from their strata's first places samples are put: in reaches, and in extents of the stratum.
constexpr float torn_margin = 0.5f, box_margin = 0.125f;
// Strata that are looked at around one: about 14 on a smooth surface, more where sheets are stacked.
constexpr std::size_t most_neighbors = 192;
// The first level of a progressive set has 2^6 samples.
constexpr int first_level = 6;
// The last two levels are one where the last has fewer strata than this times those of the one before.
constexpr double most_as_one = 1.3;
// Strata that are visited one after the other. Sets of more than two blocks are swept block by block.
constexpr std::uint32_t sweep_block = 4096;
constexpr std::size_t check_block = 64, check_interval = 16;

// The samples of one level.
class SpacedLevel {
 public:
  SpacedLevel(const Strata& strata, const OfferedStrata& offered, int level, const Offer& offer,
              const CancelToken& cancel)
      : strata_(strata),
        offered_(offered.places),
        reach_(offered.reach),
        metric_(offered.metric),
        blocks_(offer.levels.blocks(level)),
        level_(static_cast<std::uint32_t>(level)),
        offer_(offer),
        parameters_(offer.parameters),
        cancel_(cancel),
        equal_(blocks_.leaves % blocks_.count == 0 || blocks_.leaves / blocks_.count >= nearly_equal_leaves),
        torn_(blocks_.count),
        margin_(blocks_.count),
        near_begin_(blocks_.count),
        near_((blocks_.count + draw_block - 1) / draw_block),
        sample_(blocks_.count),
        number_(blocks_.count) {
    for (std::uint32_t s = 0; s < blocks_.count; ++s) {
      const float extent = offered_.extent(s), around = in_space(s, reach_[s]);
      torn_[s] = extent > torn_extent * around;
      margin_[s] = torn_[s] ? torn_margin * around : box_margin * extent;
    }
  }

  // Fixes the sample of a stratum.
  void hold(std::uint32_t stratum, const Point& at) {
    sample_[stratum] = at;
    number_[stratum] = held;
    any_held_ = true;
  }

  // Puts a sample into every stratum that has none, and spaces these out.
  void space_out() {
    std::vector<std::uint32_t> free;
    for (std::uint32_t s = 0; s < blocks_.count; ++s) {
      if (number_[s] == held) continue;
      free.push_back(s);
      const std::uint64_t index = Offer::index_of({level_, s, 0});
      number_[s] = random_words(offer_.key, Stream::stratum_start, index)[0] % parameters_.candidates;
      sample_[s] = offered_.place(s, number_[s]);
    }
    find_neighbors();
    for (std::uint32_t sweep = 0; sweep < parameters_.sweeps; ++sweep)
      visit_all(free, [&](std::uint32_t s, Visit& visit) { choose(s, visit); });
    std::vector<std::uint32_t> crowded = free;
    for (std::uint32_t repair = 0; repair < parameters_.repairs; ++repair) {
      crowded = crowded_of(crowded);
      const auto make_room = [&](std::uint32_t s, Visit& visit) { choose_new(s, repair, Goal::room, visit); };
      // The last pass goes in one turn, so that no two of its samples miss each other.
      if (repair + 1 < parameters_.repairs)
        visit_all(crowded, make_room);
      else
        visit_run(crowded, {}, 0, blocks_.count, make_room);
    }
    for (std::uint32_t pass = 0; pass < parameters_.separations; ++pass) {
      free = nearest_of(std::move(free));
      visit_run(free, {}, 0, blocks_.count, [&](std::uint32_t s, Visit& visit) {
        choose_new(s, parameters_.repairs + pass, Goal::distance, visit);
      });
    }
  }

  bool is_held(std::uint32_t stratum) const { return number_[stratum] == held; }
  PlaceName name(std::uint32_t stratum) const { return {level_, stratum, number_[stratum]}; }

 private:
  static constexpr std::uint32_t held = 0xFFFFFFFFu;
  enum class Goal : std::uint8_t { room, distance };

  // What visiting strata needs.
  struct Visit {
    std::span<const Point> before;          // if not empty, samples as they are to be seen
    std::uint32_t own_begin, own_end;       // outside these strata
    PointRows places, samples, background;  // what is asked about; and what there is around it
    PointRows torn;
    PointBox box;                       // around `places`, in space
    std::vector<std::uint32_t> weight;  // of the background
    std::vector<float> squared;         // distance of each place to the nearest sample,
    std::vector<std::uint32_t> room;    // and the mass that is nearer
    std::vector<PointDraw> draws;       // of new places,
    std::vector<StratumPoint> points;
    std::vector<std::uint32_t> number;  // and of `places`
  };

  // Lists the strata around each one whose sample is to be chosen.
  void find_neighbors() {
    // Cells begin at the least reach, unless the density differs by more than any stratum needs to see.
    const float least = *std::min_element(reach_.begin(), reach_.end());
    StratumGrid grid(std::max(static_cast<double>(least), least_cell * mean_reach()));
    for (std::uint32_t s = 0; s < blocks_.count; ++s) {
      if (s % sum_block == 0) cancel_.check();
      PointBox box = grown(offered_.box(s), margin_[s]);
      if (is_held(s)) enclose(box, sample_[s]);
      grid.add(box, in_space(s, reach_[s]));
    }
    grid.build();
    parallel_blocks(blocks_.count, draw_block, [&](std::size_t begin, std::size_t end) {
      cancel_.check();
      StratumGrid::Scratch scratch;
      PointRows places, scratch_places;
      places.resize(offered_.places());
      scratch_places.resize(offered_.places());
      std::vector<std::uint32_t> found, all;
      for (std::size_t s = begin; s < end; ++s) {
        const auto stratum = static_cast<std::uint32_t>(s);
        if (s % check_interval == 0) cancel_.check();
        near_begin_[s] = static_cast<std::uint32_t>(all.size());
        if (is_held(stratum)) continue;
        // The sample stays within the margin of the box, or of a place where the stratum is torn.
        const float around = in_space(stratum, reach_[stratum]) + margin_[stratum];
        const auto is_near = [&](std::uint32_t other, const PointBox& box) {
          return other != stratum && (may_touch(other, box, around + margin_[other], scratch_places) ||
                                      (is_held(other) && contains(grown(box, around), sample_[other])));
        };
        offered_.load(stratum, places, 0);
        grid.find(places.x, places.y, places.z, offered_.box(stratum), torn_[stratum] != 0, around,
                  most_neighbors, is_near, scratch, found);
        all.push_back(stratum);  // always, however many others there are
        all.insert(all.end(), found.begin(), found.end());
      }
      all.shrink_to_fit();
      near_[begin / draw_block] = std::move(all);
    });
  }

  double mean_reach() const {
    double sum = 0;
    for (const float r : reach_) sum += r;
    return sum / static_cast<double>(reach_.size());
  }

  // Whether a stratum has places within `distance` of a box.
  bool may_touch(std::uint32_t stratum, const PointBox& box, float distance, PointRows& places) const {
    const PointBox around = grown(box, distance);
    if (!overlap(offered_.box(stratum), around)) return false;
    if (!torn_[stratum]) return true;
    places.resize(offered_.places());
    offered_.load(stratum, places, 0);
    for (std::size_t i = 0; i < places.size(); ++i)
      if (contains(around, {places.x[i], places.y[i], places.z[i]})) return true;
    return false;
  }
  // Whether a new place is so near the offered ones, which decide what is known of its surroundings.
  bool takes(std::uint32_t stratum, const Point& at, PointRows& places) const {
    const PointBox point = {{at.x, at.y, at.z}, {at.x, at.y, at.z}};
    return may_touch(stratum, point, margin_[stratum], places);
  }

  std::span<const std::uint32_t> neighbors(std::uint32_t stratum) const {
    const std::span<const std::uint32_t> of_block = near_[stratum / draw_block];
    const std::size_t begin = near_begin_[stratum];
    const bool last = stratum + 1 == blocks_.count || (stratum + 1) % draw_block == 0;
    return of_block.subspan(begin, (last ? of_block.size() : near_begin_[stratum + 1]) - begin);
  }

  // The farthest that anything within the reach of a stratum, or within `distance` in its metric, is in
  // space.
  float in_space(std::uint32_t stratum, float distance) const {
    return metric_.empty() ? distance : distance * metric_[stratum].stretch;
  }

  // The distances of visit.places of a stratum to the nearest sample of another one, at most the reach. The
  // places are put in its metric.
  void measure_distances(std::uint32_t stratum, Visit& visit) const {
    visit.box = box_of(visit.places);
    visit.samples.resize(0);
    for (const std::uint32_t other : neighbors(stratum)) {
      if (other == stratum) continue;
      const bool own = visit.before.empty() || (other >= visit.own_begin && other < visit.own_end);
      const Point& sample = own ? sample_[other] : visit.before[other];
      visit.samples.push_back(sample.x, sample.y, sample.z);
    }
    to_metric(stratum, visit.samples, visit.samples.size());
    to_metric(stratum, visit.places, visit.places.size());
    visit.squared.assign(visit.places.size(), reach_[stratum] * reach_[stratum]);
    lower_to_nearest(visit.places, visit.samples, visit.squared);
  }

  // And the mass of surface that is nearer to them, in points of the background, which is all places of all
  // strata; where strata differ in size, times their leaves.
  void measure_room(std::uint32_t stratum, Visit& visit) const {
    measure_distances(stratum, visit);
    const std::size_t places = offered_.places();
    const float farthest = std::sqrt(*std::max_element(visit.squared.begin(), visit.squared.end()));
    const PointBox box = grown(visit.box, in_space(stratum, farthest));
    visit.weight.clear();
    for (const std::uint32_t other : neighbors(stratum)) {
      if (!overlap(offered_.box(other), box)) continue;
      const std::size_t first = visit.weight.size();
      visit.weight.resize(first + places, weight_of(other));
      if (visit.background.size() < first + places) visit.background.resize(first + places);
      offered_.load(other, visit.background, first);
    }
    to_metric(stratum, visit.background, visit.weight.size());
    visit.room.resize(visit.places.size());
    mass_within(visit.places, visit.background, visit.weight, visit.squared, visit.room);
  }

  std::uint32_t weight_of(std::uint32_t stratum) const { return equal_ ? 1 : blocks_.size(stratum); }

  void to_metric(std::uint32_t stratum, PointRows& points, std::size_t count) const {
    if (metric_.empty()) return;
    const auto& rows = metric_[stratum].rows;
    for (std::size_t i = 0; i < count; ++i) {
      const float x = points.x[i], y = points.y[i], z = points.z[i];
      points.x[i] = rows[0][0] * x + rows[0][1] * y + rows[0][2] * z;
      points.y[i] = rows[1][0] * x + rows[1][1] * y + rows[1][2] * z;
      points.z[i] = rows[2][0] * x + rows[2][1] * y + rows[2][2] * z;
    }
  }

  // The room at a place without the place itself, if that is of the background; less a little of what the
  // same radius has in the plane.
  float room_at(std::size_t place, std::uint32_t stratum, bool is_background, const Visit& visit) const {
    const float squared = visit.squared[place];
    const std::int64_t itself = is_background && squared > 0 ? weight_of(stratum) : 0;
    const float discs =
        static_cast<float>(std::numbers::pi * reach * reach) * squared / (reach_[stratum] * reach_[stratum]);
    const float flat = discs * static_cast<float>(parameters_.candidates * weight_of(stratum));
    return static_cast<float>(static_cast<std::int64_t>(visit.room[place]) - itself) - border_share * flat;
  }

  bool is_offered(std::uint32_t stratum) const { return number_[stratum] < offered_.places(); }

  // Moves the sample to the best place of its stratum.
  void choose(std::uint32_t stratum, Visit& visit) {
    visit.places.resize(offered_.places());
    offered_.load(stratum, visit.places, 0);
    measure_room(stratum, visit);
    // With no other sample within reach of any place, what lies within reach of one says nothing of its room.
    const float limit = reach_[stratum] * reach_[stratum];
    if (std::none_of(visit.squared.begin(), visit.squared.end(), [&](float d) { return d < limit; })) return;
    // Among places that are equally good, the sample stays.
    float best = -INFINITY;
    const auto places = static_cast<std::uint32_t>(offered_.places());
    const std::uint32_t first = number_[stratum];
    for (std::uint32_t i = 0; i < places; ++i) {
      const std::uint32_t k = (first + i) % places;
      const float room = room_at(k, stratum, true, visit);
      if (room <= best) continue;
      best = room;
      number_[stratum] = k;
    }
    sample_[stratum] = offered_.place(stratum, number_[stratum]);
  }

  // The same where places are new; the sample may stay.
  void choose_new(std::uint32_t stratum, std::uint32_t pass, Goal goal, Visit& visit) {
    const std::uint32_t count = parameters_.repair_candidates;
    const std::uint32_t first = parameters_.candidates + pass * count;
    visit.draws.resize(count);
    visit.points.resize(count);
    for (std::uint32_t k = 0; k < count; ++k) visit.draws[k] = offer_.draw({level_, stratum, first + k});
    strata_.draw(visit.draws, visit.points);
    ask_about_sample(stratum, visit);
    visit.number.assign(1, number_[stratum]);
    for (std::uint32_t k = 0; k < count; ++k) {
      if (!takes(stratum, point_at(visit.points[k]), visit.torn)) continue;
      visit.places.push_back(visit.points[k].at[0], visit.points[k].at[1], visit.points[k].at[2]);
      visit.number.push_back(first + k);
    }
    if (goal == Goal::room)
      measure_room(stratum, visit);
    else
      measure_distances(stratum, visit);
    const auto value = [&](std::size_t place) {
      return goal == Goal::room ? room_at(place, stratum, place == 0 && is_offered(stratum), visit)
                                : visit.squared[place];
    };
    std::size_t best = 0;
    for (std::size_t place = 1; place < visit.number.size(); ++place)
      if (value(place) > value(best)) best = place;
    if (best == 0) return;
    number_[stratum] = visit.number[best];
    sample_[stratum] = point_at(visit.points[number_[stratum] - first]);
  }

  void ask_about_sample(std::uint32_t stratum, Visit& visit) const {
    visit.places.resize(0);
    visit.places.push_back(sample_[stratum].x, sample_[stratum].y, sample_[stratum].z);
  }

  // value(stratum, visit) of every stratum, when its sample is asked about.
  template <class Value>
  std::vector<float> values_of(const std::vector<std::uint32_t>& strata, const Value& value) const {
    std::vector<float> values(strata.size());
    parallel_blocks(strata.size(), draw_block, [&](std::size_t begin, std::size_t end) {
      cancel_.check();
      Visit visit;
      for (std::size_t i = begin; i < end; ++i) {
        ask_about_sample(strata[i], visit);
        values[i] = value(strata[i], visit);
      }
    });
    return values;
  }

  // Those whose sample has less room than a disc of repair_below of the hexagonal spacing.
  std::vector<std::uint32_t> crowded_of(const std::vector<std::uint32_t>& strata) const {
    const double shares = parameters_.repair_below * parameters_.repair_below * std::numbers::pi *
                          hexagonal_spacing * hexagonal_spacing;
    const double leaves = equal_ ? 1.0 : double(blocks_.leaves) / blocks_.count;
    const double among_held = any_held_ ? held_room : 1.0;
    const auto least = static_cast<float>(among_held * shares * parameters_.candidates * leaves);
    const std::vector<float> room = values_of(strata, [&](std::uint32_t s, Visit& visit) {
      measure_room(s, visit);
      return room_at(0, s, is_offered(s), visit);
    });
    std::vector<std::uint32_t> crowded;
    for (std::size_t i = 0; i < strata.size(); ++i)
      if (room[i] < least) crowded.push_back(strata[i]);
    return crowded;
  }

  // Those whose sample is nearer to another one than separate_below; no more than separate_share of all, the
  // nearest ones, so that where samples cannot be so far apart not all are moved by distance.
  std::vector<std::uint32_t> nearest_of(const std::vector<std::uint32_t>& strata) const {
    const std::vector<float> distance = values_of(strata, [&](std::uint32_t s, Visit& visit) {
      measure_distances(s, visit);
      return std::sqrt(visit.squared[0]) / reach_[s] * static_cast<float>(reach / hexagonal_spacing);
    });
    std::vector<std::pair<float, std::uint32_t>> near;
    for (std::size_t i = 0; i < strata.size(); ++i)
      if (distance[i] < parameters_.separate_below) near.push_back({distance[i], strata[i]});
    const auto most = static_cast<std::size_t>(parameters_.separate_share * blocks_.count);
    if (near.size() > most) {
      std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(most), near.end());
      near.resize(most);
    }
    std::vector<std::uint32_t> result;
    for (const auto& [d, stratum] : near) result.push_back(stratum);
    std::sort(result.begin(), result.end());
    return result;
  }

  // Calls change(stratum, visit) for strata in turn; it sees the samples of strata from own_begin to own_end
  // as they are, others as they were `before`, if that is not empty.
  template <class Change>
  void visit_run(std::span<const std::uint32_t> strata, std::span<const Point> before,
                 std::uint32_t own_begin, std::uint32_t own_end, const Change& change) {
    Visit visit;
    visit.before = before;
    visit.own_begin = own_begin;
    visit.own_end = own_end;
    for (std::size_t i = 0; i < strata.size(); ++i) {
      if (i % check_block == 0) cancel_.check();
      change(strata[i], visit);
    }
  }

  // The same for all `strata`, ascending; large sets in blocks, every other one in the same turn.
  template <class Change>
  void visit_all(const std::vector<std::uint32_t>& strata, const Change& change) {
    if (blocks_.count <= 2 * sweep_block) {
      visit_run(strata, {}, 0, blocks_.count, change);
      return;
    }
    const std::uint32_t runs = (blocks_.count + sweep_block - 1) / sweep_block;
    for (const std::uint32_t turn : {0u, 1u}) {
      const std::vector<Point> before = sample_;
      parallel_tasks((runs + 1 - turn) / 2, [&](std::size_t task) {
        const std::uint32_t begin = (2 * static_cast<std::uint32_t>(task) + turn) * sweep_block;
        const std::uint32_t end = std::min(begin + sweep_block, blocks_.count);
        const auto first = std::lower_bound(strata.begin(), strata.end(), begin);
        const auto last = std::lower_bound(first, strata.end(), end);
        visit_run(std::span(first, last), before, begin, end, change);
      });
    }
  }

  const Strata& strata_;
  const OfferedPlaces& offered_;
  const std::vector<float>& reach_;
  const std::vector<LocalMetric>& metric_;
  LeafBlocks blocks_;
  std::uint32_t level_;
  const Offer& offer_;
  const SpacingParameters& parameters_;
  const CancelToken& cancel_;
  bool equal_;                      // all strata have as many leaves, or nearly
  bool any_held_ = false;           // some samples were fixed
  std::vector<std::uint8_t> torn_;  // the places are far apart: the path jumps between pieces of the surface
  std::vector<float> margin_;       // how far from the box of its places, or from one of these, the sample is
  std::vector<std::uint32_t> near_begin_;         // in the list of their block,
  std::vector<std::vector<std::uint32_t>> near_;  // one for every draw_block strata
  std::vector<Point> sample_;
  std::vector<std::uint32_t> number_;  // of the place of the sample, or held
};

class SpacedSet {
 public:
  SpacedSet(const Strata& strata, RandomKey key, const SpacingParameters& parameters,
            const CancelToken& cancel)
      : strata_(strata),
        cancel_(cancel),
        offer_{key, parameters, Levels(strata.count())},
        leaves_(offer_leaves(strata, offer_, cancel)),
        placed_(strata.count()) {
    samples_.point.resize(strata.count());
  }

  void place_along_path() {
    std::vector<std::uint32_t> all(strata_.count());
    std::iota(all.begin(), all.end(), 0u);
    place_level(offer_.levels.last, all);
  }

  // The order is that of progressive_order, but that the halves that get new samples are those without one.
  void place_progressively() {
    const int last = offer_.levels.last;
    const std::uint32_t mask = progressive_mask(strata_.count(), offer_.key);
    int level = std::min(first_level, last);
    place_level(level, masked_order(offer_.levels.blocks(level).count, mask));
    while (level < last) {
      ++level;
      if (level < last - 1 || (level < last && !last_two_as_one())) {
        place_level(level, free_children(level, mask));
        continue;
      }
      std::vector<std::uint32_t> order;
      if (level < last) {
        const LeafBlocks blocks = offer_.levels.blocks(level);
        for (const std::uint32_t block : free_children(level, mask))
          order.push_back(blocks.begin(block) + (mask >> 31) % blocks.size(block));
        level = last;
      }
      add_free_leaves(mask, order);
      place_level(level, order);
    }
  }

  SpacedSamples take() { return std::move(samples_); }

 private:
  // Where only few strata of the level before the last have two leaves, a second sample would find no room
  // between the others, which know nothing of it: the samples of both levels are placed together.
  bool last_two_as_one() const {
    const double before = offer_.levels.blocks(offer_.levels.last - 1).count;
    return offer_.levels.last > first_level + 1 && strata_.count() < most_as_one * before;
  }

  // Places the samples of one level into its strata without one; `order`: these strata, in the order of the
  // samples in the file.
  void place_level(int level, const std::vector<std::uint32_t>& order) {
    const LeafBlocks blocks = offer_.levels.blocks(level);
    const bool is_last = level == offer_.levels.last;
    const OfferedStrata coarser =
        is_last ? OfferedStrata(0, 0, true) : offer_blocks(leaves_, level, offer_, cancel_);
    SpacedLevel samples(strata_, is_last ? leaves_ : coarser, level, offer_, cancel_);
    for (std::uint32_t leaf = 0; leaf < placed_.size(); ++leaf)
      if (placed_[leaf]) samples.hold(blocks.block_of(leaf), point_at(samples_.point[leaf]));
    samples.space_out();
    // The points themselves, not packed places: samples of later levels keep their distance from these.
    const std::size_t before = samples_.rank_of_index.size();
    samples_.rank_of_index.resize(before + order.size());
    parallel_blocks(order.size(), draw_block, [&](std::size_t begin, std::size_t end) {
      cancel_.check();
      for (std::size_t i = begin; i < end; ++i) {
        const PointDraw draw = offer_.draw(samples.name(order[i]));
        const auto leaf = static_cast<std::uint32_t>(draw.at);
        strata_.draw(std::span(&draw, 1), std::span(&samples_.point[leaf], 1));
        placed_[leaf] = 1;
        samples_.rank_of_index[before + i] = leaf;
      }
    });
  }

  // The blocks of a level that hold no sample, in the order in which their parents are divided.
  std::vector<std::uint32_t> free_children(int level, std::uint32_t mask) const {
    const LeafBlocks blocks = offer_.levels.blocks(level);
    std::vector<std::uint8_t> taken(blocks.count, 0);
    for (std::uint32_t leaf = 0; leaf < placed_.size(); ++leaf)
      if (placed_[leaf]) taken[blocks.block_of(leaf)] = 1;
    std::vector<std::uint32_t> free;
    for (const std::uint32_t parent : parent_order(level - 1, mask))
      free.push_back(2 * parent + (taken[2 * std::size_t{parent}] ? 1 : 0));
    return free;
  }

  // Adds the leaves without a sample that are not there yet, in the order of progressive_order.
  void add_free_leaves(std::uint32_t mask, std::vector<std::uint32_t>& order) const {
    std::vector<std::uint8_t> taken = placed_;
    for (const std::uint32_t leaf : order) taken[leaf] = 1;
    std::vector<std::uint32_t> rest;
    for (std::uint32_t leaf = 0; leaf < taken.size(); ++leaf)
      if (!taken[leaf]) rest.push_back(leaf);
    for (const std::uint32_t i : masked_order(static_cast<std::uint32_t>(rest.size()), mask))
      order.push_back(rest[i]);
  }

  const Strata& strata_;
  const CancelToken& cancel_;
  Offer offer_;
  OfferedStrata leaves_;
  std::vector<std::uint8_t> placed_;  // leaves that have their sample
  SpacedSamples samples_;
};

}  // namespace

SpacingParameters spacing_parameters(SpacingKind kind) {
  switch (kind) {
    case SpacingKind::fast:
      return {8, 2, 2, 16, 0.6, 0.52, 0.05, 4};
    case SpacingKind::best:
      return {32, 5, 3, 32, 0.78, 0.72, 0.05, 16};
    case SpacingKind::standard:
      break;
  }
  return {};
}

std::vector<std::string> validate(const SpacingParameters& p) {
  std::vector<std::string> problems;
  check_range(problems, "candidates", p.candidates, 8, 64);
  if (p.candidates % 8 != 0) problems.push_back("candidates are a multiple of 8");
  check_range(problems, "sweeps", p.sweeps, 0, 64);
  check_range(problems, "repairs", p.repairs, 0, 64);
  check_range(problems, "repair candidates", p.repair_candidates, 1, 256);
  check_range(problems, "least room", p.repair_below, 0.0, 1.0);
  check_range(problems, "least spacing", p.separate_below, 0.0, 1.0);
  check_range(problems, "share of separated samples", p.separate_share, 0.0, 1.0);
  check_range(problems, "separations", p.separations, 0, 64);
  return problems;
}

SpacedSamples space_samples(const Strata& strata, bool progressive, RandomKey key,
                            const SpacingParameters& parameters, const CancelToken& cancel) {
  const std::vector<std::string> problems = validate(parameters);
  if (!problems.empty()) throw std::invalid_argument(problems.front());
  SpacedSet set(strata, key, parameters, cancel);
  if (progressive)
    set.place_progressively();
  else
    set.place_along_path();
  return set.take();
}

}  // namespace meander
