#include "kernels/partition/clipped_pieces.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "kernels/core/vector_instructions.h"

namespace meander {

namespace {

// A rotation by some thousandths, from a quaternion that need not be a unit one.
constexpr std::array<std::array<double, 3>, 3> rotation_by(double x, double y, double z) {
  const double n = 1 + x * x + y * y + z * z;
  return {{{(1 + x * x - y * y - z * z) / n, 2 * (x * y - z) / n, 2 * (x * z + y) / n},
           {2 * (x * y + z) / n, (1 - x * x + y * y - z * z) / n, 2 * (y * z - x) / n},
           {2 * (x * z - y) / n, 2 * (y * z + x) / n, (1 - x * x - y * y + z * z) / n}}};
}
constexpr auto tilt = rotation_by(0.0019, -0.0012, 0.0016);

// Shares of a cell's mass that may be missing before the last step to a plane, and be left after it. The last
// step squares the missing share unless it passes a face along the plane, in which case a cut moves that much
// mass, and at most a share of near_section of the sections is wrong.
constexpr double near_model = 0x1p-5, near_cut = 0x1p-7, cut_tolerance = 0x1p-14, near_section = 0x1p-12;
constexpr int most_trials = 32;
constexpr float last_step = 0x1p-6f;  // of the extent
// Pieces that extend less across a plane than this times their node are not clipped.
constexpr float thin = 0x1p-20f;
// Less than any other length; and more mass along one than there is, which must not become infinite.
constexpr float least_length = 1e-30f, most_density = 1e36f;

__m128 absolute(__m128 x) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), x); }

float sum(__m128 x) {
  const __m128 pairs = _mm_add_ps(x, _mm_movehl_ps(x, x));
  return _mm_cvtss_f32(_mm_add_ss(pairs, _mm_shuffle_ps(pairs, pairs, 1)));
}

std::array<float, 3> three_of(__m128 x) {
  alignas(16) std::array<float, 4> lanes;
  _mm_store_ps(lanes.data(), x);
  return {lanes[0], lanes[1], lanes[2]};
}

void turn(const Vector3& v, float* to) {
  for (std::size_t k = 0; k < 3; ++k)
    to[k] = static_cast<float>(tilt[k][0] * v.x + tilt[k][1] * v.y + tilt[k][2] * v.z);
}

// A uniform point of a triangle by the weights of its corners 1 and 2.
std::array<float, 2> weights_in_triangle(double first, double second) {
  const double root = std::sqrt(first);
  return {static_cast<float>(root * (1 - second)), static_cast<float>(root * second)};
}

}  // namespace

ClippedPieces::Point ClippedPieces::turned(const Point& direction) {
  __m128 sum = _mm_setzero_ps();
  for (std::size_t k = 0; k < 3; ++k) {
    const __m128 column = _mm_setr_ps(static_cast<float>(tilt[0][k]), static_cast<float>(tilt[1][k]),
                                      static_cast<float>(tilt[2][k]), 0);
    sum = _mm_add_ps(sum, _mm_mul_ps(_mm_set1_ps(direction[k]), column));
  }
  return three_of(sum);
}

void ClippedPieces::begin(const Vector3& origin, std::size_t triangles, Room room) {
  constexpr std::size_t least = 256;
  origin_ = origin;
  room_ = room;
  item_.clear();
  polygon_.clear();
  item_.reserve(room == Room::tree ? 9 * triangles / 2 + least : 2 * triangles);
  polygon_.reserve(room == Room::tree ? 21 * triangles / 8 + least : triangles + triangles / 2);
}

void ClippedPieces::add(const std::array<Vector3, 3>& corner, double mass, std::uint32_t name) {
  if (!(mass > 0)) return;
  Item item;
  item.name = name;
  item.mass = mass;
  Polygon polygon;
  turn(corner[0] - origin_, polygon.corner);
  turn(corner[1] - corner[0], polygon.edge[0]);
  turn(corner[2] - corner[0], polygon.edge[1]);
  polygon.corner[3] = polygon.edge[0][3] = polygon.edge[1][3] = 0;
  polygon.first[0] = 0, polygon.second[0] = 0;
  polygon.first[1] = 1, polygon.second[1] = 0;
  polygon.first[2] = 0, polygon.second[2] = 1;
  polygon.corners = 3;
  polygon.area = 0.5f;
  polygon.density = static_cast<float>(2 * mass);
  close(polygon, item);
  item.polygon = static_cast<std::uint32_t>(polygon_.size());
  polygon_.push_back(polygon);
  item_.push_back(item);
}

