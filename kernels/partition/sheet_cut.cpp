#include "kernels/partition/sheet_cut.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "kernels/core/vector_instructions.h"

namespace meander {

namespace {

constexpr double least_spread = 0.3;  // of normals, in a stack of two sides
constexpr double thinness = 0.25;     // variance across a stack over that within it
constexpr std::size_t least_probes = 8;
constexpr float least_gap = 0.15f;  // between layers, over the whole height
constexpr float gap_over_mean = 6;  // over the mean distance of heights

// Neighbors in the two sheets, squared: within the sheets, over the variance there; and across them, over
// the area of a share (a stack thicker than that needs no telling apart).
constexpr double most_apart = 0.5;
constexpr double most_offset = 0.125;
constexpr double least_offset = 1e-12;  // squared; coordinates are known to 2^-24
// Times these, by few probes: on a real collection 3 % of the stacks are lost by them, and 60 % of what is
// none is known before many probes are compared.
constexpr double few_apart = 5.6, few_offset = 2.8;

using Symmetric = std::array<double, 6>;  // xx, xy, xz, yy, yz, zz
using Vector = std::array<double, 3>;

// The sum over `count` probes of what `term` gives for the four from i on.
template <class Term>
double sum_of(std::size_t count, const Term& term) {
  const __m128i lanes = _mm_setr_epi32(0, 1, 2, 3);
  __m128 sum = _mm_setzero_ps();
  for (std::size_t i = 0; i < count; i += 4) {
    const __m128i left = _mm_set1_epi32(static_cast<int>(count - i));
    sum = _mm_add_ps(sum, _mm_and_ps(term(i), _mm_castsi128_ps(_mm_cmplt_epi32(lanes, left))));
  }
  alignas(16) float sums[4];
  _mm_store_ps(sums, sum);
  return (static_cast<double>(sums[0]) + static_cast<double>(sums[1])) +
         (static_cast<double>(sums[2]) + static_cast<double>(sums[3]));
}

using Columns = std::array<SheetProbes::Column, 3>;

Vector mean_of(const Columns& v, std::size_t count) {
  Vector mean;
  for (std::size_t k = 0; k < 3; ++k)
    mean[k] =
        sum_of(count, [&](std::size_t i) { return _mm_loadu_ps(&v[k][i]); }) / static_cast<double>(count);
  return mean;
}

Symmetric covariance_of(const Columns& v, const Vector& mean, std::size_t count) {
  Symmetric covariance;
  std::size_t entry = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = j; k < 3; ++k) {
      const __m128 mean_j = _mm_set1_ps(static_cast<float>(mean[j])),
                   mean_k = _mm_set1_ps(static_cast<float>(mean[k]));
      covariance[entry++] = sum_of(count,
                                   [&](std::size_t i) {
                                     return _mm_mul_ps(_mm_sub_ps(_mm_loadu_ps(&v[j][i]), mean_j),
                                                       _mm_sub_ps(_mm_loadu_ps(&v[k][i]), mean_k));
                                   }) /
                            static_cast<double>(count);
    }
  }
  return covariance;
}

// The coordinates of the four probes from i on along a direction, from an origin.
__m128 along(const Columns& at, const std::array<float, 3>& direction, const std::array<float, 3>& origin,
             std::size_t i) {
  __m128 sum = _mm_setzero_ps();
  for (std::size_t k = 0; k < 3; ++k)
    sum = _mm_add_ps(sum, _mm_mul_ps(_mm_set1_ps(direction[k]),
                                     _mm_sub_ps(_mm_loadu_ps(&at[k][i]), _mm_set1_ps(origin[k]))));
  return sum;
}

