#include "kernels/sample/room.h"

#include <algorithm>
#include <cstring>

namespace meander {

namespace {

// Eight places at a time, in vectors that the compiler maps to the instructions at hand: the same operations
// in the same order, whatever these are.
constexpr std::size_t lanes = 8;
using Floats = float __attribute__((vector_size(4 * lanes)));
using Words = std::int32_t __attribute__((vector_size(4 * lanes)));
#define MEANDER_INLINE __attribute__((always_inline)) inline

// A row from `first` on; lanes beyond its end repeat the last place.
template <class Vector, class Value>
MEANDER_INLINE void load(Vector& vector, std::span<const Value> row, std::size_t first) {
  Value values[lanes];
  for (std::size_t k = 0; k < lanes; ++k) values[k] = row[std::min(first + k, row.size() - 1)];
  std::memcpy(&vector, values, sizeof vector);
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

MEANDER_INLINE void lower_all(const PointRows& places, const PointRows& points, std::span<float> squared) {
  for (std::size_t first = 0; first < places.size(); first += lanes) {
    Floats x, y, z, least;
    load(x, std::span<const float>(places.x), first);
    load(y, std::span<const float>(places.y), first);
    load(z, std::span<const float>(places.z), first);
    load(least, std::span<const float>(squared), first);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Floats dx = x - points.x[i], dy = y - points.y[i], dz = z - points.z[i];
      const Floats d = dx * dx + dy * dy + dz * dz;
      least = d < least ? d : least;
    }
    store(least, squared, first);
  }
}

MEANDER_INLINE void sum_all(const PointRows& places, const PointRows& points,
                            std::span<const std::uint32_t> weight, std::span<const float> squared,
                            std::span<std::uint32_t> mass) {
  for (std::size_t first = 0; first < places.size(); first += lanes) {
    Floats x, y, z, limit;
    load(x, std::span<const float>(places.x), first);
    load(y, std::span<const float>(places.y), first);
    load(z, std::span<const float>(places.z), first);
    load(limit, squared, first);
    Words sum = {};
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const Floats dx = x - points.x[i], dy = y - points.y[i], dz = z - points.z[i];
      const Floats d = dx * dx + dy * dy + dz * dz;
      sum += (d < limit) & static_cast<std::int32_t>(weight[i]);
    }
    store(sum, mass, first);
  }
}

MEANDER_TARGET("avx2")
void unpack_avx2(std::span<const std::uint32_t> from, const std::array<float, 3>& corner, float step,
                 float* to_x, float* to_y, float* to_z) {
  unpack_all(from, corner, step, to_x, to_y, to_z);
}
MEANDER_TARGET("avx2")
void lower_avx2(const PointRows& places, const PointRows& points, std::span<float> squared) {
  lower_all(places, points, squared);
}
MEANDER_TARGET("avx2")
void sum_avx2(const PointRows& places, const PointRows& points, std::span<const std::uint32_t> weight,
              std::span<const float> squared, std::span<std::uint32_t> mass) {
  sum_all(places, points, weight, squared, mass);
}

bool takes_avx2(InstructionSet set) {
  static const bool available = is_available(InstructionSet::avx2);
  return set != InstructionSet::scalar && available;
}

}  // namespace

void unpack(std::span<const std::uint32_t> from, const std::array<float, 3>& corner, float step, float* to_x,
            float* to_y, float* to_z, InstructionSet set) {
  if (takes_avx2(set))
    unpack_avx2(from, corner, step, to_x, to_y, to_z);
  else
    unpack_all(from, corner, step, to_x, to_y, to_z);
}

void lower_to_nearest(const PointRows& places, const PointRows& points, std::span<float> squared,
                      InstructionSet set) {
  if (takes_avx2(set))
    lower_avx2(places, points, squared);
  else
    lower_all(places, points, squared);
}

void mass_within(const PointRows& places, const PointRows& points, std::span<const std::uint32_t> weight,
                 std::span<const float> squared, std::span<std::uint32_t> mass, InstructionSet set) {
  if (takes_avx2(set))
    sum_avx2(places, points, weight, squared, mass);
  else
    sum_all(places, points, weight, squared, mass);
}

}  // namespace meander
