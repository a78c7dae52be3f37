#include "kernels/sample/kernel_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace meander {

namespace {

// Eight places at a time, in vectors that the compiler maps to the instructions at hand: the same operations
// in the same order, whatever these are.
constexpr std::size_t lanes = 8;
using Floats = float __attribute__((vector_size(4 * lanes)));
using Words = std::int32_t __attribute__((vector_size(4 * lanes)));

// A row from `first` on; lanes beyond its end repeat the last place.
template <class Vector, class Value>
MEANDER_INLINE void load(Vector& vector, std::span<const Value> row, std::size_t first) {
  Value values[lanes];
  for (std::size_t k = 0; k < lanes; ++k) values[k] = row[std::min(first + k, row.size() - 1)];
  std::memcpy(&vector, values, sizeof vector);
}
MEANDER_INLINE void load_places(const PointRows& places, std::size_t first, Floats& x, Floats& y, Floats& z) {
  load(x, std::span<const float>(places.x), first);
  load(y, std::span<const float>(places.y), first);
  load(z, std::span<const float>(places.z), first);
}
template <class Vector, class Value>
MEANDER_INLINE void store(const Vector& vector, std::span<Value> row, std::size_t first) {
  std::memcpy(&row[first], &vector, sizeof(Value) * std::min(lanes, row.size() - first));
}

MEANDER_INLINE void unpack_all(std::span<const std::uint32_t> from, const std::array<float, 3>& corner,
                               float step, float* to_x, float* to_y, float* to_z) {
  for (std::size_t first = 0; first < from.size(); first += lanes) {
    Words steps;
    std::memcpy(&steps, &from[first], sizeof steps);
    const Floats x = corner[0] + step * __builtin_convertvector(steps & 1023, Floats),
                 y = corner[1] + step * __builtin_convertvector(steps >> 10 & 1023, Floats),
                 z = corner[2] + step * __builtin_convertvector(steps >> 20 & 1023, Floats);
    std::memcpy(to_x + first, &x, sizeof x);
    std::memcpy(to_y + first, &y, sizeof y);
    std::memcpy(to_z + first, &z, sizeof z);
  }
}

// Correctly rounded on every processor. The halves do not go by way of memory, where one would wait for the
// other.
MEANDER_INLINE void take_roots(Floats& values) {
#if defined(__SSE__)
  const __m128 low = _mm_sqrt_ps(__builtin_shufflevector(values, values, 0, 1, 2, 3));
  const __m128 high = _mm_sqrt_ps(__builtin_shufflevector(values, values, 4, 5, 6, 7));
  values = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  for (std::size_t k = 0; k < lanes; ++k) values[k] = std::sqrt(values[k]);
#endif
}

template <bool with_short>
MEANDER_INLINE void add_kernel_all(const PointRows& places, const PointRows& points, std::size_t begin,
                                   std::size_t count, const KernelScale& scale, std::span<float> sum) {
  const float* const px = points.x.data() + begin;
  const float* const py = points.y.data() + begin;
  const float* const pz = points.z.data() + begin;
  for (std::size_t first = 0; first < places.size(); first += lanes) {
    Floats x, y, z, total = {}, nearby = {};
    load_places(places, first, x, y, z);
    for (std::size_t i = 0; i < count; ++i) {
      const Floats dx = x - px[i], dy = y - py[i], dz = z - pz[i];
      Floats d = dx * dx + dy * dy + dz * dz;
      take_roots(d);
      Floats t = 1 - scale.per_reach * d;
      t = t > 0 ? t : Floats{};
      total += t * t;
      if constexpr (with_short) {
        Floats s = 1 - scale.per_short * d;
        s = s > 0 ? s : Floats{};
        nearby += s * s;
      }
    }
    Floats before;
    load(before, std::span<const float>(sum), first);
    total = before + scale.weight * total;
    if constexpr (with_short) total += scale.short_weight * nearby;
    store(total, sum, first);
  }
}

MEANDER_INLINE void find_nearest_all(const PointRows& places, const PointRows& points, std::size_t count,
                                     std::span<float> least) {
  for (std::size_t first = 0; first < places.size(); first += lanes) {
    Floats x, y, z, nearest;
    load_places(places, first, x, y, z);
    load(nearest, std::span<const float>(least), first);
    for (std::size_t i = 0; i < count; ++i) {
      const Floats dx = x - points.x[i], dy = y - points.y[i], dz = z - points.z[i];
      const Floats squared = dx * dx + dy * dy + dz * dz;
      nearest = squared < nearest ? squared : nearest;
    }
    store(nearest, least, first);
  }
}

MEANDER_INLINE void add_group_kernel_all(const PointRows& places, std::span<const PointGroup> groups,
                                         float per_reach, std::span<float> sum) {
  const float reach = 1 / per_reach, square = per_reach * per_reach;
  for (std::size_t first = 0; first < places.size(); first += lanes) {
    Floats x, y, z, total;
    load_places(places, first, x, y, z);
    load(total, std::span<const float>(sum), first);
    for (const PointGroup& g : groups) {
      const Floats dx = x - g.mean[0], dy = y - g.mean[1], dz = z - g.mean[2];
      const Floats squared = dx * dx + dy * dy + dz * dz;
      Floats d = squared;
      take_roots(d);
      const Floats t = 1 - per_reach * d, per_d = 1 / d;
      const Floats along = dx * (dx * g.central[0] + dy * g.central[5] + dz * g.central[4]) +
                           dy * (dx * g.central[5] + dy * g.central[1] + dz * g.central[3]) +
                           dz * (dx * g.central[4] + dy * g.central[3] + dz * g.central[2]);
      const float trace = g.central[0] + g.central[1] + g.central[2];
      const Floats value = t * t + square * trace - per_reach * per_d * (trace - along * per_d * per_d);
      // At the reach, where the kernel ends within the group: exact in the middle for a normal distribution.
      Floats within = 0.5f + g.per_extent * (reach - d);
      within = within < 1 ? within : Floats{} + 1;
      within = within > 0 ? within : Floats{};
      total += g.mass * within * value;
    }
    store(total, sum, first);
  }
}

MEANDER_INLINE void find_all_gaps(const BoxRows& boxes, const std::array<float, 3>& low,
                                  const std::array<float, 3>& high, float distance,
                                  std::vector<float>& beyond) {
  for (std::size_t first = 0; first < beyond.size(); first += lanes) {
    Floats squared = {};
    for (std::size_t k = 0; k < 3; ++k) {
      Floats from, to;
      std::memcpy(&from, &boxes.low[k][first], sizeof from);
      std::memcpy(&to, &boxes.high[k][first], sizeof to);
      const Floats up = from - high[k], down = low[k] - to;
      Floats gap = up > down ? up : down;
      gap = gap > 0 ? gap : Floats{};
      squared += gap * gap;
    }
    Floats within;
    std::memcpy(&within, &boxes.margin[first], sizeof within);
    within += distance;
    squared -= within * within;
    std::memcpy(&beyond[first], &squared, sizeof squared);
  }
}

float sum_of(const Floats& values) {
  float sum = 0;
  for (std::size_t k = 0; k < lanes; ++k) sum += values[k];
  return sum;
}

MEANDER_INLINE void load_all(Floats& vector, const std::vector<float>& row, std::size_t first) {
  std::memcpy(&vector, &row[first], sizeof vector);
}

// The ways from a place to points, in spacings.
template <class Rows>
MEANDER_INLINE void load_ways(const Rows& points, std::size_t first, const std::array<float, 3>& at,
                              float per_spacing, Floats& x, Floats& y, Floats& z) {
  load_all(x, points.x, first);
  load_all(y, points.y, first);
  load_all(z, points.z, first);
  x = per_spacing * (x - at[0]);
  y = per_spacing * (y - at[1]);
  z = per_spacing * (z - at[2]);
}

MEANDER_INLINE void sum_ways_all(const PointRows& points, const std::array<float, 3>& at, float per_spacing,
                                 std::array<float, 3>& way) {
  Floats way_x = {}, way_y = {}, way_z = {};
  for (std::size_t first = 0; first < points.size(); first += lanes) {
    Floats x, y, z;
    load_ways(points, first, at, per_spacing, x, y, z);
    Floats t = 1 - 0.25f * (x * x + y * y + z * z);
    t = t > 0 ? t : Floats{};
    const Floats t2 = t * t, t7 = t2 * t2 * t2 * t;
    way_x += t7 * x;
    way_y += t7 * y;
    way_z += t7 * z;
  }
  way = {sum_of(way_x), sum_of(way_y), sum_of(way_z)};
}

MEANDER_INLINE void sum_pull_all(const SurfaceRows& points, const std::array<float, 3>& at,
                                 const std::array<float, 3>& normal, float per_spacing, Pull& pull) {
  Floats way_x = {}, way_y = {}, way_z = {}, xx = {}, xy = {}, xz = {}, yy = {}, yz = {}, zz = {}, whole = {},
         facing = {}, all = {};
  for (std::size_t first = 0; first < points.size(); first += lanes) {
    Floats x, y, z, mass, nx, ny, nz;
    load_ways(points, first, at, per_spacing, x, y, z);
    load_all(mass, points.mass, first);
    load_all(nx, points.normal_x, first);
    load_all(ny, points.normal_y, first);
    load_all(nz, points.normal_z, first);
    Floats t = 1 - 0.25f * (x * x + y * y + z * z);
    t = t > 0 ? t : Floats{};
    const Floats t2 = t * t, t6 = t2 * t2 * t2;
    const Floats k7 = mass * (t6 * t), s = 3.5f * (mass * t6);
    const Floats sx = s * x, sy = s * y;
    way_x += k7 * x;
    way_y += k7 * y;
    way_z += k7 * z;
    whole += k7;
    xx += sx * x;
    xy += sx * y;
    xz += sx * z;
    yy += sy * y;
    yz += sy * z;
    zz += s * z * z;
    const Floats k8 = k7 * t;
    all += k8;
    facing += k8 * (0.5f + 0.5f * (normal[0] * nx + normal[1] * ny + normal[2] * nz));
  }
  pull.way = {sum_of(way_x), sum_of(way_y), sum_of(way_z)};
  const float c = sum_of(whole);
  pull.slope = {sum_of(xx) - c, sum_of(xy), sum_of(xz), sum_of(yy) - c, sum_of(yz), sum_of(zz) - c};
  pull.facing = sum_of(facing);
  pull.all = sum_of(all);
}

// How much of a kernel has not ended at a distance.
MEANDER_INLINE void find_left(const Floats& d, float reach, float per_ramp, Floats& share) {
  share = 0.5f + per_ramp * (reach - d);
  share = share < 1 ? share : Floats{} + 1;
  share = share > 0 ? share : Floats{};
}

MEANDER_INLINE void sum_dipoles_all(const DipoleRows& dipoles, const std::array<float, 3>& at,
                                    const FarScale& scale, std::array<float, 3>& slope) {
  const float per_near = 1 / scale.near, per_far = 1 / scale.far, per_ramp = 0.5f / scale.ramp;
  Floats slope_x = {}, slope_y = {}, slope_z = {};
  for (std::size_t first = 0; first < dipoles.x.size(); first += lanes) {
    Floats x, y, z, way_x, way_y, way_z;
    load_ways(dipoles, first, at, scale.per_spacing, x, y, z);
    load_all(way_x, dipoles.way_x, first);
    load_all(way_y, dipoles.way_y, first);
    load_all(way_z, dipoles.way_z, first);
    const Floats squared = x * x + y * y + z * z;
    Floats d = squared;
    take_roots(d);
    Floats outer, inner;
    find_left(d, scale.far, per_ramp, outer);
    find_left(d, scale.near, per_ramp, inner);
    // The Hessian is -2 / near times across (1 - r r^T) + all, where r is the unit vector.
    const Floats all = inner * per_near - outer * per_far;
    const Floats across = d > 0 ? (outer - inner) / d : Floats{};
    const Floats along = squared > 0 ? across / squared * (x * way_x + y * way_y + z * way_z) : Floats{};
    const Floats both = all + across;
    slope_x += both * way_x - along * x;
    slope_y += both * way_y - along * y;
    slope_z += both * way_z - along * z;
  }
  const float factor = 2 * per_near * scale.per_spacing;
  slope = {factor * sum_of(slope_x), factor * sum_of(slope_y), factor * sum_of(slope_z)};
}

MEANDER_TARGET("avx2")
void sum_dipoles_avx2(const DipoleRows& dipoles, const std::array<float, 3>& at, const FarScale& scale,
                      std::array<float, 3>& slope) {
  sum_dipoles_all(dipoles, at, scale, slope);
}
MEANDER_TARGET("avx2")
void sum_ways_avx2(const PointRows& points, const std::array<float, 3>& at, float per_spacing,
                   std::array<float, 3>& way) {
  sum_ways_all(points, at, per_spacing, way);
}
MEANDER_TARGET("avx2")
void sum_pull_avx2(const SurfaceRows& points, const std::array<float, 3>& at,
                   const std::array<float, 3>& normal, float per_spacing, Pull& pull) {
  sum_pull_all(points, at, normal, per_spacing, pull);
}

MEANDER_TARGET("avx2")
void find_gaps_avx2(const BoxRows& boxes, const std::array<float, 3>& low, const std::array<float, 3>& high,
                    float distance, std::vector<float>& beyond) {
  find_all_gaps(boxes, low, high, distance, beyond);
}
MEANDER_TARGET("avx2")
void add_kernel_avx2(const PointRows& places, const PointRows& points, std::size_t begin, std::size_t count,
                     const KernelScale& scale, std::span<float> sum) {
  if (scale.short_weight != 0)
    add_kernel_all<true>(places, points, begin, count, scale, sum);
  else
    add_kernel_all<false>(places, points, begin, count, scale, sum);
}
void add_kernel_plain(const PointRows& places, const PointRows& points, std::size_t begin, std::size_t count,
                      const KernelScale& scale, std::span<float> sum) {
  if (scale.short_weight != 0)
    add_kernel_all<true>(places, points, begin, count, scale, sum);
  else
    add_kernel_all<false>(places, points, begin, count, scale, sum);
}
MEANDER_TARGET("avx2")
void find_nearest_avx2(const PointRows& places, const PointRows& points, std::size_t count,
                       std::span<float> least) {
  find_nearest_all(places, points, count, least);
}
MEANDER_TARGET("avx2")
void add_group_kernel_avx2(const PointRows& places, std::span<const PointGroup> groups, float per_reach,
                           std::span<float> sum) {
  add_group_kernel_all(places, groups, per_reach, sum);
}

MEANDER_TARGET("avx2")
void unpack_avx2(std::span<const std::uint32_t> from, const std::array<float, 3>& corner, float step,
                 float* to_x, float* to_y, float* to_z) {
  unpack_all(from, corner, step, to_x, to_y, to_z);
}

// Rows as long as a multiple of the lanes, 0 from `count` on.
void resize_padded(std::initializer_list<std::vector<float>*> rows, std::size_t count) {
  const std::size_t padded = (count + lanes - 1) / lanes * lanes;
  for (std::vector<float>* const row : rows) {
    row->resize(padded);
    std::fill(row->begin() + static_cast<std::ptrdiff_t>(count), row->end(), 0.0f);
  }
}

}  // namespace