void ClippedPieces::take(const ClippedPieces& other, List list, Room room) {
  begin(other.origin_, list.count, room);
  for (std::size_t i = 0; i < list.count; ++i) {
    Item item = other.item_[list.first + i];
    polygon_.push_back(other.polygon_[item.polygon]);
    item.polygon = static_cast<std::uint32_t>(polygon_.size() - 1);
    item_.push_back(item);
  }
}

// Fills what follows from the corners, but for area and mass.
void ClippedPieces::close(Polygon& polygon, Item& item) const {
  const __m128 corner = _mm_loadu_ps(polygon.corner), first = _mm_loadu_ps(polygon.edge[0]),
               second = _mm_loadu_ps(polygon.edge[1]);
  __m128 low = _mm_set1_ps(INFINITY), high = _mm_set1_ps(-INFINITY);
  for (std::uint32_t k = 0; k < polygon.corners; ++k) {
    const __m128 at = _mm_add_ps(_mm_add_ps(corner, _mm_mul_ps(_mm_set1_ps(polygon.first[k]), first)),
                                 _mm_mul_ps(_mm_set1_ps(polygon.second[k]), second));
    low = _mm_min_ps(low, at);
    high = _mm_max_ps(high, at);
  }
  alignas(16) float box[2][4];
  _mm_store_ps(box[0], low);
  _mm_store_ps(box[1], high);
  std::copy(box[0], box[0] + 3, item.low);
  std::copy(box[1], box[1] + 3, item.high);
  for (std::uint32_t k = polygon.corners; k < polygon.corners + 4; ++k) {
    polygon.first[k] = polygon.first[0];
    polygon.second[k] = polygon.second[0];
  }
}

// From its first corner: products of weights would cancel where the polygon is small.
float ClippedPieces::area_of(const Polygon& polygon) {
  const __m128 a = _mm_set1_ps(polygon.first[0]), b = _mm_set1_ps(polygon.second[0]);
  __m128 twice = _mm_setzero_ps();
  for (std::size_t k = 0; k < polygon.corners; k += 4) {
    const float *const first = polygon.first + k, *const second = polygon.second + k;
    const __m128 u = _mm_sub_ps(_mm_loadu_ps(first), a), v = _mm_sub_ps(_mm_loadu_ps(second), b);
    const __m128 next_u = _mm_sub_ps(_mm_loadu_ps(first + 1), a),
                 next_v = _mm_sub_ps(_mm_loadu_ps(second + 1), b);
    twice = _mm_add_ps(twice, _mm_sub_ps(_mm_mul_ps(u, next_v), _mm_mul_ps(next_u, v)));
  }
  return 0.5f * std::abs(sum(twice));
}

ClippedPieces::Extent ClippedPieces::extent_of(List list) const {
  const __m128 places = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
  __m128 low = _mm_set1_ps(INFINITY), high = _mm_set1_ps(-INFINITY), moment = _mm_setzero_ps();
  Extent extent;
  for (std::size_t i = 0; i < list.count; ++i) {
    const Item& item = item_[list.first + i];
    const __m128 least = _mm_and_ps(_mm_loadu_ps(item.low), places),
                 most = _mm_and_ps(_mm_loadu_ps(item.high), places);
    low = _mm_min_ps(low, least);
    high = _mm_max_ps(high, most);
    moment =
        _mm_add_ps(moment, _mm_mul_ps(_mm_set1_ps(static_cast<float>(item.mass)), _mm_add_ps(least, most)));
    extent.mass += item.mass;
  }
  _mm_store_ps(extent.low, low);
  _mm_store_ps(extent.high, high);
  _mm_store_ps(extent.moment, moment);
  alignas(16) float length[4];
  _mm_store_ps(length, _mm_sub_ps(high, low));
  for (std::size_t k = 1; k < 3; ++k)
    if (length[k] > length[extent.axis]) extent.axis = k;
  return extent;
}

