// Intrinsic Delaunay triangulation by edge flips (Bobenko and Springborn 2007; Fisher et al. 2006).
#pragma once

#include <cstdint>

#include "kernels/core/cancel.h"
#include "kernels/solve/intrinsic_disk.h"

namespace meander {

// Flips interior edges until every cotangent weight is non-negative (up to rounding): connectivity and
// lengths of the surface change in place; vertices, boundary and geometry stay. Returns the number of flips
// and stops after 50 flips an edge, because rounding could make an edge flip back and forth indefinitely.
// Throws timeout.
std::uint32_t make_intrinsic_delaunay(IntrinsicDisk& disk, const CancelToken& cancel = {});

}  // namespace meander
