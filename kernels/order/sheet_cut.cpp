#include "kernels/order/sheet_cut.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace meander {

namespace {

constexpr double least_spread = 0.3;  // of normals, in a stack of two sides
constexpr double thinness = 0.25;     // variance across a stack over that within it
constexpr std::size_t least_probes = 8;
constexpr float least_gap = 0.15f;  // between layers, over the whole height
constexpr float gap_over_mean = 6;  // over the mean distance of heights

// Neighbours in the two sheets, squared: within the sheets, over the variance there; and across them, over
// the area of a share (a stack thicker than that needs no telling apart).
constexpr double most_apart = 0.5;
constexpr double most_offset = 0.125;
constexpr double least_offset = 1e-12;  // squared; coordinates are known to 2^-24
// Times these, by few probes: on a real collection 3 % of the stacks are lost by them, and 60 % of what is
// none is known before many probes are compared.
constexpr double few_apart = 5.6, few_offset = 2.8;

using Symmetric = std::array<double, 6>;  // xx, xy, xz, yy, yz, zz
using Vector = std::array<double, 3>;

template <class Get>
Vector mean_of(const std::vector<SheetProbe>& probes, const Get& get) {
  Vector mean{};
  for (const SheetProbe& probe : probes)
    for (std::size_t k = 0; k < 3; ++k) mean[k] += static_cast<double>(get(probe)[k]);
  for (double& x : mean) x /= static_cast<double>(probes.size());
  return mean;
}

template <class Get>
Symmetric covariance_of(const std::vector<SheetProbe>& probes, const Get& get) {
  const Vector mean = mean_of(probes, get);
  Symmetric covariance{};
  for (const SheetProbe& probe : probes) {
    Vector v;
    for (std::size_t k = 0; k < 3; ++k) v[k] = static_cast<double>(get(probe)[k]) - mean[k];
    covariance[0] += v[0] * v[0];
    covariance[1] += v[0] * v[1];
    covariance[2] += v[0] * v[2];
    covariance[3] += v[1] * v[1];
    covariance[4] += v[1] * v[2];
    covariance[5] += v[2] * v[2];
  }
  for (double& x : covariance) x /= static_cast<double>(probes.size());
  return covariance;
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

// What looks like a stack, until it is known how its parts lie.
struct Candidate {
  SheetCut cut;
  Vector direction{};  // across the sheets
  double width = 0;    // variance of the positions within the sheets
  double offset = -1;  // squared distance of the layers at the cut; negative for sides
};

// Between the layers on both sides of the gap nearest to the middle, if there is a clear one.
bool find_layers(SheetScratch& scratch, Candidate& candidate) {
  SheetCut& cut = candidate.cut;
  cut = {rounded(candidate.direction), 0, false};
  std::vector<float>& height = scratch.height;
  height.clear();
  for (const SheetProbe& p : scratch.probes)
    height.push_back(cut.direction[0] * p.at[0] + cut.direction[1] * p.at[1] + cut.direction[2] * p.at[2]);
  std::sort(height.begin(), height.end());
  const float range = height.back() - height.front();
  const float clear = std::max(least_gap * range, gap_over_mean * range / static_cast<float>(height.size()));
  std::size_t best = 0;
  float nearest = INFINITY;
  for (std::size_t i = 1; i < height.size(); ++i) {
    if (!(height[i] - height[i - 1] > clear)) continue;
    const float from_middle = std::abs(static_cast<float>(i) - 0.5f * static_cast<float>(height.size()));
    if (from_middle >= nearest) continue;
    nearest = from_middle;
    best = i;
  }
  if (best == 0) return false;
  cut.threshold = 0.5f * (height[best - 1] + height[best]);
  const double gap = static_cast<double>(height[best]) - static_cast<double>(height[best - 1]);
  candidate.offset = gap * gap;
  return true;
}

std::optional<Candidate> find_candidate(SheetScratch& scratch) {
  const std::vector<SheetProbe>& probes = scratch.probes;
  if (probes.size() < least_probes) return std::nullopt;
  const auto normal = [](const SheetProbe& p) { return p.normal; };
  const Vector mean_normal = mean_of(probes, normal);
  const double agreement = dot(mean_normal, mean_normal);
  const Symmetric covariance = covariance_of(probes, [](const SheetProbe& p) { return p.at; });
  const double trace = covariance[0] + covariance[3] + covariance[5];
  Candidate candidate;
  const auto is_thin = [&](double share, double width) {
    return dot(candidate.direction, product(covariance, candidate.direction)) < thinness * share * width;
  };
  // The second largest eigenvalue is at most half of the trace: most nodes are no candidates whatever it is.
  const double most_width = 0.5 * trace * (1 + 1e-9);
  double share = 1;
  if (1 - agreement > least_spread) {
    share = largest_eigenvalue(covariance_of(probes, normal), candidate.direction);
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
  scratch.above.clear();
  scratch.below.clear();
  const std::array<float, 3>& origin = scratch.probes.front().at;
  for (const SheetProbe& probe : scratch.probes) {
    Vector at;
    for (std::size_t k = 0; k < 3; ++k)
      at[k] = static_cast<double>(probe.at[k]) - static_cast<double>(origin[k]);
    const FlatProbe flat{static_cast<float>(dot(at, u)), static_cast<float>(dot(at, v)),
                         static_cast<float>(dot(at, d))};
    (cut.is_above(probe.at, probe.normal) ? scratch.above : scratch.below).push_back(flat);
  }
  Overlap sum;
  if (scratch.above.empty() || scratch.below.empty()) return {INFINITY, INFINITY};
  for (const FlatProbe& above : scratch.above) {
    // The nearest four, by their squared distance within the sheets and then across them.
    struct Found {
      float within, across;
      bool operator<(const Found& b) const {
        return within < b.within || (within == b.within && across < b.across);
      }
    };
    std::array<Found, 4> nearest;
    nearest.fill({INFINITY, INFINITY});
    for (const FlatProbe& below : scratch.below) {
      const float x = above.u - below.u, y = above.v - below.v;
      const float within = x * x + y * y;
      if (within > nearest.back().within) continue;
      const float height = above.height - below.height;
      const Found found{within, height * height};
      if (!(found < nearest.back())) continue;
      nearest.back() = found;
      for (std::size_t i = nearest.size() - 1; i > 0 && nearest[i] < nearest[i - 1]; --i)
        std::swap(nearest[i], nearest[i - 1]);
    }
    float offset = INFINITY;
    for (const Found& found : nearest) offset = std::min(offset, found.across);
    sum.offset += static_cast<double>(offset);
    sum.apart += static_cast<double>(nearest.front().within);
  }
  const auto count = static_cast<double>(scratch.above.size());
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
