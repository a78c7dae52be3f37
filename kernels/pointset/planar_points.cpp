#include "kernels/pointset/planar_points.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/pointset/curve_point.h"
#include "kernels/pointset/iterative_points.h"
#include "kernels/sample/place_samples.h"

namespace meander {

namespace {

constexpr double below_one = 1.0 - 0x1p-53;
constexpr std::uint64_t shift_index = ~std::uint64_t{0};  // of numbers that all points share; points use lower ones

PlanarPoints points_of(std::uint32_t count) {
  PlanarPoints points;
  points.x.resize(count);
  points.y.resize(count);
  return points;
}

// point(i) gives the coordinates of point i.
template <class Point>
PlanarPoints by_index(std::uint32_t count, const Point& point) {
  PlanarPoints points = points_of(count);
  parallel_blocks(count, sum_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const CurvePoint p = point(static_cast<std::uint32_t>(i));
      points.x[i] = std::min(p.u, below_one);
      points.y[i] = std::min(p.v, below_one);
    }
  });
  return points;
}

PlanarPoints jittered(std::uint32_t count, RandomKey key) {
  const auto columns = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(count)) + 0.5);
  PlanarPoints points = points_of(count);
  for (std::uint64_t column = 0; column < columns; ++column) {
    const auto first = static_cast<std::uint32_t>(column * count / columns);
    const auto last = static_cast<std::uint32_t>((column + 1) * count / columns);
    for (std::uint32_t i = first; i < last; ++i) {
      const UnitPair p = random_pair(key, Stream::point_set, i);
      points.x[i] = std::min((first + p.first * (last - first)) / count, below_one);
      points.y[i] = std::min((i - first + p.second) / (last - first), below_one);
    }
  }
  return points;
}

// Nested uniform scrambling (Owen 1995) of a 32-bit fraction: whether a digit flips depends, at random, on
// all digits above it. The digits below the 32nd are random.
double scramble(std::uint32_t fraction, std::uint64_t seed, double rest) {
  std::uint32_t scrambled = 0;
  for (int level = 0; level < 32; ++level) {
    // The node of the tree: a 1 in front of the digits above this one.
    const std::uint64_t node =
        std::uint64_t{1} << level | (level == 0 ? 0 : static_cast<std::uint64_t>(fraction) >> (32 - level));
    std::uint64_t hash = seed + node * 0x9E3779B97F4A7C15u;  // SplitMix64 finaliser (Steele, Lea, Flood 2014)
    hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9u;
    hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBu;
    const std::uint32_t digit = fraction >> (31 - level) & 1u;
    scrambled = scrambled << 1 | (digit ^ static_cast<std::uint32_t>((hash ^ (hash >> 31)) & 1u));
  }
  return (scrambled + rest) * 0x1p-32;
}

PlanarPoints scrambled_sobol(std::uint32_t count, RandomKey key) {
  const PhiloxBlock words = random_words(key, Stream::point_set, shift_index);
  const std::uint64_t seed_x = static_cast<std::uint64_t>(words[0]) << 32 | words[1];
  const std::uint64_t seed_y = static_cast<std::uint64_t>(words[2]) << 32 | words[3];
  return by_index(count, [&](std::uint32_t i) {
    const std::array<std::uint32_t, 2> point = sobol_words(i);
    const UnitPair rest = random_pair(key, Stream::point_set, i);
    return CurvePoint{scramble(point[0], seed_x, rest.first), scramble(point[1], seed_y, rest.second)};
  });
}

PlanarPoints along_curve(CurveKind curve, SequenceKind sequence, std::uint32_t count, RandomKey key) {
  const std::vector<double> t = sample_sequence(sequence, count, PlaceParameters{}.jitter, key);
  return by_index(count, [&](std::uint32_t i) { return curve_point(curve, t[i]); });
}

PlanarPoints at_leaves(std::uint32_t count, double leaves_per_point, RandomKey key) {
  int level = 0;
  while (std::ldexp(1.0, 2 * level) < leaves_per_point * count) ++level;
  const double leaves = std::ldexp(1.0, 2 * level);
  const std::vector<double> t = sample_sequence(SequenceKind::stratified, count, 0, key);
  return by_index(count, [&](std::uint32_t i) {
    return curve_cell_center(CurveKind::hilbert, static_cast<std::uint64_t>(t[i] * leaves), level);
  });
}

}  // namespace

std::optional<PlanarMethod> planar_method(std::string_view name) {
  const auto at = std::find(planar_method_names.begin(), planar_method_names.end(), name);
  if (at == planar_method_names.end()) return {};
  return static_cast<PlanarMethod>(at - planar_method_names.begin());
}