Vector product(const Symmetric& m, const Vector& v) {
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
          m[2] * v[0] + m[4] * v[1] + m[5] * v[2]};
}

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The largest eigenvalue and its direction, by repeated squaring of the matrix (power iteration with 2^10
// steps).
double largest_eigenvalue(const Symmetric& m, Vector& direction) {
  Symmetric power = m;
  for (int i = 0; i < 10; ++i) {
    const double trace = power[0] + power[3] + power[5];
    if (!(trace > 0)) return 0;
    const double scale = 1 / trace;
    Symmetric p = power;
    for (double& x : p) x *= scale;
    power = {p[0] * p[0] + p[1] * p[1] + p[2] * p[2], p[0] * p[1] + p[1] * p[3] + p[2] * p[4],
             p[0] * p[2] + p[1] * p[4] + p[2] * p[5], p[1] * p[1] + p[3] * p[3] + p[4] * p[4],
             p[1] * p[2] + p[3] * p[4] + p[4] * p[5], p[2] * p[2] + p[4] * p[4] + p[5] * p[5]};
  }
  // The longest column of a matrix that is nearly of rank one.
  const std::array<Vector, 3> columns = {
      {{power[0], power[1], power[2]}, {power[1], power[3], power[4]}, {power[2], power[4], power[5]}}};
  std::size_t best = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (dot(columns[k], columns[k]) > dot(columns[best], columns[best])) best = k;
  const double length = std::sqrt(dot(columns[best], columns[best]));
  if (!(length > 0)) return 0;
  for (std::size_t k = 0; k < 3; ++k) direction[k] = columns[best][k] / length;
  return dot(direction, product(m, direction));
}

// The second largest eigenvalue of a covariance.
double middle_eigenvalue(const Symmetric& m) {
  Vector first{}, second{};
  const double largest = largest_eigenvalue(m, first);
  Symmetric rest = m;
  rest[0] -= largest * first[0] * first[0];
  rest[1] -= largest * first[0] * first[1];
  rest[2] -= largest * first[0] * first[2];
  rest[3] -= largest * first[1] * first[1];
  rest[4] -= largest * first[1] * first[2];
  rest[5] -= largest * first[2] * first[2];
  return std::max(0.0, largest_eigenvalue(rest, second));
}

std::array<float, 3> rounded(const Vector& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// A possible stack, until it is known how its parts lie.
struct Candidate {
  SheetCut cut;
  Vector direction{};  // across the sheets
  double width = 0;    // variance of the positions within the sheets
  double offset = -1;  // squared distance of the layers at the cut; negative for sides
};

// Between the layers on both sides of the gap nearest to the middle, if there is a clear one. Such a gap is
// wider than a bin, so it lies between the heights of different bins.
bool find_layers(SheetScratch& scratch, Candidate& candidate) {
  SheetCut& cut = candidate.cut;
  cut = {rounded(candidate.direction), 0, false};
  const std::size_t count = scratch.probes.size();
  SheetProbes::Column& height = scratch.height;
  for (std::size_t i = 0; i < count; i += 4)
    _mm_storeu_ps(&height[i], along(scratch.probes.at, cut.direction, {}, i));
  const auto [least, most] = std::minmax_element(&height[0], &height[0] + count);
  const float low = *least, range = *most - low;
  if (!(range > 0)) return false;
  const float clear = std::max(least_gap * range, gap_over_mean * range / static_cast<float>(count));
  constexpr int bins = 8;
  static_assert(least_gap * bins > 1);
  struct Bin {
    float least = INFINITY, most = -INFINITY;
    std::size_t count = 0;
  };
  std::array<Bin, bins> bin;
  for (std::size_t i = 0; i < count; ++i) {
    Bin& b = bin[static_cast<std::size_t>(
        std::min(static_cast<int>((height[i] - low) / range * static_cast<float>(bins)), bins - 1))];
    b.least = std::min(b.least, height[i]);
    b.most = std::max(b.most, height[i]);
    ++b.count;
  }
  float nearest = INFINITY, gap = 0, below = low;
  std::size_t lower = 0;  // probes in the bins before
  for (const Bin& b : bin) {
    if (b.count == 0) continue;
    const float from_middle = std::abs(static_cast<float>(lower) - 0.5f * static_cast<float>(count));
    if (b.least - below > clear && from_middle < nearest) {
      nearest = from_middle;
      gap = b.least - below;
      cut.threshold = 0.5f * (below + b.least);
    }
    below = b.most;
    lower += b.count;
  }
  candidate.offset = static_cast<double>(gap) * static_cast<double>(gap);
  return gap > 0;
}

std::optional<Candidate> find_candidate(SheetScratch& scratch) {
  const SheetProbes& probes = scratch.probes;
  const std::size_t count = probes.size();
  if (count < least_probes) return std::nullopt;
  const Vector mean_normal = mean_of(probes.normal, count);
  const double agreement = dot(mean_normal, mean_normal);
  const Symmetric covariance = covariance_of(probes.at, mean_of(probes.at, count), count);
  const double trace = covariance[0] + covariance[3] + covariance[5];
  Candidate candidate;
  const auto is_thin = [&](double share, double width) {
    return dot(candidate.direction, product(covariance, candidate.direction)) < thinness * share * width;
  };
  // The second largest eigenvalue is at most half of the trace: most nodes are no candidates whatever it is.
  const double most_width = 0.5 * trace * (1 + 1e-9);
  double share = 1;
  if (1 - agreement > least_spread) {
    const Symmetric of_normals = covariance_of(probes.normal, mean_normal, count);
    share = largest_eigenvalue(of_normals, candidate.direction);
    if (!(share > least_spread) || !is_thin(share, most_width)) return std::nullopt;
    candidate.cut = {rounded(candidate.direction), 0, true};
  } else {
    candidate.direction = mean_normal;
    for (double& x : candidate.direction) x /= std::sqrt(agreement);
    if (!is_thin(1, most_width) || !find_layers(scratch, candidate)) return std::nullopt;
  }
  candidate.width = middle_eigenvalue(covariance);
  if (!is_thin(share, candidate.width)) return std::nullopt;
  return candidate;
}

// How the elements above the cut lie to those below, in means of squares: the nearest seen along the
// direction, how far it is within the sheets; and of the nearest few, which may lie on several sheets, how
// far the least off is across them.
struct Overlap {
  double apart = 0, offset = 0;
};
Overlap overlap_of(SheetScratch& scratch, const Candidate& candidate) {
  const SheetCut& cut = candidate.cut;
  const Vector& d = candidate.direction;
  // Two directions within the sheets.
  const std::size_t least = std::abs(d[0]) < std::abs(d[1]) ? (std::abs(d[0]) < std::abs(d[2]) ? 0 : 2)
                                                            : (std::abs(d[1]) < std::abs(d[2]) ? 1 : 2);
  Vector u{};
  u[least] = 1;
  for (std::size_t k = 0; k < 3; ++k) u[k] -= d[least] * d[k];
  const double length = std::sqrt(dot(u, u));
  for (double& x : u) x /= length;
  const Vector v = {d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0]};
  const SheetProbes& probes = scratch.probes;
  const std::array<float, 3> origin = probes[0].at;
  scratch.above.count = scratch.below.count = 0;
  for (std::size_t i = 0; i < probes.size(); i += 4) {
    alignas(16) std::array<std::array<float, 4>, 3> flat;
    _mm_store_ps(flat[0].data(), along(probes.at, rounded(u), origin, i));
    _mm_store_ps(flat[1].data(), along(probes.at, rounded(v), origin, i));
    _mm_store_ps(flat[2].data(), along(probes.at, rounded(d), origin, i));
    for (std::size_t k = 0; k < std::min<std::size_t>(4, probes.size() - i); ++k) {
      const SheetProbe probe = probes[i + k];
      FlatProbes& side = cut.is_above(probe.at, probe.normal) ? scratch.above : scratch.below;
      side.u[side.count] = flat[0][k];
      side.v[side.count] = flat[1][k];
      side.height[side.count++] = flat[2][k];
    }
  }
  const FlatProbes &above = scratch.above, &below = scratch.below;
  if (above.count == 0 || below.count == 0) return {INFINITY, INFINITY};
  Overlap sum;
  for (std::size_t a = 0; a < above.count; ++a) {
    // The nearest four, by their squared distance within the sheets and then across them.
    struct Found {
      float within, across;
      bool operator<(const Found& b) const {
        return within < b.within || (within == b.within && across < b.across);
      }
    };
    std::array<Found, 4> nearest;
    nearest.fill({INFINITY, INFINITY});
    const __m128 at_u = _mm_set1_ps(above.u[a]), at_v = _mm_set1_ps(above.v[a]);
    for (std::size_t i = 0; i < below.count; i += 4) {
      const __m128 x = _mm_sub_ps(at_u, _mm_loadu_ps(&below.u[i])),
                   y = _mm_sub_ps(at_v, _mm_loadu_ps(&below.v[i]));
      const __m128 distance = _mm_add_ps(_mm_mul_ps(x, x), _mm_mul_ps(y, y));
      auto near =
          static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(distance, _mm_set1_ps(nearest.back().within))));
      if (near == 0) continue;
      alignas(16) std::array<float, 4> within;
      _mm_store_ps(within.data(), distance);
      for (; near != 0; near &= near - 1) {
        const auto k = static_cast<std::size_t>(std::countr_zero(near));
        if (i + k >= below.count) break;
        const float height = above.height[a] - below.height[i + k];
        const Found found{within[k], height * height};
        if (!(found < nearest.back())) continue;
        nearest.back() = found;
        for (std::size_t j = nearest.size() - 1; j > 0 && nearest[j] < nearest[j - 1]; --j)
          std::swap(nearest[j], nearest[j - 1]);
      }
    }
    float offset = INFINITY;
    for (const Found& found : nearest) offset = std::min(offset, found.across);
    sum.offset += static_cast<double>(offset);
    sum.apart += static_cast<double>(nearest.front().within);
  }
  const auto count = static_cast<double>(above.count);
  return {sum.apart / count, sum.offset / count};
}