ClippedPieces::Point ClippedPieces::center(const Extent& extent) const {
  const double scale = extent.mass > 0 ? 0.5 / extent.mass : 0;
  return in_space({extent.moment[0], extent.moment[1], extent.moment[2]}, scale);
}

// Turned back by the transpose.
ClippedPieces::Point ClippedPieces::in_space(const Point& at, double scale) const {
  const double origin[3] = {origin_.x, origin_.y, origin_.z};
  Point place;
  for (std::size_t k = 0; k < 3; ++k)
    place[k] = static_cast<float>(origin[k] + scale * (tilt[0][k] * static_cast<double>(at[0]) +
                                                       tilt[1][k] * static_cast<double>(at[1]) +
                                                       tilt[2][k] * static_cast<double>(at[2])));
  return place;
}

ClippedPieces::Point ClippedPieces::place_at(const Polygon& polygon, const std::array<float, 2>& weights) {
  const __m128 first = _mm_mul_ps(_mm_set1_ps(weights[0]), _mm_loadu_ps(polygon.edge[0])),
               second = _mm_mul_ps(_mm_set1_ps(weights[1]), _mm_loadu_ps(polygon.edge[1]));
  return three_of(_mm_add_ps(_mm_add_ps(_mm_loadu_ps(polygon.corner), first), second));
}

ClippedPieces::Point ClippedPieces::place_of(const Item& item) const {
  const Polygon& polygon = polygon_[item.polygon];
  std::array<float, 2> mean{};
  for (std::uint32_t k = 0; k < polygon.corners; ++k) {
    mean[0] += polygon.first[k];
    mean[1] += polygon.second[k];
  }
  for (float& weight : mean) weight /= static_cast<float>(polygon.corners);
  return place_at(polygon, mean);
}

// In one of the triangles around its first corner, in turn.
std::array<float, 2> ClippedPieces::probe_weights(const Polygon& polygon, std::size_t number) {
  // The points of an additive recurrence (Roberts 2018) in the plane, folded to the triangle.
  const auto step = static_cast<std::uint32_t>(number + 1);
  auto along_first = static_cast<float>(step * 3242174889u >> 8) * 0x1p-24f,
       along_second = static_cast<float>(step * 2447445414u >> 8) * 0x1p-24f;
  if (along_first + along_second > 1) {
    along_first = 1 - along_first;
    along_second = 1 - along_second;
  }
  const std::size_t k = polygon.corners == 3 ? 1 : 1 + number % (polygon.corners - 2);
  const float a = polygon.first[0], b = polygon.second[0];
  return {a + along_first * (polygon.first[k] - a) + along_second * (polygon.first[k + 1] - a),
          b + along_first * (polygon.second[k] - b) + along_second * (polygon.second[k + 1] - b)};
}

// Uniform, in the triangles around its first corner.
std::array<float, 2> ClippedPieces::weights_in(const Polygon& polygon, double first, double second) {
  double left = first * 2 * static_cast<double>(polygon.area);
  const float a = polygon.first[0], b = polygon.second[0];
  for (std::uint32_t k = 1;; ++k) {
    const float u[2] = {polygon.first[k] - a, polygon.second[k] - b},
                v[2] = {polygon.first[k + 1] - a, polygon.second[k + 1] - b};
    const double twice = std::abs(static_cast<double>(u[0] * v[1] - u[1] * v[0]));
    if (left >= twice && k + 2 < polygon.corners) {
      left -= twice;
      continue;
    }
    const auto weights = weights_in_triangle(twice > 0 ? std::min(left / twice, 1.0) : 0.0, second);
    return {a + weights[0] * u[0] + weights[1] * v[0], b + weights[0] * u[1] + weights[1] * v[1]};
  }
}

