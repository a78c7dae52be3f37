// Internal to kernels/sample: the spaced samples of one level (docs/METHODS.md 7.5).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/sample/far_field.h"
#include "kernels/sample/kernel_sums.h"
#include "kernels/sample/offered_places.h"
#include "kernels/sample/packed_rows.h"
#include "kernels/sample/spaced_samples.h"
#include "kernels/sample/stratum_grid.h"
#include "kernels/sample/stratum_lists.h"

namespace meander::spaced {

// The surface within reach, over that of a plane, up to which it counts as flat, and from which as a stack of
// sheets.
inline constexpr float flat_fullness = 1.02f, stacked_fullness = 1.15f;
// Where the surface within reach is more than this times that of a plane, sheets lie on each other, and
// samples cannot be so far apart.
inline constexpr float one_sheet = 2.5f;
// Weights of the short kernel, while all samples move and in repairs.
inline constexpr float short_weight = 2, repair_weight = 10;
// How much of its own stratum's attraction a place loses for what is missing of the surface around it
// (measured: docs/METHODS.md 7.5).
inline constexpr float border_balance = 1.5f;
// Surface is missing beside a plane, and beside so much of what more of it there is around.
inline constexpr float sheet_balance = 0.8f;
// The share of their weight that repairs keep in stacks of sheets, from the second fullness on, and all of it
// to the first: what drives samples apart drives them to the rims of thin plates.
inline constexpr float stacked_repair = 0.075f, alone_to = 1.25f, stacked_from = 1.5f;
// The same in the first levels of a progressive set, where parts of a body that are side by side look like
// stacks.
inline constexpr float early_stacked_repair = 0.3f;
// Strata larger than this, in spacings, are torn.
inline constexpr float torn_extent = 2.2f;
// How far from their strata's first places samples are put: in spacings, and in extents of the stratum.
inline constexpr float torn_margin = 0.55f, box_margin = 0.125f;
// One sample in so many, of those that are too near in the end, leaves its stratum in a round: for a place of
// another one within so many spacings, one that is offered or one of so many new ones. The spacing there
// differs by at most this factor. In stacks of more sheets than this samples stay.
inline constexpr std::uint32_t few_leave = 64, leave_places = 24;
inline constexpr float leave_within = 2, leave_factor = 1.25f, max_leave_fullness = 3;
// The first levels of a progressive set, up to so many samples, have as many rounds of it as there may be:
// what is too near there is so in all prefixes that follow, and few samples cost nothing.
inline constexpr std::uint32_t early_samples = 512;
// A sweep visits the strata in so many groups at random; those of one group do not see each other move.
inline constexpr std::uint32_t groups = 16;
// Strata that one visits between two looks at the cancel token, where they take long.
inline constexpr std::size_t check_interval = 16;
// Limits of SpacingParameters.
inline constexpr std::uint32_t max_sweeps = 64, max_repairs = 64, max_leave_rounds = 8, max_hole_rounds = 4;

// The place that a sample which left its stratum has taken: `number` of stratum `host`.
struct TakenPlace {
  std::uint32_t host, number;
};
using TakenPlaces = std::map<std::uint32_t, TakenPlace>;  // by the sample's stratum

// The samples of one level: of strata that hold one already, and one for each of the others.
class SpacedLevel {
 public:
  // repair_below: what is too near, in spacings of the hexagonal lattice.
  SpacedLevel(const Strata& strata, const OfferedStrata& offered, int level, double repair_below,
              const Offer& offer, const CancelToken& cancel);

  // Fixes the sample of a stratum.
  void hold(std::uint32_t stratum, const Point& at) {
    put(stratum, at);
    number_[stratum] = held;
  }
  // Puts a sample into every stratum that has none, and spaces these out.
  void space_out();
  // By stratum: which of its places the sample has taken, or had when it left.
  std::vector<std::uint32_t> take_numbers() { return std::move(number_); }
  // Places of the samples that have left their strata.
  TakenPlaces take_places() { return std::move(taken_); }

 private:
  static constexpr std::uint32_t held = 0xFFFFFFFFu;
  bool is_early() const {
    return parameters_.leave_rounds > 0 && blocks_.count <= early_samples && blocks_.count < blocks_.leaves;
  }
  bool is_held(std::uint32_t stratum) const { return number_[stratum] == held; }
  Point sample_at(std::uint32_t stratum) const {
    return {sample_.x[stratum], sample_.y[stratum], sample_.z[stratum]};
  }
  void put(std::uint32_t stratum, const Point& at) {
    sample_.x[stratum] = at.x;
    sample_.y[stratum] = at.y;
    sample_.z[stratum] = at.z;
  }

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
    DipoleRows dipoles;
  };