// Squared distances over the most that a stack may have, for `leaves` leaves.
struct Excess {
  double apart, offset;
};
Excess excess_of(const Overlap& overlap, const Candidate& candidate, std::uint32_t leaves) {
  const bool layers = candidate.offset >= 0;
  // A square of variance w has the area 12 w; at least two of them are shared by the leaves.
  const double share = 24 * candidate.width / leaves;
  return {overlap.apart / (most_apart * candidate.width),
          (layers ? candidate.offset : overlap.offset) / (most_offset * share)};
}

}  // namespace

bool may_be_stack(SheetScratch& scratch, std::uint32_t leaves) {
  const std::optional<Candidate> candidate = find_candidate(scratch);
  if (!candidate) return false;
  const Overlap overlap = overlap_of(scratch, *candidate);
  const Excess excess = excess_of(overlap, *candidate, leaves);
  return excess.apart < few_apart && excess.offset < few_offset && overlap.offset > least_offset;
}

std::optional<SheetCut> find_sheet_cut(SheetScratch& scratch, std::uint32_t leaves) {
  const std::optional<Candidate> candidate = find_candidate(scratch);
  if (!candidate) return std::nullopt;
  const Overlap overlap = overlap_of(scratch, *candidate);
  const Excess excess = excess_of(overlap, *candidate, leaves);
  if (!(excess.apart < 1) || !(excess.offset < 1) || !(overlap.offset > least_offset)) return std::nullopt;
  return candidate->cut;
}

}  // namespace meander
