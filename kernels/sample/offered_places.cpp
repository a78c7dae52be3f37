#include "kernels/sample/offered_places.h"

#include "kernels/core/parallel.h"

namespace meander::spaced {

namespace {

// Distances below this, in units of the points, are not told apart: their squares would leave the range of
// float.
constexpr float min_spacing = 1e-15f;

}  // namespace

OfferedStrata offer_leaves(const Strata& strata, const Offer& offer, const CancelToken& cancel) {
  const std::uint32_t candidates = offer.parameters.candidates;
  OfferedStrata leaves(strata.count(), candidates, strata.is_isotropic());
  const double mass = strata.measure() / strata.count();
  parallel_blocks(strata.count(), draw_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    std::vector<PointDraw> draws(candidates);
    std::vector<StratumPoint> points(candidates);
    std::vector<std::array<float, 3>> at(candidates);
    for (std::size_t leaf = begin; leaf < end; ++leaf) {
      for (std::uint32_t k = 0; k < candidates; ++k)
        draws[k] =
            offer.draw({static_cast<std::uint32_t>(offer.levels.last), static_cast<std::uint32_t>(leaf), k});
      strata.draw(draws, points);
      // The area is the mass over the harmonic mean of the density at points that are distributed by mass.
      double per_mass = 0;
      for (std::size_t k = 0; k < candidates; ++k) {
        at[k] = points[k].at;
        per_mass += 1 / points[k].density;
      }
      leaves.places.store(leaf, at);
      leaves.spacing[leaf] =
          std::max(static_cast<float>(std::sqrt(mass * per_mass / candidates)), min_spacing);
      if (!leaves.metric.empty()) leaves.metric[leaf] = strata.metric(points[0]);
    }
  });
  return leaves;
}

OfferedStrata offer_blocks(const OfferedStrata& leaves, int level, const Offer& offer,
                           const CancelToken& cancel) {
  const LeafBlocks blocks = offer.levels.blocks(level);
  const std::uint32_t candidates = offer.parameters.candidates;
  OfferedStrata result(blocks.count, candidates, leaves.metric.empty());
  parallel_blocks(blocks.count, draw_block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    std::vector<std::array<float, 3>> at(candidates);
    for (std::size_t s = begin; s < end; ++s) {
      const auto stratum = static_cast<std::uint32_t>(s);
      double area = 0;
      for (std::uint32_t k = 0; k < candidates; ++k) {
        const PlaceName name = offer.in_leaf({static_cast<std::uint32_t>(level), stratum, k});
        const Point place = leaves.places.place(name.stratum, name.number);
        at[k] = {place.x, place.y, place.z};
        area += double(leaves.spacing[name.stratum]) * leaves.spacing[name.stratum];
        if (k == 0 && !leaves.metric.empty()) result.metric[s] = leaves.metric[name.stratum];
      }
      result.places.store(s, at);
      // Strata of a level differ by at most one leaf: the spacing is that of its samples.
      result.spacing[s] = static_cast<float>(std::sqrt(area / candidates * blocks.leaves / blocks.count));
    }
  });
  return result;
}

}  // namespace meander::spaced
