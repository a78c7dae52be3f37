// Triangulation of one polygon.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/vector3.h"

namespace meander {

// Splits a polygon with K >= 3 corners (positions in order) into K - 2 triangles of corner positions 0 .. K -
// 1: a fan from corner 0 when the polygon, projected along its Newell normal, is convex, ear clipping when it
// is not. Appends 3 (K - 2) entries to `triangles` and returns true when ears were clipped. A polygon without
// a normal (zero area) is fanned, and so is the rest of one that crosses itself when no ear is left: the
// result always covers every corner. O(K) when convex, otherwise as clip_ears, whose exceptions pass.
bool triangulate_polygon(std::span<const Vector3> corners, std::vector<std::uint32_t>& triangles,
                         const CancelToken& cancel = {});

}  // namespace meander
