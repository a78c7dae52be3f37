#include "kernels/query/closing_cones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/vector3.h"

namespace meander {

ClosingCones closing_cones(std::span<const double> boundary) {
  const std::size_t edges = boundary.size() / 7;
  const auto end_at = [&](std::size_t end) {
    const double* const at = &boundary[7 * (end / 2) + 3 * (end % 2)];
    return std::array<double, 3>{at[0], at[1], at[2]};
  };
  // Ends at equal positions, side by side.
  std::vector<std::uint32_t> order(2 * edges);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const std::array<double, 3> at_a = end_at(a), at_b = end_at(b);
    return at_a != at_b ? at_a < at_b : a < b;
  });
  DisjointSets holes(edges);
  for (std::size_t i = 1; i < order.size(); ++i)
    if (end_at(order[i]) == end_at(order[i - 1])) holes.join(order[i] / 2, order[i - 1] / 2);

  // By the first edge of a hole: the moment of its edges, and their length.
  std::vector<std::array<double, 4>> middle(edges, std::array<double, 4>{});
  for (std::uint32_t e = 0; e < edges; ++e) {
    const std::array<double, 3> a = end_at(2 * std::size_t{e}), b = end_at(2 * std::size_t{e} + 1);
    const double length = norm({b[0] - a[0], b[1] - a[1], b[2] - a[2]});
    std::array<double, 4>& of = middle[holes.find(e)];
    for (std::size_t k = 0; k < 3; ++k) of[k] += 0.5 * length * (a[k] + b[k]);
    of[3] += length;
  }
  // The edges hole by hole.
  std::vector<std::uint32_t> by_hole(edges);
  std::iota(by_hole.begin(), by_hole.end(), 0u);
  std::sort(by_hole.begin(), by_hole.end(), [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t of_a = holes.find(a), of_b = holes.find(b);
    return of_a != of_b ? of_a < of_b : a < b;
  });
  ClosingCones cones;
  const auto add = [&](double x, double y, double z) {
    cones.x.push_back(x);
    cones.y.push_back(y);
    cones.z.push_back(z);
    return static_cast<std::uint32_t>(cones.x.size() - 1);
  };
  std::uint32_t tip = 0;
  for (const std::uint32_t e : by_hole) {
    if (holes.is_representative(e)) {
      const auto& [x, y, z, length] = middle[e];
      tip = add(x / length, y / length, z / length);
      cones.hole_begin.push_back(static_cast<std::uint32_t>(cones.triangles.size() / 3));
    }
    const std::array<double, 3> a = end_at(2 * std::size_t{e}), b = end_at(2 * std::size_t{e} + 1);
    std::array<std::uint32_t, 2> ends = {add(a[0], a[1], a[2]), add(b[0], b[1], b[2])};
    const double times = boundary[7 * std::size_t{e} + 6];
    if (times > 0) std::swap(ends[0], ends[1]);
    for (double left = std::abs(times); left > 0.5; --left)
      cones.triangles.insert(cones.triangles.end(), {ends[0], ends[1], tip});
  }
  cones.hole_begin.push_back(static_cast<std::uint32_t>(cones.triangles.size() / 3));
  return cones;
}

}  // namespace meander
