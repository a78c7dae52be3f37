#include "kernels/sample/spaced_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <queue>
#include <stdexcept>
#include <tuple>
#include <unordered_map>

#include "kernels/core/check_range.h"
#include "kernels/core/parallel.h"
#include "kernels/core/vector3.h"
#include "kernels/sample/kernel_sums.h"
#include "kernels/sample/offered_places.h"
#include "kernels/sample/packed_rows.h"
#include "kernels/sample/sequence.h"
#include "kernels/sample/stratum_grid.h"
#include "kernels/sample/stratum_lists.h"

namespace meander {
using namespace spaced;

namespace {

// Where the short kernel ends: so many times the distance that repairs ask for, and at least at this one, in
// spacings.
constexpr float short_factor = 1.1f, min_short_reach = 0.715f * static_cast<float>(hexagonal_distance);
// The surface within reach, over that of a plane, up to which it counts as flat, and from which as a stack of
// sheets.
constexpr float flat_fullness = 1.02f, stacked_fullness = 1.15f;
// Where the surface within reach is more than this times that of a plane, sheets lie on each other, and
// samples cannot be so far apart.
constexpr float one_sheet = 2.5f;
// Steps to the distance within which no more sheets lie than let samples be so far apart: each halves the
// error.
constexpr int distance_steps = 5;
// Weights of the short kernel, while all samples move and in repairs.
constexpr float short_weight = 2, repair_weight = 10;
// How much of its own stratum's attraction a place loses for what is missing of the surface around it
// (measured: docs/METHODS.md 7.5).
constexpr float border_balance = 1.5f;
// What is missing is missing beside a plane, and so much of what more surface there is around.
constexpr float sheet_balance = 0.8f;
// The share of their weight that repairs keep in stacks of sheets, from the second fullness on, and all of it
// to the first: what drives samples apart drives them to the rims of thin plates.
constexpr float stacked_repair = 0.075f, alone_to = 1.25f, stacked_from = 1.5f;
// Strata farther away than this, in spacings, attract by their moments.
constexpr float near_gap = 0.25f;
// Strata of at least so many leaves count as equal where some have one more.
constexpr std::uint32_t nearly_equal_leaves = 256;
// Twice the trace of the second moments of groups of points is at least so large, so that its root has an
// inverse.
constexpr float min_trace = 1e-36f;
// Cells are at least so large, in mean reaches.
constexpr double min_cell = 1.0 / 1024;
// Strata larger than this, in spacings, are torn.
constexpr float torn_extent = 2.2f;
// How far from their strata's first places samples are put: in spacings, and in extents of the stratum.
constexpr float torn_margin = 0.55f, box_margin = 0.125f;
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
// The first level of a progressive set has 2^6 samples.
constexpr int first_level = 6;
// The last two levels of a progressive set are one where the last has fewer strata than this times those of
// the one before.
constexpr double as_one_below = 1.6;
// New places that a sample is offered around its own.
constexpr std::uint32_t refined_places = 8;
// Repairs offer up to so many times as many places as the first one.
constexpr std::uint32_t max_repair_factor = 4;
// Their short kernel doubles so often: what repels a sample outweighs everything else in the end.
constexpr unsigned max_doublings = 3;
// After so many passes the samples around those that are too near are moved too, within this times that
// distance, where no more than one in so many is left.
constexpr std::uint32_t passes_alone = 4;
constexpr float make_room = 1.6f;
constexpr std::uint32_t few_left = 64;
// Of the samples that are too near in the end, no more than one in so many leaves its stratum in a round: for
// a place of another one within so many spacings, one that is offered or one of so many new ones. The spacing
// there differs by at most this factor. In stacks of more sheets than this samples stay.
constexpr std::uint32_t few_leave = 64, leave_places = 24;
constexpr float leave_within = 2, leave_factor = 1.25f, max_leave_fullness = 3;
// So many strata for each that looks for a place at the same time as others, so that few see another one
// leave; and how many do so at most.
constexpr std::uint32_t strata_per_leaving = 8192;
constexpr std::size_t max_batch = 1024;
// Places farther than this from all samples, in spacings, are holes: 1.38 times those of the hexagonal
// lattice. Of the samples within so many times that distance one is moved to within so much of it, and leaves
// no place farther than so much.
constexpr float max_hole = 1.38f * 0.6204f, hole_movers = 2, hole_filled = 0.95f, hole_left = 0.97f;
// Holes are looked for around offered places that are at least so much of that distance away from all
// samples: as centers between the nearest samples, so many, within so many spacings; a hole is no farther
// than this from a place, in spacings.
constexpr float probe_share = 0.8f, enlarging_way = 0.35f, beside_surface = 0.25f;
constexpr std::size_t hole_samples = 5;
// Of the ways to fill a hole so many are tried, those first that add the least energy.
constexpr std::size_t most_fillings = 24;
// The first levels of a progressive set, up to so many samples, have as many rounds of it as there may be:
// what is too near there is so in all prefixes that follow, and few samples cost nothing.
constexpr std::uint32_t early_samples = 512;
// Where more than this share of the samples is too near, as in heaps of sheets, there is no room to leave
// for, and less beside samples that were placed before: only those on sheets that lie alone leave.
constexpr double crowded = 1.0 / 3, crowded_beside_held = 1.0 / 16;
// A sweep visits the strata in so many groups at random; those of one group do not see each other move.
constexpr std::uint32_t groups = 16;
constexpr std::size_t check_interval = 16;
// What SpacingParameters may ask for.
constexpr std::uint32_t max_sweeps = 64, max_refinements = 16, max_repairs = 64, max_leave_rounds = 8,
                        max_hole_rounds = 4;

// Of the places of a stratum, as in PointGroup.
struct StratumMoments {
  std::array<float, 3> mean{};
  std::array<float, 6> central{};
  float per_extent = 0;
};

// The place that a sample which left its stratum has taken: `number` of stratum `host`.
struct TakenPlace {
  std::uint32_t host, number;
};
using TakenPlaces = std::map<std::uint32_t, TakenPlace>;  // by the sample's stratum

// The samples of one level.
class SpacedLevel {
 public:
  // repair_below: what is too near, in spacings of the hexagonal lattice.
  SpacedLevel(const Strata& strata, const OfferedStrata& offered, int level, double repair_below,
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
        near_(blocks_.count, draw_block),
        sample_(blocks_.count),
        number_(blocks_.count) {}

  // Fixes the sample of a stratum.
  void hold(std::uint32_t stratum, const Point& at) {
    sample_[stratum] = at;
    number_[stratum] = held;
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
    find_moments();
    find_attraction(free);
    for (std::uint32_t sweep = 0; sweep < parameters_.sweeps; ++sweep)
      visit_groups(free, sweep, [&](std::uint32_t s, Visit& visit) { return choose(s, visit); });
    for (std::uint32_t pass = 0; pass < parameters_.refinements; ++pass)
      visit_groups(free, max_sweeps + pass, [&](std::uint32_t s, Visit& visit) {
        const std::uint32_t share = offer_.share_of(number_[s]), count = refined_places;
        return choose_new(s, near_place | (share * near_numbers + pass * count), count, sweep_weight(s),
                          visit);
      });
    std::vector<std::uint32_t> all = free;
    const double few = (free.size() < blocks_.count ? crowded_beside_held : crowded) * double(free.size());
    for (std::uint32_t pass = 0; pass < parameters_.repairs; ++pass) {
      free = to_repair(free, pass);
      const auto move = [&](std::uint32_t s, Visit& visit) {
        // Fewer are left in each pass, and those need more places.
        const std::uint32_t more = std::min(pass + 1, max_repair_factor);
        const std::uint32_t first =
            parameters_.candidates + pass * max_repair_factor * parameters_.repair_candidates;
        return choose_new(s, first, more * parameters_.repair_candidates,
                          stacked_weight(s) * static_cast<float>(1u << std::min(pass, max_doublings)), visit);
      };
      // The last pass goes in one turn, so that no two of its samples miss each other.
      if (pass + 1 < parameters_.repairs)
        visit_groups(free, max_sweeps + max_refinements + pass, move);
      else
        visit_in_turn(free, move);
    }
    const std::uint32_t rounds = is_early() ? max_leave_rounds : parameters_.leave_rounds;
    for (std::uint32_t round = 0; round < rounds; ++round) {
      all = too_near(all);
      leave_strata(first_of(all, 1.0 / few_leave), all.size() <= few ? max_leave_fullness : alone_to);
    }
    if (blocks_.count == blocks_.leaves && metric_.empty())
      for (std::uint32_t round = 0; round < parameters_.hole_rounds; ++round) fill_holes();
  }

  // By stratum: which of its places the sample has taken, or had when it left.
  std::vector<std::uint32_t> take_numbers() { return std::move(number_); }
  // Of the samples that have left their strata.
  TakenPlaces take_places() { return std::move(taken_); }

 private:
  static constexpr std::uint32_t held = 0xFFFFFFFFu;
  bool is_early() const {
    return parameters_.leave_rounds > 0 && blocks_.count <= early_samples && blocks_.count < blocks_.leaves;
  }
  bool is_held(std::uint32_t stratum) const { return number_[stratum] == held; }

  // Where a sample goes.
  struct Choice {
    std::uint32_t number;
    Point at;
  };
  // Scratch of a visit to a stratum.
  struct Visit {
    std::vector<std::uint32_t> near;
    PointRows places, samples, background;  // what is asked about; and what there is around it
    PointRows in_space;                     // the places, where metrics differ from place to place
    std::vector<PointGroup> groups;
    PointRows torn;
    std::vector<std::uint32_t> weight;  // of the strata of the background
    std::vector<float> energy, own;     // of the places, and what their own stratum attracts
    std::vector<PointDraw> draws;       // of new places,
    std::vector<StratumPoint> points;
    std::vector<std::uint32_t> number;  // and of `places`,
    std::vector<std::uint32_t> host;    // and their strata, where these differ
  };

  // The farthest that anything within the reach of a stratum, or within `distance` in its metric, is in
  // space.
  float in_space(std::uint32_t stratum, float distance) const {
    return metric_.empty() ? distance : distance * metric_[stratum].stretch;
  }
  // The places are far apart: the path jumps between pieces of the surface.
  bool is_torn(std::uint32_t stratum) const {
    return offered_.extent(stratum) > torn_extent * in_space(stratum, spacing_[stratum]);
  }
  // How far from the box of its places, or from one of these where it is torn, the sample is.
  float margin(std::uint32_t stratum) const {
    const float extent = offered_.extent(stratum), wide = in_space(stratum, spacing_[stratum]);
    return extent > torn_extent * wide ? torn_margin * wide : box_margin * extent;
  }
  float reach_of(std::uint32_t stratum) const { return reach_[stratum] * spacing_[stratum]; }

  // Lists the strata around each one whose sample is to be chosen.
  void find_neighbors() {
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
      if (is_held(s)) enclose(box, sample_[s]);
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

  // Scratch of a thread that finds neighbors.
  struct Search {
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

  // How far from the box of a stratum, or of one of its places where it is torn, others can matter: its
  // sample stays within the margin.
  float around(std::uint32_t stratum) const { return in_space(stratum, reach_of(stratum)) + margin(stratum); }

  // Strata of a run along the path are neighbors: looks for what is near any of them in one go. False where
  // they are too far apart for that.
  bool find_candidates(std::uint32_t first, std::uint32_t last, Search& search) const {
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
             (is_held(other) && is_within(run, sample_[other], distance));
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

  // Finds the strata around one; looks less far where there are too many.
  void look_around(std::uint32_t stratum, bool among_candidates, Search& search) {
    const PointBox& box = offered_.box(stratum);
    offered_.load(stratum, search.places, 0);
    for (int shortening = 0; shortening <= max_shortenings; ++shortening) {
      const float distance = around(stratum);
      if (among_candidates) {
        pick_candidates(stratum, distance, search);
      } else {
        const auto is_near = [&](std::uint32_t other, const PointBox& place) {
          return other != stratum && (may_touch(other, place, distance + margin(other), search.others) ||
                                      (is_held(other) && is_within(place, sample_[other], distance)));
        };
        search.grid.find(search.places.x, search.places.y, search.places.z, box, is_torn(stratum), distance,
                         max_neighbors, is_near, search.scratch, search.found);
      }
      if (search.found.size() < max_neighbors) break;
      reach_[stratum] *= shorter_reach;
    }
  }

  void pick_candidates(std::uint32_t stratum, float distance, Search& search) const {
    const PointBox box = offered_.box(stratum);
    const std::size_t count = search.candidates.size();
    find_gaps(search.boxes, box.low, box.high, distance, search.beyond);
    search.found.resize(count);
    std::size_t found = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t other = search.candidates[i];
      bool near = search.beyond[i] <= 0;
      if (near && is_torn(other)) near = may_touch(other, box, distance + margin(other), search.others);
      if (!near && is_held(other)) near = is_within(box, sample_[other], distance);
      search.found[found] = other;
      found += near && other != stratum ? 1 : 0;
    }
    search.found.resize(found);
  }

  // Whether a stratum has places within `distance` of a box.
  bool may_touch(std::uint32_t stratum, const PointBox& box, float distance, PointRows& places) const {
    if (squared_gap(offered_.box(stratum), box) > distance * distance) return false;
    if (!is_torn(stratum)) return true;
    places.resize(offered_.places());
    offered_.load(stratum, places, 0);
    for (std::size_t i = 0; i < places.size(); ++i)
      if (is_within(box, {places.x[i], places.y[i], places.z[i]}, distance)) return true;
    return false;
  }
  // Whether a new place is so near the offered ones, which decide what is known of its surroundings.
  bool takes(std::uint32_t stratum, const Point& at, PointRows& places) const {
    const PointBox point = {{at.x, at.y, at.z}, {at.x, at.y, at.z}};
    return may_touch(stratum, point, margin(stratum), places);
  }

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
  void places_to_metric(std::uint32_t stratum, Visit& visit) const {
    if (metric_.empty()) return;
    visit.in_space = visit.places;
    to_metric(stratum, visit.places, visit.places.size());
  }
  // The places of a stratum in the metric of another one.
  PointGroup in_metric(std::uint32_t stratum, std::uint32_t other) const {
    const StratumMoments& moments = moments_[other];
    const PointGroup group{mass_of(other), moments.mean, moments.central, moments.per_extent};
    return metric_.empty() ? group : to_metric(stratum, group);
  }
  PointGroup to_metric(std::uint32_t stratum, const PointGroup& group) const {
    const auto& rows = metric_[stratum].rows;
    const std::array<float, 6>& c = group.central;
    const std::array<std::array<float, 3>, 3> central{
        {{c[0], c[5], c[4]}, {c[5], c[1], c[3]}, {c[4], c[3], c[2]}}};
    const auto along = [&](std::size_t i, std::size_t j) {
      float sum = 0;
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < 3; ++l) sum += rows[i][k] * central[k][l] * rows[j][l];
      return sum;
    };
    PointGroup result{
        group.mass, {}, {along(0, 0), along(1, 1), along(2, 2), along(1, 2), along(0, 2), along(0, 1)}};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) result.mean[i] += rows[i][k] * group.mean[k];
    result.per_extent = inverse_extent(result.central);
    return result;
  }
  static float inverse_extent(const std::array<float, 6>& central) {
    return 1 / std::sqrt(std::max(2 * (central[0] + central[1] + central[2]), min_trace));
  }

  // Mass of a stratum, in samples.
  float mass_of(std::uint32_t stratum) const {
    return equal_
               ? 1.0f
               : static_cast<float>(double(blocks_.size(stratum)) * blocks_.count / double(blocks_.leaves));
  }

  // Of the places of each stratum.
  void find_moments() {
    const std::size_t places = offered_.places();
    const float share = 1 / static_cast<float>(places);
    moments_.resize(blocks_.count);
    parallel_blocks(blocks_.count, draw_block, [&](std::size_t begin, std::size_t end) {
      PointRows rows;
      rows.resize(places);
      for (std::size_t s = begin; s < end; ++s) {
        offered_.load(s, rows, 0);
        StratumMoments& moments = moments_[s];
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

  // What the surface attracts visit.places with, into visit.energy, and the share of their own stratum, into
  // visit.own; the places are put in its metric.
  void attract(std::uint32_t stratum, Visit& visit) const {
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
        visit.groups.push_back(in_metric(stratum, other));
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
      add_kernel(visit.places, visit.background, first * places, (last - first) * places, scale,
                 visit.energy);
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

  // The attraction of all offered places of strata, with what borders take away.
  void find_attraction(const std::vector<std::uint32_t>& strata) {
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
      const float flat = static_cast<float>(std::numbers::pi / 6) * reach_[s] * reach_[s];
      fullness_[i] = mean / flat;
      around_[i] = 1;
      const float share = own_share(s);
      for (std::size_t k = 0; k < places; ++k) visit.energy[k] -= share * visit.own[k];
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
      if (more == 0) return;
      load_places(s, visit);
      visit.near.clear();
      attract(s, visit);
      attraction_.read(i, visit.energy);
      for (std::size_t k = 0; k < places; ++k) visit.energy[k] -= more * visit.own[k];
      attraction_.write(i, visit.energy);
    });
  }
  // visit_stratum(i, strata[i], visit) for all, with what is near it in visit.near.
  template <class VisitStratum>
  void visit_all(const std::vector<std::uint32_t>& strata, const VisitStratum& visit_stratum) {
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
  void load_places(std::uint32_t stratum, Visit& visit) const {
    visit.places.resize(offered_.places());
    offered_.load(stratum, visit.places, 0);
  }
  // Of strata, as far as it is known.
  float mean_fullness(const std::vector<std::uint32_t>& strata) const {
    float sum = 0, count = 0;
    for (const std::uint32_t s : strata) {
      if (is_held(s)) continue;
      sum += fullness_[slot_of(s)];
      count += 1;
    }
    return count > 0 ? sum / count : 1.0f;
  }

  // How much of its own stratum's attraction a place loses: at a border, surface is missing.
  float own_share(std::uint32_t stratum) const {
    const std::size_t slot = slot_of(stratum);
    const float whole = 1 + sheet_balance * std::max(around_[slot] - flat_fullness, 0.0f);
    return std::clamp(border_balance * (1 - fullness_[slot] / whole), 0.0f, 1.0f);
  }
  // Weight of the short kernel in repairs.
  float stacked_weight(std::uint32_t stratum) const {
    const std::size_t slot = slot_of(stratum);
    const float stack = (std::max(fullness_[slot], around_[slot]) - alone_to) / (stacked_from - alone_to);
    return repair_weight * (1 - (1 - stacked_repair) * std::clamp(stack, 0.0f, 1.0f));
  }
  // Nearer than this is too near.
  float min_distance(std::uint32_t stratum) const {
    const float apart = apart_.empty() ? distance_on_sheets(stratum) : apart_[slot_of(stratum)];
    return too_near_ * spacing_[stratum] * apart;
  }
  // How many sheets lie within reach, by their surface.
  float sheets_at(std::uint32_t stratum) const { return fullness_[slot_of(stratum)] - (one_sheet - 1); }
  // The distance that samples can keep where sheets coincide, over that on a single one.
  float distance_on_sheets(std::uint32_t stratum) const {
    return 1 / std::sqrt(std::max(sheets_at(stratum), 1.0f));
  }
  // The same where they fill space, as in heaps: only those count that lie within that distance of each
  // other. near: the strata around.
  float distance_among_sheets(std::uint32_t stratum, const std::vector<std::uint32_t>& near) const {
    const float coincident = distance_on_sheets(stratum);
    if (coincident == 1) return 1;
    const float thickness = thickness_around(stratum, near) / spacing_[stratum];
    float distance = coincident;
    for (int step = 0; step < distance_steps; ++step)
      distance = coincident * std::sqrt(std::max(thickness / distance, 1.0f));
    return std::min(distance, 1.0f);
  }
  // How thick the layer is that the strata within reach of one fill, in its metric. Of a plate that is wide
  // beside its thickness; of a ball nine tenths of the radius: twice the root of the harmonic mean of the
  // principal second moments.
  float thickness_around(std::uint32_t stratum, const std::vector<std::uint32_t>& near) const {
    const PointGroup own = in_metric(stratum, stratum);
    const float far = reach_of(stratum);
    double mass = own.mass;
    std::array<double, 3> sum{};
    std::array<double, 6> square{};  // xx, yy, zz, yz, xz, xy
    for (const std::uint32_t other : near) {
      const PointGroup group = in_metric(stratum, other);
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
  // Weight of the short kernel while all samples move. It has no counterpart in the attraction: in stacks of
  // sheets, as both sides of a thin plate, it would drive samples out of them or to their rims.
  float sweep_weight(std::uint32_t stratum) const {
    const float alone = (stacked_fullness - fullness_[slot_of(stratum)]) / (stacked_fullness - flat_fullness);
    return short_weight * std::clamp(alone, 0.0f, 1.0f);
  }
  std::size_t slot_of(std::uint32_t stratum) const { return slot_.empty() ? stratum : slot_[stratum]; }

  // The samples around a stratum, in its metric. Some are out of reach, where kernels are 0: to leave them
  // out costs more than to count them.
  void find_samples(std::uint32_t stratum, Visit& visit) const {
    const std::size_t count = visit.near.size();
    visit.samples.resize(count);
    float *const x = visit.samples.x.data(), *const y = visit.samples.y.data(),
                 *const z = visit.samples.z.data();
    for (std::size_t i = 0; i < count; ++i) {
      const Point sample = sample_[visit.near[i]];
      x[i] = sample.x;
      y[i] = sample.y;
      z[i] = sample.z;
    }
    to_metric(stratum, visit.samples, count);
  }
  // Adds what these repel the places with.
  void repel(std::uint32_t stratum, float weight, Visit& visit) const {
    const float within = min_distance(stratum) * std::max(short_factor, min_short_reach / too_near_);
    const KernelScale scale{1 / reach_of(stratum), 1 / within, 1, metric_.empty() ? weight : 0};
    add_kernel(visit.places, visit.samples, 0, visit.samples.size(), scale, visit.energy);
    if (metric_.empty()) return;
    for_each_near(stratum, within, visit, [&](std::size_t place, std::size_t, float distance) {
      const float left = 1 - distance / within;
      visit.energy[place] += weight * left * left;
    });
  }

  // Calls visit_pair(place, sample, distance) where these are less than `within` apart, in the spacings of
  // the stratum. Where metrics differ from place to place, that is the shorter of the distances in those of
  // both strata: by one of them alone, a sample would be too near for one side and stay for the other.
  template <class VisitPair>
  void for_each_near(std::uint32_t stratum, float within, const Visit& visit,
                     const VisitPair& visit_pair) const {
    for (std::size_t i = 0; i < visit.near.size(); ++i)
      for (std::size_t k = 0; k < visit.places.size(); ++k) {
        const float x = visit.samples.x[i] - visit.places.x[k], y = visit.samples.y[i] - visit.places.y[k],
                    z = visit.samples.z[i] - visit.places.z[k];
        const float squared = x * x + y * y + z * z;
        if (metric_.empty()) {
          if (squared < within * within) visit_pair(k, i, std::sqrt(squared));
          continue;
        }
        const Point sample = sample_[visit.near[i]];
        const float there = length_in_metric(
            visit.near[i],
            {sample.x - visit.in_space.x[k], sample.y - visit.in_space.y[k], sample.z - visit.in_space.z[k]});
        const float distance =
            std::min(std::sqrt(squared), there * spacing_[stratum] / spacing_[visit.near[i]]);
        if (distance < within) visit_pair(k, i, distance);
      }
  }
  float length_in_metric(std::uint32_t stratum, const Point& v) const {
    float squared = 0;
    for (const auto& row : metric_[stratum].rows) {
      const float along = row[0] * v.x + row[1] * v.y + row[2] * v.z;
      squared += along * along;
    }
    return std::sqrt(squared);
  }

  // The place of its stratum where the sample has the least energy; among places that are equally good, it
  // stays.
  Choice choose(std::uint32_t stratum, Visit& visit) const {
    const std::size_t places = offered_.places();
    visit.places.resize(places);
    offered_.load(stratum, visit.places, 0);
    find_samples(stratum, visit);
    places_to_metric(stratum, visit);
    visit.energy.resize(places);
    attraction_.read(slot_of(stratum), visit.energy);
    for (float& energy : visit.energy) energy = -energy;
    repel(stratum, sweep_weight(stratum), visit);
    std::uint32_t best = number_[stratum];
    for (std::uint32_t k = 0; k < places; ++k)
      if (visit.energy[k] < visit.energy[best]) best = k;
    return {best, offered_.place(stratum, best)};
  }

  // Draws new places, `first` and the numbers after it, into visit.draws and visit.points.
  void draw_new(std::uint32_t stratum, std::uint32_t first, std::uint32_t count, Visit& visit) const {
    visit.draws.resize(count);
    visit.points.resize(count);
    for (std::uint32_t k = 0; k < count; ++k) visit.draws[k] = offer_.draw({level_, stratum, first + k});
    std::sort(visit.draws.begin(), visit.draws.end(),
              [](const PointDraw& a, const PointDraw& b) { return a.at < b.at; });
    strata_.draw(visit.draws, visit.points);
  }

  // The same among new places, `first` and the numbers after it; the sample may stay.
  Choice choose_new(std::uint32_t stratum, std::uint32_t first, std::uint32_t count, float weight,
                    Visit& visit) const {
    draw_new(stratum, first, count, visit);
    ask_about(sample_[stratum], visit);
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
    const auto best = static_cast<std::size_t>(std::min_element(visit.energy.begin(), visit.energy.end()) -
                                               visit.energy.begin());
    if (best == 0) return {number_[stratum], sample_[stratum]};
    const std::uint32_t k = visit.number[best];
    return {visit.draws[k].number, point_at(visit.points[k])};
  }

  static void ask_about(const Point& at, Visit& visit) {
    visit.places.resize(0);
    visit.places.push_back(at.x, at.y, at.z);
  }

  // The sample of a stratum as the only place, and those around it, in its metric.
  void look_at_sample(std::uint32_t stratum, Visit& visit) const {
    near_.read(stratum, visit.near);
    ask_about(sample_[stratum], visit);
    find_samples(stratum, visit);
    places_to_metric(stratum, visit);
  }

  // Those whose sample is too near to another one, the nearest first.
  std::vector<std::uint32_t> too_near(const std::vector<std::uint32_t>& strata) const {
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
  // The first of these, no more than a share of all strata: where samples cannot be so far apart, as in
  // stacked sheets, not all are moved again and again.
  std::vector<std::uint32_t> first_of(std::vector<std::uint32_t> strata, double share) const {
    const auto most = static_cast<std::size_t>(std::ceil(share * blocks_.count));
    strata.resize(std::min(strata.size(), most));
    return strata;
  }

  // What a pass of repairs moves, ascending: those, and what add_partners adds.
  std::vector<std::uint32_t> to_repair(const std::vector<std::uint32_t>& strata, std::uint32_t pass) const {
    std::vector<std::uint32_t> result =
        first_of(too_near(strata), parameters_.repair_share / ((pass + 1.0) * (pass + 1.0)));
    if (result.size() <= blocks_.count / few_left) add_partners(pass < passes_alone ? 1 : make_room, result);
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

  // Adds the strata whose samples lie within so many least distances of theirs: of what is too near, these
  // may find a place where those do not; and others may make room.
  void add_partners(float within, std::vector<std::uint32_t>& strata) const {
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

  // Moves samples that are too near to another one out of their strata, as if one after the other: to the
  // nearest place around with room enough, or else to the one with the most room. Those in larger stacks
  // stay. Of many strata a batch looks for places at once; those that see one leave before them look again.
  void leave_strata(const std::vector<std::uint32_t>& strata, float max_fullness) {
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

  // Where the sample of a stratum goes that leaves it; nothing: it stays.
  struct Leaving {
    TakenPlace place;
    Point at;
  };
  std::optional<Leaving> find_place(std::uint32_t stratum, Visit& visit) const {
    std::optional<Leaving> result;
    near_.read(stratum, visit.near);
    add_hosted(stratum, visit.near);
    Point at = sample_[stratum];
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
  // Whether find_place looks at any of these.
  bool sees_any(std::uint32_t stratum, const std::vector<std::uint32_t>& others, Visit& visit) const {
    if (others.empty()) return false;
    near_.read(stratum, visit.near);
    return std::ranges::any_of(others, [&](std::uint32_t other) {
      return other == stratum || std::ranges::binary_search(visit.near, other);
    });
  }

  // Asks about a place of the sample of a stratum, and those around it: those that the strata have offered,
  // or new ones. Farther away not all samples are known.
  void offer_around(std::uint32_t stratum, const Point& sample, bool anew, Visit& visit) const {
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
  // At borders there seems to be room: rims of plates would fill.
  bool may_host(std::uint32_t host, std::uint32_t stratum) const {
    return !is_held(host) && own_share(host) == 0 && spacing_[host] <= leave_factor * spacing_[stratum] &&
           spacing_[stratum] <= leave_factor * spacing_[host];
  }

  // Adds the strata, which may be farther away, whose samples have come into this one or one of `near`.
  void add_hosted(std::uint32_t stratum, std::vector<std::uint32_t>& near) const {
    if (hosted_.empty()) return;
    const std::size_t count = near.size();
    const auto add = [&](std::uint32_t host) {
      const auto [first, last] = hosted_.equal_range(host);
      for (auto at = first; at != last; ++at)
        if (at->second != stratum) near.push_back(at->second);
    };
    add(stratum);
    for (std::size_t i = 0; i < count; ++i) add(near[i]);
  }

  // The stratum where the sample of this one is.
  std::uint32_t host_of(std::uint32_t stratum) const {
    const auto at = taken_.find(stratum);
    return at == taken_.end() ? stratum : at->second.host;
  }
  void leave(std::uint32_t stratum, const Leaving& leaving) {
    if (const auto before = taken_.find(stratum); before != taken_.end()) {
      auto at = hosted_.equal_range(before->second.host).first;
      while (at->second != stratum) ++at;
      hosted_.erase(at);
    }
    hosted_.insert({leaving.place.host, stratum});
    taken_[stratum] = leaving.place;
    sample_[stratum] = leaving.at;
  }

  // A place far from all samples.
  struct Hole {
    float distance = 0;  // of the nearest sample, in spacings
    std::uint32_t stratum = 0;
    Point at;
    bool operator<(const Hole& other) const {
      return distance < other.distance || (distance == other.distance && stratum > other.stratum);
    }
  };
  // Moves samples beside the largest holes into these, one after the other, where that opens no hole as large
  // and brings no two samples too near to each other.
  void fill_holes() {
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
  // On a single sheet, and its sample in its stratum.
  bool can_fill(std::uint32_t stratum) const {
    return !is_held(stratum) && fullness_[slot_of(stratum)] <= alone_to;
  }
  void read_near(std::uint32_t stratum, std::vector<std::uint32_t>& near) const {
    near_.read(stratum, near);
    add_hosted(stratum, near);
  }
  // The places which may be in holes, of a stratum and of those beside it along the path whose samples were
  // placed before, and which do not know what is around them.
  void find_probes(std::uint32_t stratum, std::vector<Hole>& probes, Visit& visit) const {
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
  // The farthest of visit.places from all visit.samples; by place, the distances in visit.energy.
  Hole find_hole(std::uint32_t stratum, Visit& visit) const {
    visit.energy.assign(visit.places.size(), INFINITY);
    find_nearest(visit.places, visit.samples, visit.near.size(), visit.energy);
    for (float& squared : visit.energy) squared = std::sqrt(squared) / spacing_[stratum];
    const auto k = static_cast<std::size_t>(std::ranges::max_element(visit.energy) - visit.energy.begin());
    return {visit.energy[k], stratum, {visit.places.x[k], visit.places.y[k], visit.places.z[k]}};
  }

  // From a place to the point around it that is as far from three samples, where that is farther from all of
  // visit.samples, and beside the surface.
  void enlarge(Hole& hole, Visit& visit) const {
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
  bool is_beside_surface(const Hole& hole, Visit& visit) const {
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
  struct Filling {
    float energy;
    std::uint32_t stratum;
    Choice choice;
  };
  // Returns the largest hole that this opens.
  Hole fill(const Hole& hole, Visit& visit) {
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
    for (const bool anew : {false, true})
      for (const std::uint32_t s : beside)
        if (can_fill(s) && !taken_.contains(s) && is_near(sample_[s], hole.at, hole_movers * far))
          add_fillings(s, anew, hole.at, hole_filled * far, visit, fillings);
    std::ranges::sort(fillings, {}, [](const Filling& filling) {
      return std::tuple(filling.energy, filling.stratum, filling.choice.number);
    });
    if (fillings.size() > most_fillings) fillings.erase(fillings.begin() + most_fillings, fillings.end());
    const Filling* best = nullptr;
    Hole least{hole_left * distance, hole.stratum, {}};
    for (const Filling& filling : fillings) {
      const Hole opened = opened_by(filling, visit);
      if (opened.distance >= least.distance) continue;
      least = opened;
      best = &filling;
      if (opened.distance <= max_hole) break;
    }
    if (best == nullptr) return {};
    move(best->stratum, best->choice);
    return least;
  }
  static float squared_distance(const Point& a, const Point& b) {
    const float x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
    return x * x + y * y + z * z;
  }
  static bool is_near(const Point& a, const Point& b, float distance) {
    return squared_distance(a, b) < distance * distance;
  }
  // Adds the places of a stratum, the offered or new ones, within `distance` of a hole where its sample is
  // not too near to others.
  void add_fillings(std::uint32_t stratum, bool anew, const Point& hole, float distance, Visit& visit,
                    std::vector<Filling>& fillings) const {
    std::vector<Choice> choices;
    read_near(stratum, visit.near);
    ask_about(sample_[stratum], visit);
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
  // The largest hole that is there where a sample was when it has moved.
  Hole opened_by(const Filling& filling, Visit& visit) {
    const std::uint32_t s = filling.stratum;
    const Choice before{number_[s], sample_[s]};
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

  // By place, into visit.energy: the distance to the nearest sample over what is too near, at most 1.
  void find_room(std::uint32_t stratum, Visit& visit) const {
    const float least = min_distance(stratum);
    visit.energy.assign(visit.places.size(), 1.0f);
    for_each_near(stratum, least, visit, [&](std::size_t place, std::size_t, float nearer) {
      visit.energy[place] = std::min(visit.energy[place], nearer / least);
    });
  }

  // Of the places with the most room, the nearest to the first, where the sample is.
  static std::size_t roomiest(const Visit& visit) {
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

  void move(std::uint32_t stratum, const Choice& choice) {
    number_[stratum] = choice.number;
    sample_[stratum] = choice.at;
  }

  // Moves the samples of strata one after the other to what choose(stratum, visit) returns.
  template <class Choose>
  void visit_in_turn(const std::vector<std::uint32_t>& strata, const Choose& choose) {
    Visit visit;
    for (std::size_t i = 0; i < strata.size(); ++i) {
      if (i % check_interval == 0) cancel_.check();
      near_.read(strata[i], visit.near);
      move(strata[i], choose(strata[i], visit));
    }
  }

  // The same in groups at random, other ones in each turn: in the order of the path all samples would drift
  // one way, and the integrals of smooth functions would no longer converge as fast. Within a group all
  // choose, then all move.
  template <class Choose>
  void visit_groups(const std::vector<std::uint32_t>& strata, std::uint32_t turn, const Choose& choose) {
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
          near_.read(members[i], visit.near);
          choices[i] = choose(members[i], visit);
        }
      });
      for (std::size_t i = 0; i < members.size(); ++i) move(members[i], choices[i]);
    }
  }

  // Strata by their groups; begin: where each of these begins.
  std::vector<std::uint32_t> grouped(const std::vector<std::uint32_t>& strata, std::uint32_t turn,
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

  // Counters of random numbers of a stratum: its start, the shift of Offer::in_leaf, and its group in each
  // turn.
  static constexpr std::uint32_t first_turn = 2;

  const Strata& strata_;
  const OfferedPlaces& offered_;
  const std::vector<float>& spacing_;
  const std::vector<LocalMetric>& metric_;
  LeafBlocks blocks_;
  std::uint32_t level_;
  const Offer& offer_;
  const SpacingParameters& parameters_;
  float too_near_;  // in spacings
  const CancelToken& cancel_;
  bool equal_;                // all strata have as many leaves, or nearly
  std::vector<float> reach_;  // of the kernel around each, in its spacings
  StratumLists near_;
  std::vector<StratumMoments> moments_;
  std::vector<std::uint32_t> slot_;  // by stratum: among those without a held sample; empty where all are
  PackedRows attraction_{0, 0};      // by slot: of all offered places
  std::vector<float> fullness_;      // by slot: attraction over that of a flat surface,
  std::vector<float> around_;        // and its mean over the strata around,
  std::vector<float> apart_;         // distance_among_sheets; empty where distance_on_sheets holds
  std::vector<Point> sample_;
  std::vector<std::uint32_t> number_;  // of the place of the sample, or held
  TakenPlaces taken_;
  std::unordered_multimap<std::uint32_t, std::uint32_t> hosted_;  // by host: the strata of such samples
};

class SpacedSet {
 public:
  SpacedSet(const Strata& strata, RandomKey key, const SpacingParameters& parameters,
            const CancelToken& cancel)
      : strata_(strata),
        cancel_(cancel),
        offer_{key, parameters, Levels(strata.count())},
        leaves_(offer_leaves(strata, offer_, cancel)),
        placed_(strata.count()) {}

  void place_along_path() { place_level(offer_.levels.last, {}, offer_.parameters.repair_below); }

  // The order is that of progressive_order, but that the halves that get new samples are those without one.
  void place_progressively() {
    const int last = offer_.levels.last;
    const std::uint32_t mask = progressive_mask(strata_.count(), offer_.key);
    int level = std::min(first_level, last);
    const double repair_below = offer_.parameters.progressive_repair_below;
    place_level(level, masked_order(offer_.levels.blocks(level).count, mask), repair_below);
    while (level < last) {
      ++level;
      if (level < last - 1 || (level < last && !last_two_as_one())) {
        place_level(level, free_children(level, mask), repair_below);
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
      place_level(level, order, repair_below);
    }
  }

  SpacedSamples take() {
    leaves_ = OfferedStrata(0, 0, true);
    samples_.point.resize(drawn_.size());
    for (std::size_t i = 0; i < drawn_.size(); ++i) samples_.point[samples_.rank_of_index[i]] = drawn_[i];
    return std::move(samples_);
  }

 private:
  // Where only few strata of the level before the last have two leaves, a second sample would find no room
  // between the others, which know nothing of it: the samples of both levels are placed together.
  bool last_two_as_one() const {
    const double before = offer_.levels.blocks(offer_.levels.last - 1).count;
    return offer_.levels.last > first_level + 1 && strata_.count() < as_one_below * before;
  }

  // Places the samples of one level into its strata without one; `order`: these strata, in the order of the
  // samples in the file; empty: all along the path.
  void place_level(int level, const std::vector<std::uint32_t>& order, double repair_below) {
    const LeafBlocks blocks = offer_.levels.blocks(level);
    const bool is_last = level == offer_.levels.last;
    const OfferedStrata coarser =
        is_last ? OfferedStrata(0, 0, true) : offer_blocks(leaves_, level, offer_, cancel_);
    const std::size_t before = drawn_.size();
    TakenPlaces taken;
    const std::vector<std::uint32_t> numbers = [&] {
      SpacedLevel samples(strata_, is_last ? leaves_ : coarser, level, repair_below, offer_, cancel_);
      for (std::size_t i = 0; i < before; ++i)
        samples.hold(blocks.block_of(samples_.rank_of_index[i]), point_at(drawn_[i]));
      samples.space_out();
      taken = samples.take_places();
      return samples.take_numbers();
    }();
    // The points themselves, not packed places: samples of later levels keep their distance from these.
    const std::size_t count = order.empty() ? blocks.count : order.size();
    samples_.rank_of_index.resize(before + count);
    drawn_.resize(before + count);
    parallel_blocks(count, draw_block, [&](std::size_t begin, std::size_t end) {
      cancel_.check();
      for (std::size_t i = begin; i < end; ++i) {
        const auto draw_place = [&](std::uint32_t stratum, std::uint32_t number) {
          const PointDraw draw = offer_.draw({static_cast<std::uint32_t>(level), stratum, number});
          strata_.draw(std::span(&draw, 1), std::span(&drawn_[before + i], 1));
          return static_cast<std::uint32_t>(draw.at);
        };
        const std::uint32_t stratum = order.empty() ? static_cast<std::uint32_t>(i) : order[i];
        const std::uint32_t leaf = draw_place(stratum, numbers[stratum]);
        if (const auto at = taken.find(stratum); at != taken.end())
          draw_place(at->second.host, at->second.number);
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
  std::vector<StratumPoint> drawn_;   // in the order of the samples
  SpacedSamples samples_;
};

}  // namespace

SpacingParameters spacing_parameters(SpacingKind kind) {
  switch (kind) {
    case SpacingKind::fast:
      return {8, 3, 0, 16, 16, 0.6, 0.54, 0.2, 2, 0};
    case SpacingKind::best:
      return {24, 3, 1, 16, 32, 0.72, 0.62, 0.2};
    case SpacingKind::standard:
      break;
  }
  return {};
}

std::vector<std::string> validate(const SpacingParameters& p) {
  std::vector<std::string> problems;
  check_range(problems, "candidates", p.candidates, 8, 64);
  if (p.candidates % 8 != 0) problems.push_back("candidates are a multiple of 8");
  check_range(problems, "sweeps", p.sweeps, 0, max_sweeps);
  check_range(problems, "refinements", p.refinements, 0, max_refinements);
  check_range(problems, "repairs", p.repairs, 0, max_repairs);
  check_range(problems, "repair candidates", p.repair_candidates, 1, 256);
  check_range(problems, "least spacing", p.repair_below, 0.1, 1.0);
  check_range(problems, "least spacing of progressive sets", p.progressive_repair_below, 0.1, 1.0);
  check_range(problems, "share of repaired samples", p.repair_share, 0.0, 1.0);
  check_range(problems, "rounds in which samples leave their strata", p.leave_rounds, 0, max_leave_rounds);
  check_range(problems, "rounds in which holes are filled", p.hole_rounds, 0, max_hole_rounds);
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