// The mass below a plane across that axis, and its first and second derivative by the plane's coordinate. By
// Green's theorem, of the boundary alone: with w, one of the two weights, and d = at - x, the part where d >
// 0 has in the plane of x and w the area of the integral of max(d, 0) dw around the polygon. Along an edge d
// is linear: with p = max(d, 0) at its ends, it is positive on the fraction f = (p0 + p1) / (|d0| + |d1|),
// and p has the mean f (p0 + p1) / 2. The derivative by `at` is the integral of f dw; f itself grows by 1 /
// (|d0| + |d1|) on the edges that the plane crosses.
__m128 ClippedPieces::below(const Polygon& polygon, std::size_t axis, float at) {
  const float first = polygon.edge[0][axis], second = polygon.edge[1][axis];
  const bool by_first = std::abs(second) >= std::abs(first);
  const float* const w = by_first ? polygon.first : polygon.second;
  const __m128 offset = _mm_set1_ps(at - polygon.corner[axis]), along_first = _mm_set1_ps(first),
               along_second = _mm_set1_ps(second), zero = _mm_setzero_ps();
  const __m128 least = _mm_set1_ps(least_length);
  const auto distance = [&](std::size_t k) {
    return _mm_sub_ps(_mm_sub_ps(offset, _mm_mul_ps(_mm_loadu_ps(polygon.first + k), along_first)),
                      _mm_mul_ps(_mm_loadu_ps(polygon.second + k), along_second));
  };
  __m128 area = zero, rate = zero, bend = zero, none = zero;
  for (std::size_t k = 0; k < polygon.corners; k += 4) {
    const __m128 from = distance(k), to = distance(k + 1);
    const __m128 positive = _mm_add_ps(_mm_max_ps(from, zero), _mm_max_ps(to, zero));
    const __m128 whole = _mm_max_ps(_mm_add_ps(absolute(from), absolute(to)), least);
    const __m128 turns = _mm_div_ps(_mm_sub_ps(_mm_loadu_ps(w + k + 1), _mm_loadu_ps(w + k)), whole);
    const __m128 crossed = _mm_xor_ps(_mm_cmpgt_ps(from, zero), _mm_cmpgt_ps(to, zero));
    const __m128 swept = _mm_mul_ps(turns, positive);
    bend = _mm_add_ps(bend, _mm_and_ps(turns, crossed));
    rate = _mm_add_ps(rate, swept);
    area = _mm_add_ps(area, _mm_mul_ps(swept, positive));
  }
  _MM_TRANSPOSE4_PS(area, rate, bend, none);
  __m128 sums = _mm_add_ps(_mm_add_ps(area, rate), _mm_add_ps(bend, none));
  // The way around may be the other one.
  sums =
      _mm_xor_ps(sums, _mm_and_ps(_mm_shuffle_ps(sums, sums, _MM_SHUFFLE(1, 1, 1, 1)), _mm_set1_ps(-0.0f)));
  const float scale = polygon.density / std::max(std::abs(by_first ? second : first), least_length);
  sums = _mm_mul_ps(sums, _mm_setr_ps(0.5f * scale, scale, scale, 0));
  const __m128 most = _mm_setr_ps(polygon.area * polygon.density, INFINITY, INFINITY, INFINITY);
  return _mm_min_ps(_mm_max_ps(sums, _mm_setr_ps(0, 0, -INFINITY, 0)), most);
}

// A first model of what lies below a plane, for which nothing is clipped: the mass of a polygon lies evenly
// along its extent.
void ClippedPieces::lay_out(List list, const Extent& extent) {
  const std::size_t axis = extent.axis, room = (list.count + 3) / 4 * 4;
  const float least = thin * (extent.high[axis] - extent.low[axis]) + least_length;
  for (std::vector<float>* const row : {&from_, &density_, &mass_})
    if (row->size() < room) row->resize(room);
  for (std::size_t i = 0; i < list.count; ++i) {
    const Item& item = item_[list.first + i];
    const auto mass = static_cast<float>(item.mass);
    from_[i] = item.low[axis];
    mass_[i] = mass;
    density_[i] = std::min(mass / std::max(item.high[axis] - item.low[axis], least), most_density);
  }
  for (std::size_t i = list.count; i < room; ++i) from_[i] = mass_[i] = density_[i] = 0;
}