  // The farthest that anything within the reach of a stratum, or within `distance` in its metric, is in
  // space.
  float in_space(std::uint32_t stratum, float distance) const {
    return metric_.empty() ? distance : distance * metric_[stratum].stretch;
  }
  // The places are far apart: the path jumps between pieces of the surface.
  bool is_torn(std::uint32_t stratum) const { return torn_[stratum] != 0; }
  // How far from the box of its places, or from one of these where it is torn, the sample is.
  float margin(std::uint32_t stratum) const {
    return is_torn(stratum) ? torn_margin * in_space(stratum, spacing_[stratum])
                            : box_margin * offered_.extent(stratum);
  }
  float reach_of(std::uint32_t stratum) const { return reach_[stratum] * spacing_[stratum]; }

  // ---- spaced_surroundings.cpp: what there is around each stratum, and how the surface attracts

  // Lists the strata around each one whose sample is to be chosen.
  void find_neighbors();
  struct Search;
  // How far from the box of a stratum, or of one of its places where it is torn, others can matter: its
  // sample stays within the margin.
  float around(std::uint32_t stratum) const { return in_space(stratum, reach_of(stratum)) + margin(stratum); }
  // Strata of a run along the path are neighbors: looks for what is near any of them in one go. False where
  // they are too far apart for that.
  bool find_candidates(std::uint32_t first, std::uint32_t last, Search& search) const;
  // Finds the strata around one; looks less far where there are too many.
  void look_around(std::uint32_t stratum, bool among_candidates, Search& search);
  void pick_candidates(std::uint32_t stratum, float distance, Search& search) const;
  // Whether a stratum has places within `distance` of a box.
  bool may_touch(std::uint32_t stratum, const PointBox& box, float distance, PointRows& places) const;
  // Whether a new place is so near the offered ones, which decide what is known of its surroundings.
  bool takes(std::uint32_t stratum, const Point& at, PointRows& places) const;
  void to_metric(std::uint32_t stratum, PointRows& points, std::size_t count) const;
  void places_to_metric(std::uint32_t stratum, Visit& visit) const {
    if (metric_.empty()) return;
    visit.in_space = visit.places;
    to_metric(stratum, visit.places, visit.places.size());
  }
  // Writes the places of a stratum, `other`, in the metric of another one where they stay: to copy a group
  // that was just written by parts would wait for these.
  void find_group(std::uint32_t stratum, std::uint32_t other, PointGroup& group) const {
    static_cast<PointMoments&>(group) =
        metric_.empty() ? moments_[other] : to_metric(stratum, moments_[other]);
    group.mass = mass_of(other);
  }
  PointMoments to_metric(std::uint32_t stratum, const PointMoments& moments) const;
  static float inverse_extent(const std::array<float, 6>& central);
  // Mass of a stratum, in samples.
  float mass_of(std::uint32_t stratum) const {
    return equal_
               ? 1.0f
               : static_cast<float>(double(blocks_.size(stratum)) * blocks_.count / double(blocks_.leaves));
  }
  // Of the places of each stratum.
  void find_moments();
  // What the surface attracts visit.places with, into visit.energy, and the share of their own stratum, into
  // visit.own; the places are put in its metric.
  void attract(std::uint32_t stratum, Visit& visit) const;
  // The attraction of a plane.
  float flat_attraction(std::uint32_t stratum) const;
  // The attraction of all offered places of strata, with what borders take away.
  void find_attraction(const std::vector<std::uint32_t>& strata);
  // visit_stratum(i, strata[i], visit) for all, with what is near it in visit.near.
  template <class VisitStratum>
  void visit_all(const std::vector<std::uint32_t>& strata, const VisitStratum& visit_stratum);
  void load_places(std::uint32_t stratum, Visit& visit) const {
    visit.places.resize(offered_.places());
    offered_.load(stratum, visit.places, 0);
  }
  // Of strata, as far as it is known.
  float mean_fullness(const std::vector<std::uint32_t>& strata) const;
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
    const float least = is_early() ? early_stacked_repair : stacked_repair;
    return repair_weight * (1 - (1 - least) * std::clamp(stack, 0.0f, 1.0f));
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
  float distance_among_sheets(std::uint32_t stratum, const std::vector<std::uint32_t>& near) const;
  // How thick the layer is that the strata within reach of one fill, in its metric. Of a plate that is wide
  // beside its thickness; of a ball nine tenths of the radius: twice the root of the harmonic mean of the
  // principal second moments.
  float thickness_around(std::uint32_t stratum, const std::vector<std::uint32_t>& near) const;
  // Weight of the short kernel while all samples move. It has no counterpart in the attraction: in stacks of
  // sheets, as both sides of a thin plate, it would drive samples out of them or to their rims.
  float sweep_weight(std::uint32_t stratum) const {
    const float alone = (stacked_fullness - fullness_[slot_of(stratum)]) / (stacked_fullness - flat_fullness);
    return short_weight * std::clamp(alone, 0.0f, 1.0f);
  }
  std::size_t slot_of(std::uint32_t stratum) const { return slot_.empty() ? stratum : slot_[stratum]; }

