// Boundary-first flattening (Sawhney and Crane 2017, "Boundary first flattening", ACM TOG 37(1)).
#pragma once

#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/work_budget.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

struct ConformalMap {
  // False without a factor or a budget for it; the other members mean nothing then.
  bool finite = false;
  std::vector<double> u, v;                // V, with boundary lengths close to those of the disk
  std::vector<double> log_scale;           // V, 0 on the boundary
  std::vector<std::uint32_t> elimination;  // for IntrinsicDisk::elimination of a similar disk
  double turning = 0;                      // sum of target turning angles, 2 pi up to rounding
};

// The discrete conformal map of least area distortion: log scale 0 on the boundary. The boundary polygon is
// closed by a least-squares correction of its lengths; both coordinates are extended harmonically with the
// same factorization. Does not check for flips. Lengths must be mollified. O(V^1.5), out of `budget` where
// there is one.
ConformalMap flatten_boundary_first(const IntrinsicDisk& disk, const CancelToken& cancel = {},
                                    WorkBudget* budget = nullptr);

}  // namespace meander
