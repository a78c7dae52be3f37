#include "kernels/query/boundary_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "kernels/query/curve_order.h"
#include "kernels/query/lanes.h"

namespace meander {

namespace {

// Nothing is trusted nearer to an edge than this, nor nearer than so many times its length.
constexpr double nearest_edge = 1e-9, nearest_share = 1e-5;
// Of the distance of the nearest edge.
constexpr double largest_share = 1.0 / 3;
// Blocks are far from so many times their radius on.
constexpr double far_block = 6;
// Where there is no edge.
constexpr double nowhere = 1e30;

template <class Doubles>
MEANDER_INLINE double sum_of(const Doubles& v) {
  double value[4];
  lanes::store(v, value);
  return (value[0] + value[1]) + (value[2] + value[3]);
}

// Sums over edges.
template <class Doubles>
struct Sums {
  Doubles x, y, z;
  Doubles second;     // bounds of second derivatives
  Doubles uncertain;  // of errors of the gradient
  Doubles nearest;    // squared distance
};

template <class Doubles>
MEANDER_INLINE void add_edges(const BoundaryField::Edges& edges, const double (&point)[3],
                              Sums<Doubles>& sums) {
  const auto zero = lanes::all<Doubles>(0.0), one = lanes::all<Doubles>(1.0),
             least = lanes::all<Doubles>(1e-300);
  const Doubles ax = lanes::load<Doubles>(edges.end[0].data()) - point[0],
                ay = lanes::load<Doubles>(edges.end[1].data()) - point[1],
                az = lanes::load<Doubles>(edges.end[2].data()) - point[2],
                bx = lanes::load<Doubles>(edges.end[3].data()) - point[0],
                by = lanes::load<Doubles>(edges.end[4].data()) - point[1],
                bz = lanes::load<Doubles>(edges.end[5].data()) - point[2],
                times = lanes::load<Doubles>(edges.times.data());
  const Doubles cx = ay * bz - az * by, cy = az * bx - ax * bz, cz = ax * by - ay * bx;
  const Doubles aa = ax * ax + ay * ay + az * az, bb = bx * bx + by * by + bz * bz,
                ab = ax * bx + ay * by + az * bz;
  const Doubles a = lanes::root(aa), b = lanes::root(bb), product = a * b;
  // Squared distance of the nearest place on the edge.
  const Doubles squared_length = aa + bb - 2.0 * ab;
  Doubles along = lanes::larger((aa - ab) / lanes::larger(squared_length, least), zero);
  along = lanes::select(along > one, one, along);
  const Doubles squared =
      lanes::larger(aa - along * (2.0 * (aa - ab) - along * squared_length),
                    (nearest_share * nearest_share) * squared_length + nearest_edge * nearest_edge);
  sums.nearest = lanes::select(squared < sums.nearest, squared, sums.nearest);
  // (a x b) (|a| + |b|) / (|a| |b| (|a| |b| + a . b)), without the difference of what is nearly equal.
  const Doubles square = cx * cx + cy * cy + cz * cz;
  const Doubles opposite = (product - ab) / lanes::larger(square, least),
                together = 1.0 / lanes::larger(product + ab, least);
  const Doubles factor = times * (a + b) / product * lanes::select(ab < zero, opposite, together);
  sums.x = sums.x + factor * cx;
  sums.y = sums.y + factor * cy;
  sums.z = sums.z + factor * cz;
  const Doubles length = lanes::load<Doubles>(edges.length.data()), size = lanes::larger(times, zero - times);
  const Doubles near_bound = 4.0 * size / squared,
                far_bound = 2.0 * length / (squared * lanes::root(squared));
  sums.second = sums.second + lanes::select(near_bound < far_bound, near_bound, far_bound);
}

// Adds the blocks that are far, and returns a bit for each of the others.
template <class Doubles>
MEANDER_INLINE unsigned add_far_blocks(const BoundaryField::Blocks& blocks, const double (&point)[3],
                                       Sums<Doubles>& sums) {
  const auto zero = lanes::all<Doubles>(0.0);
  const Doubles x = point[0] - lanes::load<Doubles>(blocks.center[0].data()),
                y = point[1] - lanes::load<Doubles>(blocks.center[1].data()),
                z = point[2] - lanes::load<Doubles>(blocks.center[2].data()),
                u = lanes::load<Doubles>(blocks.current[0].data()),
                v = lanes::load<Doubles>(blocks.current[1].data()),
                w = lanes::load<Doubles>(blocks.current[2].data()),
                radius = lanes::load<Doubles>(blocks.radius.data());
  const Doubles squared = x * x + y * y + z * z;
  const auto far = squared > lanes::load<Doubles>(blocks.far.data());
  const Doubles distance = lanes::root(squared),
                per_cube = lanes::select(far, 1.0 / (squared * distance), zero);
  sums.x = sums.x + per_cube * (v * z - w * y);
  sums.y = sums.y + per_cube * (w * x - u * z);
  sums.z = sums.z + per_cube * (u * y - v * x);
  const Doubles nearest = distance - radius;
  const Doubles second = lanes::select(
      far, 2.0 * lanes::load<Doubles>(blocks.length.data()) / (nearest * nearest * nearest), zero);
  sums.second = sums.second + second;
  sums.uncertain = sums.uncertain + radius * second;
  sums.nearest = lanes::select(far & (nearest * nearest < sums.nearest), nearest * nearest, sums.nearest);
  double is_far[BoundaryField::lanes];
  lanes::store(lanes::select(far, lanes::all<Doubles>(1.0), zero), is_far);
  unsigned near = 0;
  for (std::size_t k = 0; k < BoundaryField::lanes; ++k) near |= is_far[k] > 0 ? 0u : 1u << k;
  return near;
}

template <class Doubles>
MEANDER_INLINE WindingChange change_in_lanes(const BoundaryField& field, Vector3 point, double tolerance) {
  const auto zero = lanes::all<Doubles>(0.0);
  const double at[3] = {point.x, point.y, point.z};
  Sums<Doubles> sums{zero, zero, zero, zero, zero, lanes::all<Doubles>(nowhere)};
  for (std::size_t b = 0; b < field.blocks.size(); ++b)
    for (unsigned near = add_far_blocks(field.blocks[b], at, sums); near != 0; near &= near - 1) {
      const std::size_t block = BoundaryField::lanes * b + static_cast<std::size_t>(std::countr_zero(near));
      for (std::size_t e = 0; e < BoundaryField::edges_in_block; ++e)
        add_edges(field.edges[BoundaryField::edges_in_block * block + e], at, sums);
    }
  constexpr double per_sphere = 0.25 * std::numbers::inv_pi;
  WindingChange change;
  change.gradient = per_sphere * Vector3{sum_of(sums.x), sum_of(sums.y), sum_of(sums.z)};
  double nearest[BoundaryField::lanes];
  lanes::store(sums.nearest, nearest);
  const double distance = std::sqrt(*std::min_element(nearest, nearest + BoundaryField::lanes));
  // Within a third of the distance second derivatives are at most (3 / 2)^3 times as large.
  const double second = per_sphere * sum_of(sums.second) * 27 / 8,
               uncertain = per_sphere * sum_of(sums.uncertain);
  // second r^2 / 2 + uncertain r = tolerance
  const double reach =
      2 * tolerance / (uncertain + std::sqrt(uncertain * uncertain + 2 * second * tolerance));
  change.radius = std::min(largest_share * distance, reach);
  return change;
}

WindingChange change_by_pairs(const BoundaryField& field, Vector3 point, double tolerance) {
  return change_in_lanes<lanes::Pairs::Doubles>(field, point, tolerance);
}
MEANDER_TARGET("avx2")
WindingChange change_avx2(const BoundaryField& field, Vector3 point, double tolerance) {
  return change_in_lanes<lanes::Wide::Doubles>(field, point, tolerance);
}

}  // namespace

BoundaryField build_boundary_field(std::span<const double> boundary) {
  constexpr std::size_t lanes = BoundaryField::lanes, block = lanes * BoundaryField::edges_in_block;
  const std::size_t count = boundary.size() / 7, blocks = (count + block - 1) / block;
  std::vector<double> middles;
  middles.reserve(3 * count);
  for (std::size_t e = 0; e < count; ++e)
    for (std::size_t k = 0; k < 3; ++k)
      middles.push_back(0.5 * (boundary[7 * e + k] + boundary[7 * e + 3 + k]));
  const std::vector<std::uint32_t> order = order_along_curve(middles);
  BoundaryField field;
  field.edges.resize(blocks * BoundaryField::edges_in_block);
  field.blocks.resize((blocks + lanes - 1) / lanes);
  for (BoundaryField::Edges& edges : field.edges) {
    edges = {};
    // Far away from all points, so that nothing is divided by 0.
    edges.end[0].fill(nowhere);
    edges.end[3].fill(2 * nowhere);
  }
  for (BoundaryField::Blocks& of : field.blocks) {
    of = {};
    of.center[0].fill(nowhere);
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t begin = b * block, end = std::min(count, begin + block);
    const auto at = [&](std::size_t i, std::size_t k) { return boundary[7 * std::size_t{order[i]} + k]; };
    std::array<double, 3> center{}, current{};
    double all = 0, radius = 0;
    for (std::size_t i = begin; i < end; ++i) {
      BoundaryField::Edges& edges = field.edges[i / lanes];
      const double length =
          std::abs(at(i, 6)) * norm({at(i, 3) - at(i, 0), at(i, 4) - at(i, 1), at(i, 5) - at(i, 2)});
      for (std::size_t k = 0; k < 6; ++k) edges.end[k][i % lanes] = at(i, k);
      edges.times[i % lanes] = at(i, 6);
      edges.length[i % lanes] = length;
      all += length;
      for (std::size_t k = 0; k < 3; ++k) {
        center[k] += (at(i, k) + at(i, 3 + k)) / (2 * static_cast<double>(end - begin));
        current[k] += at(i, 6) * (at(i, 3 + k) - at(i, k));
      }
    }
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = 0; k < 6; k += 3)
        radius = std::max(radius,
                          norm({at(i, k) - center[0], at(i, k + 1) - center[1], at(i, k + 2) - center[2]}));
    BoundaryField::Blocks& of = field.blocks[b / lanes];
    for (std::size_t k = 0; k < 3; ++k) {
      of.center[k][b % lanes] = center[k];
      of.current[k][b % lanes] = current[k];
    }
    of.radius[b % lanes] = radius;
    of.far[b % lanes] = far_block * far_block * radius * radius;
    of.length[b % lanes] = all;
  }
  return field;
}

WindingChange winding_change(const BoundaryField& field, Vector3 point, double tolerance,
                             InstructionSet set) {
  return takes_avx2(set) ? change_avx2(field, point, tolerance) : change_by_pairs(field, point, tolerance);
}

}  // namespace meander