void unpack(std::span<const std::uint32_t> from, const std::array<float, 3>& corner, float step, float* to_x,
            float* to_y, float* to_z, InstructionSet set) {
  if (takes_avx2(set))
    unpack_avx2(from, corner, step, to_x, to_y, to_z);
  else
    unpack_all(from, corner, step, to_x, to_y, to_z);
}

void BoxRows::resize(std::size_t count) {
  const std::size_t padded = (count + lanes - 1) / lanes * lanes;
  for (std::size_t k = 0; k < 3; ++k) {
    low[k].resize(padded);
    high[k].resize(padded);
  }
  margin.resize(padded);
}

void find_gaps(const BoxRows& boxes, const std::array<float, 3>& low, const std::array<float, 3>& high,
               float distance, std::vector<float>& beyond, InstructionSet set) {
  beyond.resize(boxes.margin.size());
  if (takes_avx2(set))
    find_gaps_avx2(boxes, low, high, distance, beyond);
  else
    find_all_gaps(boxes, low, high, distance, beyond);
}

void add_kernel(const PointRows& places, const PointRows& points, std::size_t first, std::size_t count,
                const KernelScale& scale, std::span<float> sum, InstructionSet set) {
  if (takes_avx2(set))
    add_kernel_avx2(places, points, first, count, scale, sum);
  else
    add_kernel_plain(places, points, first, count, scale, sum);
}

