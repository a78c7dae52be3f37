#include "kernels/sample/spaced_samples.h"

#include <algorithm>
#include <stdexcept>

#include "kernels/core/check_range.h"
#include "kernels/core/parallel.h"
#include "kernels/sample/offered_places.h"
#include "kernels/sample/sequence.h"
#include "kernels/sample/spaced_level.h"

namespace meander {
using namespace spaced;

namespace {

// The first level of a progressive set has 2^6 samples.
constexpr int first_level = 6;
// The last two levels of a progressive set are one where the last has fewer strata than this times those of
// the one before.
constexpr double as_one_below = 1.6;

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
  // samples in the file; empty, as on no level of a progressive set: all along the path.
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
      return {8, 2, 16, 16, 0.6, 0.54, 0.2, 2, 0};
    case SpacingKind::best:
      return {32, 5, 16, 32, 0.71, 0.62, 0.2, 4};
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
