// Boundary-first flattening (Sawhney and Crane 2017, "Boundary first flattening", ACM TOG 37(1)).
#pragma once

#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/work_budget.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

struct ConformalMap {
  bool finite = false;                     // false: no factor, or no budget for it; the others mean nothing
  std::vector<double> u, v;                // V, lengths on the boundary close to those of the disk
  std::vector<double> log_scale;           // V, 0 on the boundary
  std::vector<std::uint32_t> elimination;  // for IntrinsicDisk::elimination of a like disk
  double turning = 0;                      // sum of the boundary's target turning angles, 2 pi up to rounding
};

// The discrete conformal map of least area distortion: log scale 0 on the boundary. The boundary polygon is
// closed by a least-squares correction of its lengths, both coordinates are extended harmonically with the
// one factorisation. Does not check for flips. Lengths must be mollified. O(V^1.5), out of
// `budget` where there is one.
ConformalMap flatten_boundary_first(const IntrinsicDisk& disk, const CancelToken& cancel = {},
                                    WorkBudget* budget = nullptr);

}  // namespace meander