bool is_deterministic(PlanarMethod method) {
  switch (method) {
    case PlanarMethod::halton:
    case PlanarMethod::hammersley:
    case PlanarMethod::sobol:
    case PlanarMethod::r2:
    case PlanarMethod::hilbert_regular:
      return true;
    default:
      return false;
  }
}

double radical_inverse(std::uint32_t base, std::uint32_t index) {
  // Digits mirrored as an integer and divided once, so that the value is rounded once.
  std::uint64_t mirrored = 0;
  double scale = 1;
  for (; index > 0; index /= base) {
    mirrored = mirrored * base + index % base;
    scale *= base;
  }
  return std::min(static_cast<double>(mirrored) / scale, below_one);
}

std::array<std::uint32_t, 2> sobol_words(std::uint32_t index) {
  // Dimension 1: van der Corput. Dimension 2: primitive polynomial x + 1, m_1 = 1, so m_k = 2 m_{k-1} xor
  // m_{k-1}; as fractions: direction k is direction k - 1 xor the same one place to the right.
  std::array<std::uint32_t, 2> point{};
  std::uint32_t first = 0x80000000u, second = 0x80000000u;
  for (std::uint32_t gray = index ^ index >> 1; gray != 0; gray >>= 1) {
    if ((gray & 1) != 0) {
      point[0] ^= first;
      point[1] ^= second;
    }
    first >>= 1;
    second ^= second >> 1;
  }
  return point;
}

PlanarPoints planar_points(PlanarMethod method, std::uint32_t count, std::uint64_t seed,
                           const PlanarParameters& parameters) {
  if (!(parameters.leaves_per_point >= 1 && parameters.leaves_per_point <= 4096))
    throw std::invalid_argument("leaves_per_point must be in 1 .. 4096");
  if (parameters.lloyd_iterations > 10000)
    throw std::invalid_argument("lloyd_iterations must be in 0 .. 10000");
  const RandomKey key = make_random_key(seed, {});
  if (count == 0) return {};
  switch (method) {
    case PlanarMethod::random:
      return by_index(count, [&](std::uint32_t i) {
        const UnitPair p = random_pair(key, Stream::point_set, i);
        return CurvePoint{p.first, p.second};
      });
    case PlanarMethod::jittered:
      return jittered(count, key);
    case PlanarMethod::halton:
      return by_index(count, [](std::uint32_t i) {
        return CurvePoint{radical_inverse(2, i + 1), radical_inverse(3, i + 1)};
      });
    case PlanarMethod::hammersley:
      return by_index(count, [&](std::uint32_t i) {
        return CurvePoint{(i + 0.5) / count, radical_inverse(2, i)};
      });
    case PlanarMethod::sobol:
      return by_index(count, [](std::uint32_t i) {
        const std::array<std::uint32_t, 2> point = sobol_words(i);
        return CurvePoint{point[0] * 0x1p-32, point[1] * 0x1p-32};
      });
    case PlanarMethod::sobol_owen:
      return scrambled_sobol(count, key);
    case PlanarMethod::r2:
      return by_index(count, [](std::uint32_t i) {
        constexpr double g = 1.32471795724474602596;
        const double x = 0.5 + (i + 1.0) / g, y = 0.5 + (i + 1.0) / (g * g);
        return CurvePoint{x - std::floor(x), y - std::floor(y)};
      });
    case PlanarMethod::hilbert_stratified:
      return along_curve(CurveKind::hilbert, SequenceKind::stratified, count, key);
    case PlanarMethod::hilbert_shifted:
      return along_curve(CurveKind::hilbert, SequenceKind::shifted, count, key);
    case PlanarMethod::hilbert_regular:
      return along_curve(CurveKind::hilbert, SequenceKind::regular, count, key);
    case PlanarMethod::hilbert_owen:
      return along_curve(CurveKind::hilbert, SequenceKind::owen, count, key);
    case PlanarMethod::peano_stratified:
      return along_curve(CurveKind::peano, SequenceKind::stratified, count, key);
    case PlanarMethod::peano_meander_stratified:
      return along_curve(CurveKind::peano_meander, SequenceKind::stratified, count, key);
    case PlanarMethod::hilbert_vertex:
      return at_leaves(count, parameters.leaves_per_point, key);
    case PlanarMethod::poisson_disk:
      return poisson_disk_points(count, key);
    case PlanarMethod::lloyd:
      break;
  }
  return centroidal_points(jittered(count, key), parameters.lloyd_iterations);
}

}  // namespace meander