// Steps within the bounds that have been found: Newton's in the first model, then to the parabola of the
// polygons themselves. Once no more than the tolerance is missing, one more step is the last.
float ClippedPieces::plane(List list, const Extent& extent, double target, double cell, double near) {
  lay_out(list, extent);
  const std::size_t axis = extent.axis;
  const float length = extent.high[axis] - extent.low[axis];
  // Sums of float stay short.
  constexpr std::size_t block = 64;
  const __m128 zero = _mm_setzero_ps();
  double mass = 0, rate = 0, bend = 0;
  const auto model = [&](float at) {
    const __m128 plane = _mm_set1_ps(at);
    mass = rate = 0;
    for (std::size_t begin = 0; begin < list.count; begin += block) {
      __m128 masses = zero, rates = zero;
      for (std::size_t i = begin; i < std::min(begin + block, list.count); i += 4) {
        const __m128 density = _mm_loadu_ps(&density_[i]), whole = _mm_loadu_ps(&mass_[i]);
        const __m128 below = _mm_mul_ps(_mm_sub_ps(plane, _mm_loadu_ps(&from_[i])), density);
        const __m128 part = _mm_min_ps(_mm_max_ps(below, zero), whole);
        masses = _mm_add_ps(masses, part);
        rates = _mm_add_ps(rates, _mm_and_ps(_mm_cmpeq_ps(part, below), density));
      }
      mass += static_cast<double>(sum(masses));
      rate += static_cast<double>(sum(rates));
    }
  };
  const auto exact = [&](float at) {
    const __m128 plane = _mm_set1_ps(at);
    mass = rate = bend = 0;
    for (std::size_t begin = 0; begin < list.count; begin += block) {
      __m128 masses = zero, parts = zero;
      for (std::size_t i = begin; i < std::min(begin + block, list.count); i += 4) {
        const __m128 whole = _mm_loadu_ps(&mass_[i]);
        const __m128 below_plane =
            _mm_mul_ps(_mm_sub_ps(plane, _mm_loadu_ps(&from_[i])), _mm_loadu_ps(&density_[i]));
        const __m128 is_full = _mm_cmpge_ps(below_plane, whole);
        masses = _mm_add_ps(masses, _mm_and_ps(is_full, whole));
        auto parted =
            static_cast<unsigned>(_mm_movemask_ps(_mm_andnot_ps(is_full, _mm_cmpgt_ps(below_plane, zero))));
        for (; parted != 0; parted &= parted - 1) {
          const Item& item = item_[list.first + i + static_cast<std::size_t>(std::countr_zero(parted))];
          parts = _mm_add_ps(parts, below(polygon_[item.polygon], axis, at));
        }
      }
      alignas(16) float sums[4];
      _mm_store_ps(sums, parts);
      mass += static_cast<double>(sum(masses)) + static_cast<double>(sums[0]);
      rate += static_cast<double>(sums[1]);
      bend += static_cast<double>(sums[2]);
    }
  };
  float at = static_cast<float>(static_cast<double>(extent.moment[axis]) / (2 * extent.mass) +
                                (target / extent.mass - 0.5) * static_cast<double>(length));
  // Steps of either until what is missing is near enough.
  const auto find = [&](const auto& evaluate, double near_enough) {
    float low = extent.low[axis], high = extent.high[axis];
    if (!(at > low && at < high)) at = 0.5f * (low + high);
    for (int trial = 0; trial < most_trials; ++trial) {
      evaluate(at);
      const double missing = target - mass;
      // Where a parabola has what is missing, or the tangent.
      const double square = rate * rate + 2 * bend * missing;
      const double slope = square > 0 ? 0.5 * (rate + std::sqrt(square)) : rate;
      float next = rate > 0 ? at + static_cast<float>(missing / slope) : low;
      (missing > 0 ? low : high) = at;
      // The last step, unless it would cross a gap that hardly anything lies in.
      if (std::abs(missing) <= near_enough && rate > 0 && std::abs(next - at) <= last_step * length) {
        at = std::clamp(next, low, high);
        return;
      }
      if (!(next > low && next < high)) next = 0.5f * (low + high);
      if (!(next > low && next < high)) return;
      at = next;
    }
  };
  constexpr std::size_t few = 12;  // polygons, for which the model saves nothing
  if (list.count > few) find(model, near_model * cell);
  find(exact, near * cell);
  return at;
}

