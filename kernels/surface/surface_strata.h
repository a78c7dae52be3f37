// The strata of a parametric surface: equal intervals of its measure along the curve.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/core/vector3.h"
#include "kernels/sample/spaced_samples.h"
#include "kernels/surface/patch_tree.h"
#include "kernels/surface/surface_measure.h"

namespace meander {

// `first` and `second` of its points are coordinates in the curve's square. Measure and tree must outlive the
// object.
class SurfaceStrata : public Strata {
 public:
  SurfaceStrata(const SurfaceMeasure& measure, const PatchTree& tree, std::uint32_t count, RandomKey key);
  std::uint32_t count() const override { return count_; }
  double measure() const override { return tree_.total() / (unit_ * unit_); }
  void draw(std::span<const PointDraw> draws, std::span<StratumPoint> points) const override;

  // The position of the middle of every stratum in the measure, in [0, 1).
  std::vector<double> middles() const;

 private:
  const SurfaceMeasure& measure_;
  const PatchTree& tree_;
  std::uint32_t count_;
  RandomKey key_;
  double shift_;  // of the first interval, in intervals
  Vector3 center_;
  double unit_;  // of the points
};

}  // namespace meander
