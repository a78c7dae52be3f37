#include "kernels/solve/intrinsic_delaunay.h"

#include <algorithm>
#include <cmath>

namespace meander {

namespace {

// Cotangent of the angle opposite half-edge h.
double opposite_cotangent(const IntrinsicDisk& disk, std::uint32_t h) {
  const double a = disk.length[h], b = disk.length[next_half_edge(h)], c = disk.length[previous_half_edge(h)];
  const double longest = std::max({a, b, c});
  const double area4 = std::max(4 * area_from_lengths(a, b, c), 1e-12 * longest * longest);
  return (b * b + c * c - a * a) / area4;
}

bool should_flip(const IntrinsicDisk& disk, std::uint32_t h) {
  const std::uint32_t other = disk.opposite[h];
  if (other == no_index || other / 3 == h / 3) return false;
  const double a = opposite_cotangent(disk, h), b = opposite_cotangent(disk, other);
  return a + b < -1e-9 * (1 + std::abs(a) + std::abs(b));
}

// Length of the other diagonal of the two triangles beside half-edge h, unfolded into the plane.
double diagonal_length(const IntrinsicDisk& disk, std::uint32_t h) {
  const auto apex = [&](double base, double from_start, double from_end, double& x, double& y) {
    x = 0.5 * (base + (from_start - from_end) * (from_start + from_end) / base);
    y = 2 * area_from_lengths(base, from_start, from_end) / base;
  };
  const std::uint32_t o = disk.opposite[h];
  double cx, cy, dx, dy;
  apex(disk.length[h], disk.length[previous_half_edge(h)], disk.length[next_half_edge(h)], cx, cy);
  apex(disk.length[h], disk.length[next_half_edge(o)], disk.length[previous_half_edge(o)], dx, dy);
  return std::sqrt((cx - dx) * (cx - dx) + (cy + dy) * (cy + dy));
}

// Replaces edge a-b of triangles (a, b, c) and (b, a, d) by c-d: they become (d, c, a) and (c, d, b).
void flip_edge(IntrinsicDisk& disk, std::uint32_t h, double length) {
  const std::uint32_t o = disk.opposite[h];
  const std::uint32_t hn = next_half_edge(h), hp = previous_half_edge(h);
  const std::uint32_t on = next_half_edge(o), op = previous_half_edge(o);
  const std::uint32_t a = disk.triangles[h], b = disk.triangles[o], c = disk.triangles[hp],
                      d = disk.triangles[op];
  const std::uint32_t t = h / 3 * 3, s = o / 3 * 3;
  const std::uint32_t old_slot[4] = {hp, on, op, hn}, new_slot[4] = {t + 1, t + 2, s + 1, s + 2};
  double side[4];
  std::uint32_t across[4];
  for (int k = 0; k < 4; ++k) {
    side[k] = disk.length[old_slot[k]];
    across[k] = disk.opposite[old_slot[k]];
    for (int j = 0; j < 4; ++j)
      if (across[k] == old_slot[j]) {  // the two triangles touch along another edge too
        across[k] = new_slot[j];
        break;
      }
  }
  const std::uint32_t corner[6] = {d, c, a, c, d, b};
  for (int k = 0; k < 3; ++k) {
    disk.triangles[t + k] = corner[k];
    disk.triangles[s + k] = corner[3 + k];
  }
  disk.length[t] = disk.length[s] = length;
  disk.opposite[t] = s;
  disk.opposite[s] = t;
  for (int k = 0; k < 4; ++k) {
    disk.length[new_slot[k]] = side[k];
    disk.opposite[new_slot[k]] = across[k];
    if (across[k] != no_index) disk.opposite[across[k]] = new_slot[k];
  }
}

}  // namespace

std::uint32_t make_intrinsic_delaunay(IntrinsicDisk& disk, const CancelToken& cancel) {
  std::vector<std::uint32_t> stack;
  for (auto h = static_cast<std::uint32_t>(disk.opposite.size()); h-- > 0;)
    if (disk.opposite[h] != no_index && disk.opposite[h] > h) stack.push_back(h);
  const std::size_t limit = 50 * std::max<std::size_t>(stack.size(), 1);
  std::uint32_t flips = 0;
  while (!stack.empty() && flips < limit) {
    const std::uint32_t h = stack.back();
    stack.pop_back();
    if (!should_flip(disk, h)) continue;
    const double length = diagonal_length(disk, h);
    if (!(length > 0)) continue;
    const std::uint32_t t = h / 3 * 3, s = disk.opposite[h] / 3 * 3;
    flip_edge(disk, h, length);
    if ((++flips & 0xFFFF) == 0) cancel.check();
    for (const std::uint32_t side : {t + 1, t + 2, s + 1, s + 2}) stack.push_back(side);
  }
  return flips;
}

}  // namespace meander
