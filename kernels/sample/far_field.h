// Internal to kernels/sample: how samples beyond the reach of the kernel move each other (docs/METHODS.md
// 7.5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/sample/kernel_sums.h"
#include "kernels/sample/offered_places.h"
#include "kernels/sample/stratum_lists.h"

namespace meander::spaced {

// The field beyond the reach of the kernel, as if that ended at far_reach: what strata attract and their
// samples repel with. A stratum and its sample are, far away, a dipole, the way of the sample from the mean
// of its stratum; dipoles of `run_strata` strata along the path are one. A run with a stratum that does not
// take part has no part in the field at all.
class FarField {
 public:
  static constexpr std::uint32_t run_strata = 4;
  // In spacings.
  static constexpr float far_reach = 7;
  // Kernels end, and the far one begins, within so many spacings about their reach: the extent of runs, whose
  // dipoles stand for what lies there as a whole.
  static constexpr float ramp = 1.25f;

  FarField() = default;  // there is none
  // takes_part: by stratum. The samples are in the means of their strata until `move` says where they are.
  FarField(std::span<const PointMoments> moments, std::span<const float> spacing,
           const std::function<bool(std::uint32_t)>& takes_part, const CancelToken& cancel);

  bool reaches(std::uint32_t stratum) const {
    return !takes_part_.empty() && takes_part_[stratum / run_strata] != 0;
  }
  void move(std::uint32_t stratum, const Point& from, const Point& to) {
    if (takes_part_.empty()) return;
    const std::uint32_t run = stratum / run_strata;
    dipoles_.way_x[run] += to.x - from.x;
    dipoles_.way_y[run] += to.y - from.y;
    dipoles_.way_z[run] += to.z - from.z;
  }

  // Adds to the energy of places of a stratum that the field reaches what they have in it, up to the same for
  // all. own: the sample of the stratum, which does not count, from its mean; share: of the attraction of
  // the stratum itself, 0..1. O(runs around + places).
  void add(std::uint32_t stratum, const PointMoments& moments, float spacing, const std::array<float, 3>& own,
           float share, const PointRows& places, DipoleRows& scratch, std::span<float> energy) const;

 private:
  std::array<float, 3> middle(std::uint32_t run) const {
    return {dipoles_.x[run], dipoles_.y[run], dipoles_.z[run]};
  }

  DipoleRows dipoles_;  // by run, in units of the points; with max_run behind them
  std::vector<std::uint8_t> takes_part_;
  StratumLists near_{0, 1};
};

}  // namespace meander::spaced