void find_nearest(const PointRows& places, const PointRows& points, std::size_t count, std::span<float> least,
                  InstructionSet set) {
  if (takes_avx2(set))
    find_nearest_avx2(places, points, count, least);
  else
    find_nearest_all(places, points, count, least);
}

void SurfaceRows::resize(std::size_t count) {
  resize_padded({&x, &y, &z, &mass, &normal_x, &normal_y, &normal_z}, count);
}

void DipoleRows::resize(std::size_t count) { resize_padded({&x, &y, &z, &way_x, &way_y, &way_z}, count); }

std::array<float, 3> sum_dipoles(const DipoleRows& dipoles, const std::array<float, 3>& at,
                                 const FarScale& scale, InstructionSet set) {
  std::array<float, 3> slope;
  if (takes_avx2(set))
    sum_dipoles_avx2(dipoles, at, scale, slope);
  else
    sum_dipoles_all(dipoles, at, scale, slope);
  return slope;
}

std::array<float, 3> sum_ways(const PointRows& points, const std::array<float, 3>& at, float per_spacing,
                              InstructionSet set) {
  std::array<float, 3> way;
  if (takes_avx2(set))
    sum_ways_avx2(points, at, per_spacing, way);
  else
    sum_ways_all(points, at, per_spacing, way);
  return way;
}

Pull sum_pull(const SurfaceRows& points, const std::array<float, 3>& at, const std::array<float, 3>& normal,
              float per_spacing, InstructionSet set) {
  Pull pull;
  if (takes_avx2(set))
    sum_pull_avx2(points, at, normal, per_spacing, pull);
  else
    sum_pull_all(points, at, normal, per_spacing, pull);
  return pull;
}

void add_group_kernel(const PointRows& places, std::span<const PointGroup> groups, float per_reach,
                      std::span<float> sum, InstructionSet set) {
  if (takes_avx2(set))
    add_group_kernel_avx2(places, groups, per_reach, sum);
  else
    add_group_kernel_all(places, groups, per_reach, sum);
}

}  // namespace meander