// Keeps the part below the plane, and makes one of what is above. False where the plane does not part it.
bool ClippedPieces::clip(Item& item, std::size_t axis, float at, Item& above) {
  polygon_.emplace_back();
  Polygon &low = polygon_[item.polygon], &high = polygon_.back();
  const std::uint32_t corners = low.corners;
  float first[most_corners + 4], second[most_corners + 4], distance[most_corners + 4];
  std::uint32_t lower = 0;  // bits: corners below the plane
  for (std::uint32_t k = 0; k < corners; k += 4) {
    const __m128 weights = _mm_loadu_ps(low.first + k), others = _mm_loadu_ps(low.second + k);
    const __m128 d = _mm_sub_ps(
        _mm_sub_ps(_mm_set1_ps(at - low.corner[axis]), _mm_mul_ps(weights, _mm_set1_ps(low.edge[0][axis]))),
        _mm_mul_ps(others, _mm_set1_ps(low.edge[1][axis])));
    _mm_storeu_ps(first + k, weights);
    _mm_storeu_ps(second + k, others);
    _mm_storeu_ps(distance + k, d);
    lower |= static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmpgt_ps(d, _mm_setzero_ps()))) << k;
  }
  const std::uint32_t mask = (1u << corners) - 1;
  lower &= mask;
  const auto count = static_cast<std::uint32_t>(std::popcount(lower));
  const std::uint32_t begins = lower & ~(lower << 1 | lower >> (corners - 1));
  // On one side, but for rounding; or with more corners than there are places for.
  if (std::popcount(begins) != 1 || std::max(count, corners - count) + 2 > most_corners) {
    polygon_.pop_back();
    return false;
  }
  const auto wrapped = [corners](std::uint32_t k) { return k >= corners ? k - corners : k; };
  const auto begin = static_cast<std::uint32_t>(std::countr_zero(begins)), end = wrapped(begin + count);
  const auto crossing = [&](std::uint32_t to, Polygon& polygon) {
    const std::uint32_t from = to == 0 ? corners - 1 : to - 1;
    const float part = distance[from] / (distance[from] - distance[to]);
    polygon.first[0] = first[from] + part * (first[to] - first[from]);
    polygon.second[0] = second[from] + part * (second[to] - second[from]);
  };
  const float whole = low.area;
  const auto fill = [&](Polygon& polygon, std::uint32_t from, std::uint32_t corners_kept,
                        const Polygon& other) {
    for (std::uint32_t k = 0; k < corners_kept; ++k) {
      polygon.first[k + 1] = first[wrapped(from + k)];
      polygon.second[k + 1] = second[wrapped(from + k)];
    }
    polygon.first[corners_kept + 1] = other.first[0];
    polygon.second[corners_kept + 1] = other.second[0];
    polygon.corners = corners_kept + 2;
  };
  std::copy(low.corner, low.corner + 4, high.corner);
  for (const int k : {0, 1}) std::copy(low.edge[k], low.edge[k] + 4, high.edge[k]);
  crossing(begin, low);
  crossing(end, high);
  fill(low, begin, count, high);
  fill(high, end, corners - count, low);
  above = item;
  above.polygon = static_cast<std::uint32_t>(polygon_.size() - 1);
  close(low, item);
  close(high, above);
  low.area = std::min(area_of(low), whole);
  high.area = whole - low.area;
  high.density = low.density;
  // Parts without area hold nothing: their masses are 0.
  item.mass = above.mass * static_cast<double>(low.area / whole);
  above.mass -= item.mass;
  return true;
}