  // ---- spaced_level.cpp: how places are chosen, and in which order

  // The samples around a stratum, in its metric. Some are out of reach, where kernels are 0: to leave them
  // out costs more than to count them.
  void find_samples(std::uint32_t stratum, Visit& visit) const;
  // The same for those that were near it in the beginning; visit.near is not needed.
  void gather_samples(std::uint32_t stratum, Visit& visit) const;
  // Adds what these repel the places with.
  void repel(std::uint32_t stratum, float weight, Visit& visit) const;
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
        const Point sample = sample_at(visit.near[i]);
        const float there = length_in_metric(
            visit.near[i],
            {sample.x - visit.in_space.x[k], sample.y - visit.in_space.y[k], sample.z - visit.in_space.z[k]});
        const float distance =
            std::min(std::sqrt(squared), there * spacing_[stratum] / spacing_[visit.near[i]]);
        if (distance < within) visit_pair(k, i, distance);
      }
  }
  // Samples that are too far away to repel any place by itself move it together.
  void find_far_field();
  // Adds what they repel the places with, and what their strata attract them with.
  void repel_from_afar(std::uint32_t stratum, Visit& visit) const;
  float length_in_metric(std::uint32_t stratum, const Point& v) const;
  // The place of its stratum where the sample has the least energy; among places that are equally good, it
  // stays.
  Choice choose(std::uint32_t stratum, Visit& visit) const;
  // Draws new places, `first` and the numbers after it, into visit.draws and visit.points.
  void draw_new(std::uint32_t stratum, std::uint32_t first, std::uint32_t count, Visit& visit) const;
  // The same among new places, `first` and the numbers after it; the sample may stay.
  Choice choose_new(std::uint32_t stratum, std::uint32_t first, std::uint32_t count, float weight,
                    Visit& visit) const;
  static void ask_about(const Point& at, Visit& visit) {
    visit.places.resize(0);
    visit.places.push_back(at.x, at.y, at.z);
  }
  // The sample of a stratum as the only place, and those around it, in its metric.
  void look_at_sample(std::uint32_t stratum, Visit& visit) const;
  void move(std::uint32_t stratum, const Choice& choice) {
    far_.move(stratum, sample_at(stratum), choice.at);
    number_[stratum] = choice.number;
    put(stratum, choice.at);
  }
  // The number of the first new place that a pass of repairs or of settling offers.
  std::uint32_t first_number(std::uint32_t pass) const;
  // Moves the samples around the places where those that have left their strata were and are: they close the
  // gaps, and make room for what is still too near.
  void settle(std::uint32_t pass, bool is_last);
  // The samples of a pass move in groups, and those of the last one in one turn, so that no two of them miss
  // each other.
  template <class Choose>
  void move_in_pass(const std::vector<std::uint32_t>& strata, std::uint32_t pass, bool is_last,
                    const Choose& choose);
  // Moves the samples of strata one after the other to what choose(stratum, visit) returns.
  template <class Choose>
  void visit_in_turn(const std::vector<std::uint32_t>& strata, const Choose& choose);
  // The same in groups at random, other ones in each turn: in the order of the path all samples would drift
  // one way, and the integrals of smooth functions would no longer converge as fast. Within a group all
  // choose, then all move.
  template <class Choose>
  void visit_groups(const std::vector<std::uint32_t>& strata, std::uint32_t turn, const Choose& choose);
  // Strata by their groups; begin: where each of these begins.
  std::vector<std::uint32_t> grouped(const std::vector<std::uint32_t>& strata, std::uint32_t turn,
                                     std::array<std::size_t, groups + 1>& begin) const;

  // ---- spaced_repairs.cpp: those that are too near to another one

  // Those whose sample is too near to another one, the nearest first.
  std::vector<std::uint32_t> too_near(const std::vector<std::uint32_t>& strata) const;
  // The first of these, no more than a share of all strata: where samples cannot be so far apart, as in
  // stacked sheets, not all are moved again and again.
  std::vector<std::uint32_t> first_of(std::vector<std::uint32_t> strata, double share) const;
  // What a pass of repairs moves, ascending: those, and what add_partners adds.
  std::vector<std::uint32_t> to_repair(const std::vector<std::uint32_t>& strata, std::uint32_t pass) const;
  // Adds the strata whose samples lie within so many least distances of theirs: of what is too near, these
  // may find a place where those do not; and others may make room.
  void add_partners(float within, std::vector<std::uint32_t>& strata) const;
  // Moves samples that are too near to another one out of their strata, as if one after the other: to the
  // nearest place around with room enough, or else to the one with the most room. Those in larger stacks
  // stay. Of many strata a batch looks for places at once; those that see one leave before them look again.
  void leave_strata(const std::vector<std::uint32_t>& strata, float max_fullness);
  // Where the sample of a stratum goes that leaves it; nothing: it stays.
  struct Leaving {
    TakenPlace place;
    Point at;
  };
  std::optional<Leaving> find_place(std::uint32_t stratum, Visit& visit) const;
  // Whether find_place looks at any of these.
  bool sees_any(std::uint32_t stratum, const std::vector<std::uint32_t>& others, Visit& visit) const;
  // Asks about a place of the sample of a stratum, and those around it: those that the strata have offered,
  // or new ones. Farther away not all samples are known.
  void offer_around(std::uint32_t stratum, const Point& sample, bool anew, Visit& visit) const;
  // At borders there seems to be room: rims of plates would fill.
  bool may_host(std::uint32_t host, std::uint32_t stratum) const;
  // Adds the strata, which may be farther away, whose samples have come into this one or one of `near`, which
  // are ascending.
  void add_hosted(std::uint32_t stratum, std::vector<std::uint32_t>& near) const;
  void read_near(std::uint32_t stratum, std::vector<std::uint32_t>& near) const {
    near_.read(stratum, near);
    add_hosted(stratum, near);
  }
  // The stratum where the sample of this one is.
  std::uint32_t host_of(std::uint32_t stratum) const;
  void leave(std::uint32_t stratum, const Leaving& leaving);
  // By place, into visit.energy: the distance to the nearest sample over what is too near, at most 1.
  void find_room(std::uint32_t stratum, Visit& visit) const;
  // Of the places with the most room, the nearest to the first, where the sample is.
  static std::size_t roomiest(const Visit& visit);

  // ---- spaced_holes.cpp: the largest holes between them

  struct Hole;
  // Moves samples beside the largest holes into these, one after the other, where that opens no hole as large
  // and brings no two samples too near to each other.
  void fill_holes();
  // Its sample may move, and lies on a single sheet.
  bool can_fill(std::uint32_t stratum) const {
    return !is_held(stratum) && fullness_[slot_of(stratum)] <= alone_to;
  }
  // The places which may be in holes, of a stratum and of those beside it along the path whose samples were
  // placed before, and which do not know what is around them.
  void find_probes(std::uint32_t stratum, std::vector<Hole>& probes, Visit& visit) const;
  // The farthest of visit.places from all visit.samples; by place, the distances in visit.energy.
  Hole find_hole(std::uint32_t stratum, Visit& visit) const;
  // From a place to the point around it that is as far from three samples, where that is farther from all of
  // visit.samples, and beside the surface.
  void enlarge(Hole& hole, Visit& visit) const;
  bool is_beside_surface(const Hole& hole, Visit& visit) const;
  struct Filling;
  // Returns the largest hole that this opens.
  Hole fill(const Hole& hole, Visit& visit);
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
                    std::vector<Filling>& fillings) const;
  // The largest hole that is there where a sample was when it has moved.
  Hole opened_by(const Filling& filling, Visit& visit);

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
  std::vector<std::uint8_t> torn_;
  StratumLists near_;
  std::vector<PointMoments> moments_;
  std::vector<std::uint32_t> slot_;  // by stratum: among those without a held sample; empty where all are
  PackedRows attraction_{0, 0};      // by slot: of all offered places
  std::vector<float> fullness_;      // by slot: attraction over that of a flat surface,
  std::vector<float> around_;        // and its mean over the strata around,
  std::vector<float> apart_;         // distance_among_sheets; empty where distance_on_sheets holds
  FarField far_;
  PointRows sample_;                   // by stratum; with max_run behind them
  std::vector<std::uint32_t> number_;  // of the place of the sample, or held
  TakenPlaces taken_;
  std::unordered_multimap<std::uint32_t, std::uint32_t> hosted_;  // by host: the strata of such samples
  std::vector<std::uint8_t> is_host_;                             // may be one; empty where none is
};

}  // namespace meander::spaced
