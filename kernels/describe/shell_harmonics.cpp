#include "kernels/describe/shell_harmonics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace meander {

namespace {

constexpr double pi = std::numbers::pi;

// The recurrence in l of the associated Legendre functions, normalized such that the harmonics are
// orthonormal and divided by sin^m theta:
//   P_mm constant,   P_lm = rise (z P_(l-1)m - fall P_(l-2)m).
// The sines and cosines of m phi carry the factor sin^m theta, so that they are polynomials of x and y and
// have no singularity at the poles.
class HarmonicRecurrence {
 public:
  explicit HarmonicRecurrence(std::uint32_t degree) : degree_(degree) {
    double sectoral = std::sqrt(0.25 / pi);
    for (std::uint32_t order = 0; order <= degree; ++order) {
      const double m = order;
      if (order > 0) sectoral *= std::sqrt((2 * m + 1) / (2 * m));
      sectoral_.push_back(order == 0 ? sectoral : std::numbers::sqrt2 * sectoral);
      for (std::uint32_t l = order + 1; l <= degree; ++l) {
        const double a = l, b = a - 1;
        rise_.push_back(std::sqrt((4 * a * a - 1) / (a * a - m * m)));
        fall_.push_back(l == order + 1 ? 0.0 : std::sqrt((b * b - m * m) / (4 * b * b - 1)));
      }
    }
  }

  std::size_t count() const { return (std::size_t{degree_} + 1) * (degree_ + 1); }

  void evaluate(Vector3 direction, std::span<double> values) const {
    double cosine = 1, sine = 0;  // of m phi, times sin^m theta
    std::size_t at = 0;
    for (std::uint32_t m = 0; m <= degree_; ++m) {
      if (m > 0) {
        const double turned = cosine * direction.x - sine * direction.y;
        sine = cosine * direction.y + sine * direction.x;
        cosine = turned;
      }
      double before = 0, here = sectoral_[m];
      for (std::uint32_t l = m; l <= degree_; ++l) {
        const std::size_t middle = std::size_t{l} * (l + 1);
        values[middle - m] = here * sine;  // overwritten for m = 0
        values[middle + m] = here * cosine;
        if (l == degree_) break;
        const double next = rise_[at] * (direction.z * here - fall_[at] * before);
        before = here;
        here = next;
        ++at;
      }
    }
  }

 private:
  std::uint32_t degree_;
  std::vector<double> sectoral_, rise_, fall_;  // rise_ and fall_ by order, then degree
};

Vector3 point_at(std::span<const float> points, std::size_t i) {
  return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}

struct Extent {
  Vector3 centroid;
  double mean = 0;  // distance from it
};

Extent extent_of(std::span<const float> points) {
  const std::size_t n = points.size() / 3;
  Extent extent;
  for (std::size_t i = 0; i < n; ++i) extent.centroid = extent.centroid + point_at(points, i);
  extent.centroid = (1 / static_cast<double>(n)) * extent.centroid;
  for (std::size_t i = 0; i < n; ++i) extent.mean += distance(point_at(points, i), extent.centroid);
  extent.mean /= static_cast<double>(n);
  return extent;
}

bool all_coincide(std::span<const float> points) {
  for (std::size_t i = 3; i < points.size(); ++i)
    if (points[i] != points[i - 3]) return false;
  return true;
}

// The coefficients of all shells: harmonic_shells x count.
std::vector<double> shell_coefficients(std::span<const float> points, const Extent& extent,
                                       const HarmonicRecurrence& recurrence, const CancelToken& cancel) {
  const std::size_t n = points.size() / 3, count = recurrence.count();
  const double per_shell = harmonic_shells / (harmonic_range * extent.mean);
  std::vector<double> coefficients(harmonic_shells * count), values(count);
  const auto add = [&](std::size_t shell, double weight) {
    double* const to = coefficients.data() + (shell - 1) * count;
    for (std::size_t k = 0; k < count; ++k) to[k] += weight * values[k];
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 4096 == 0) cancel.check();
    const Vector3 arm = point_at(points, i) - extent.centroid;
    const double radius = norm(arm);
    if (!(radius > 0)) continue;
    recurrence.evaluate((1 / radius) * arm, values);
    const double place = std::min<double>(radius * per_shell, harmonic_shells);
    const auto below = static_cast<std::size_t>(place);
    const double beyond = place - static_cast<double>(below);
    if (below > 0) add(below, 1 - beyond);
    if (beyond > 0) add(below + 1, beyond);
  }
  return coefficients;
}

}  // namespace

std::vector<double> spherical_harmonics(Vector3 direction, std::uint32_t degree) {
  const HarmonicRecurrence recurrence(degree);
  std::vector<double> values(recurrence.count());
  recurrence.evaluate(direction, values);
  return values;
}

std::vector<float> shell_harmonics(std::span<const float> points, const CancelToken& cancel) {
  if (points.empty() || points.size() % 3 != 0)
    throw std::invalid_argument("harmonics on shells need at least one point of three coordinates");
  if (!std::all_of(points.begin(), points.end(), [](float value) { return std::isfinite(value); }))
    throw std::invalid_argument("harmonics on shells: a coordinate is not finite");
  std::vector<float> norms(shell_harmonic_values);
  // The mean distance does not decide this, because the centroid of equal points is rounded.
  if (all_coincide(points)) {
    norms[0] = 1;
    return norms;
  }
  const HarmonicRecurrence recurrence(highest_harmonic_degree);
  const std::vector<double> coefficients = shell_coefficients(points, extent_of(points), recurrence, cancel);
  const double factor = std::sqrt(4 * pi) / (static_cast<double>(points.size()) / 3);
  auto coefficient = coefficients.begin();
  for (std::size_t shell = 0; shell < harmonic_shells; ++shell)
    for (std::size_t l = 0; l <= highest_harmonic_degree; ++l) {
      double squares = 0;
      for (std::size_t m = 0; m < 2 * l + 1; ++m, ++coefficient) squares += *coefficient * *coefficient;
      norms[shell * (highest_harmonic_degree + 1) + l] = static_cast<float>(factor * std::sqrt(squares));
    }
  return norms;
}

}  // namespace meander