// Moves mass from what lies next to the plane to the other side, as it is. Rarely called for: where faces
// jump over the plane, or lie closer together than float can tell.
void ClippedPieces::even_out(List& from, List& to, bool upwards, std::size_t axis, float at, double amount,
                             double tolerance) {
  if (amount <= tolerance) return;
  const auto item = [&](std::uint32_t i) -> Item& { return item_[from.first + i]; };
  std::vector<std::uint32_t> order(from.count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return upwards ? item(a).high[axis] > item(b).high[axis] : item(a).low[axis] < item(b).low[axis];
  });
  std::vector<Item> moved;
  for (std::size_t i = 0; i < order.size() && amount > tolerance; ++i) {
    Item& next = item(order[i]);
    moved.push_back(next);
    if (next.mass <= amount) {
      amount -= next.mass;
      next.mass = 0;
      continue;
    }
    moved.back().mass = amount;
    next.mass -= amount;
    amount = 0;
    const Polygon copy = polygon_[next.polygon];
    moved.back().polygon = static_cast<std::uint32_t>(polygon_.size());
    polygon_.push_back(copy);
    for (const Item* const half : {&next, &moved.back()}) {
      Polygon& polygon = polygon_[half->polygon];
      polygon.density = static_cast<float>(half->mass / static_cast<double>(polygon.area));
    }
    // A sliver by its mass, which shall not make the node wide.
    moved.back().low[axis] = moved.back().high[axis] = at;
  }
  const auto begin = item_.begin() + static_cast<std::ptrdiff_t>(from.first);
  from.count = static_cast<std::size_t>(std::remove_if(begin, begin + static_cast<std::ptrdiff_t>(from.count),
                                                       [](const Item& left) { return !(left.mass > 0); }) -
                                        begin);
  if (to.first + to.count != item_.size()) to = joined(to, {});
  item_.insert(item_.end(), moved.begin(), moved.end());
  to.count += moved.size();
}

ClippedPieces::List ClippedPieces::joined(List first, List second) {
  const List both{item_.size(), first.count + second.count};
  item_.reserve(item_.size() + both.count);
  for (const List& list : {first, second})
    for (std::size_t i = 0; i < list.count; ++i) item_.push_back(item_[list.first + i]);
  return both;
}

bool ClippedPieces::has_room_to_clip(List list) const {
  constexpr std::size_t spare = 64;  // for polygons that lie on both sides of a plane, one a level
  return room_ == Room::one_cut || (polygon_.size() + list.count + spare <= polygon_.capacity() &&
                                    item_.size() + list.count + spare <= item_.capacity());
}

std::pair<ClippedPieces::List, ClippedPieces::List> ClippedPieces::cut(List list, const Extent& extent,
                                                                       double target, double cell) {
  const std::size_t axis = extent.axis;
  // Shares are of what the node has: what a large one lacks is spread over its cells.
  const double few_cells = std::sqrt(cell * extent.mass), tolerance = cut_tolerance * few_cells;
  const float at = plane(list, extent, target, few_cells, near_cut);
  // The longer part stays at the front of the list, the other one goes behind all others: so all that the
  // nodes above this one hold besides is no more than the triangles once again, wherever most of them lie.
  std::size_t count_below = 0;
  for (std::size_t i = 0; i < list.count; ++i) {
    const Item& item = item_[list.first + i];
    count_below += item.low[axis] + item.high[axis] < 2 * at ? 1 : 0;
  }
  const bool lower_stays = 2 * count_below >= list.count, clips = has_room_to_clip(list);
  List stays{list.first, 0}, goes{item_.size(), 0};
  const auto keep = [&](const Item& item, bool is_lower) {
    if (!(item.mass > 0)) return;
    if (is_lower == lower_stays)
      item_[stays.first + stays.count++] = item;
    else
      item_.push_back(item);
  };
  double mass = 0;  // of the lower part
  for (std::size_t i = 0; i < list.count; ++i) {
    Item item = item_[list.first + i];
    const float low = item.low[axis], high = item.high[axis];
    Item above;
    const bool is_clipped = clips && low < at && high > at && clip(item, axis, at, above);
    const bool is_lower = is_clipped || low + high < 2 * at;
    keep(item, is_lower);
    if (is_lower) mass += item.mass;
    if (is_clipped) keep(above, false);
  }
  goes.count = item_.size() - goes.first;
  List lower = lower_stays ? stays : goes, upper = lower_stays ? goes : stays;
  if (mass > target)
    even_out(lower, upper, true, axis, at, mass - target, tolerance);
  else
    even_out(upper, lower, false, axis, at, target - mass, tolerance);
  return {lower, upper};
}

std::size_t ClippedPieces::cross(List list, const Extent& extent, double share) {
  const std::size_t axis = extent.axis, b = (axis + 1) % 3, c = (axis + 2) % 3;
  const float at = plane(list, extent, share * extent.mass, extent.mass, near_section);
  section_.clear();
  float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  float nearest = INFINITY;
  nearest_ = item_[list.first];
  for (std::size_t i = 0; i < list.count; ++i) {
    const Item& item = item_[list.first + i];
    if (!(item.low[axis] < at && item.high[axis] > at)) {
      if (const float distance = std::max(item.low[axis] - at, at - item.high[axis]); distance < nearest) {
        nearest = distance;
        nearest_ = item;
      }
      continue;
    }
    const Polygon& polygon = polygon_[item.polygon];
    const float across_first = polygon.edge[0][axis], across_second = polygon.edge[1][axis];
    const auto distance = [&](std::uint32_t k) {
      return at - polygon.corner[axis] - polygon.first[k] * across_first - polygon.second[k] * across_second;
    };
    Segment segment;
    segment.name = item.name;
    int ends = 0;
    float from = distance(0);
    for (std::uint32_t k = 0; k < polygon.corners && ends < 2; ++k) {
      const float to = distance(k + 1);
      if ((from < 0) != (to < 0)) {
        const float part = from / (from - to);
        segment.end[ends][0] = polygon.first[k] + part * (polygon.first[k + 1] - polygon.first[k]);
        segment.end[ends][1] = polygon.second[k] + part * (polygon.second[k + 1] - polygon.second[k]);
        ++ends;
      }
      from = to;
    }
    if (ends < 2) {  // by rounding
      nearest = 0;
      nearest_ = item;
      continue;
    }
    // As in below(): how the area of weights grows.
    const bool by_first = std::abs(across_second) >= std::abs(across_first);
    const std::size_t w = by_first ? 0 : 1;
    segment.rate = static_cast<double>(polygon.density) *
                   static_cast<double>(std::abs((segment.end[1][w] - segment.end[0][w]) /
                                                (by_first ? across_second : across_first)));
    if (!(segment.rate > 0)) {
      nearest = 0;
      nearest_ = item;
      continue;
    }
    for (std::size_t end = 0; end < 2; ++end) {
      const Point place = place_at(polygon, {segment.end[end][0], segment.end[end][1]});
      segment.place[end][0] = place[b];
      segment.place[end][1] = place[c];
      for (std::size_t k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], segment.place[end][k]);
        high[k] = std::max(high[k], segment.place[end][k]);
      }
    }
    section_.push_back(segment);
  }
  const std::size_t k = high[1] - low[1] > high[0] - low[0] ? 1 : 0;
  for (Segment& segment : section_) {
    if (segment.place[1][k] >= segment.place[0][k]) continue;
    std::swap(segment.end[0], segment.end[1]);
    std::swap(segment.place[0], segment.place[1]);
  }
  std::sort(section_.begin(), section_.end(), [k](const Segment& a, const Segment& other) {
    return a.place[0][k] + a.place[1][k] < other.place[0][k] + other.place[1][k];
  });
  return k == 1 ? c : b;
}

namespace {

// Weights that rounding may have moved off the triangle.
CellPoint inside(std::uint32_t name, float first, float second) {
  first = std::max(first, 0.0f);
  second = std::max(second, 0.0f);
  const float over = std::max(first + second, 1.0f);
  return {name, first / over, second / over};
}

}  // namespace

CellPoint ClippedPieces::point(double share, double spare) const {
  if (section_.empty()) {
    const auto weights = weights_in(polygon_[nearest_.polygon], spare, share);
    return inside(nearest_.name, weights[0], weights[1]);
  }
  double total = 0;
  for (const Segment& segment : section_) total += segment.rate;
  double left = share * total;
  std::size_t i = 0;
  while (i + 1 < section_.size() && left >= section_[i].rate) left -= section_[i++].rate;
  const Segment& segment = section_[i];
  const auto along = static_cast<float>(std::min(left / segment.rate, 1.0));
  return inside(segment.name, segment.end[0][0] + along * (segment.end[1][0] - segment.end[0][0]),
                segment.end[0][1] + along * (segment.end[1][1] - segment.end[0][1]));
}

}  // namespace meander
