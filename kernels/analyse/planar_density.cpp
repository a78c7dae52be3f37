#include "kernels/analyse/planar_density.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace meander {

namespace {

constexpr std::size_t legendre_nodes = 24;
struct Rule {
  std::array<double, legendre_nodes> at, weight;  // on [0, 1]
};

// Gauss-Legendre: roots of the Legendre polynomial by Newton's method from Chebyshev's guesses.
Rule make_rule() {
  Rule rule;
  for (std::size_t i = 0; i < legendre_nodes; ++i) {
    double z = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (legendre_nodes + 0.5)),
           slope = 1;
    for (int step = 0; step < 10; ++step) {
      double p = z, before = 1;
      for (std::size_t k = 2; k <= legendre_nodes; ++k) {
        const auto d = static_cast<double>(k);
        const double next = ((2 * d - 1) * z * p - (d - 1) * before) / d;
        before = p;
        p = next;
      }
      slope = legendre_nodes * (z * p - before) / (z * z - 1);
      z -= p / slope;
    }
    rule.at[i] = 0.5 * (1 - z);
    rule.weight[i] = 1 / ((1 - z * z) * slope * slope);
  }
  return rule;
}

template <class Function>
double integrate(double from, double to, const Function& f) {
  static const Rule rule = make_rule();
  double sum = 0;
  for (std::size_t i = 0; i < legendre_nodes; ++i) sum += rule.weight[i] * f(from + (to - from) * rule.at[i]);
  return (to - from) * sum;
}

double measure_of_box(PlanarDensity density, double a, double b) {
  switch (density) {
    case PlanarDensity::uniform:
      return a * b;
    case PlanarDensity::squares:
      return a * a * a * b * b * b / 9;
    case PlanarDensity::waves:
      // cos 3x cos xy integrated along x by the sum of the two angles; 3 - y >= 2.
      return a * b + integrate(0, b, [a](double y) {
               const double along =
                   std::sin((3 + y) * a) / (2 * (3 + y)) + std::sin((3 - y) * a) / (2 * (3 - y));
               return along * std::sin(3 * y);
             });
    case PlanarDensity::product_wave:
      break;
  }
  // The integral along x is sin(10 a y) / (10 y); the nodes are never at 0.
  return a * b + integrate(0, b, [a](double y) { return y > 0 ? std::sin(10 * a * y) / (10 * y) : a; });
}

}  // namespace

std::optional<PlanarDensity> planar_density(std::string_view name) {
  const auto at = std::find(planar_density_names.begin(), planar_density_names.end(), name);
  if (at == planar_density_names.end()) return {};
  return static_cast<PlanarDensity>(at - planar_density_names.begin());
}

double density_at(PlanarDensity density, double x, double y) {
  switch (density) {
    case PlanarDensity::uniform:
      return 1;
    case PlanarDensity::squares:
      return x * x * y * y;
    case PlanarDensity::waves:
      return std::cos(3 * x) * std::sin(3 * y) * std::cos(x * y) + 1;
    case PlanarDensity::product_wave:
      break;
  }
  return std::cos(10 * x * y) + 1;
}

double box_share(PlanarDensity density, double a, double b) {
  static const std::array<double, planar_density_names.size()> whole = [] {
    std::array<double, planar_density_names.size()> measures;
    for (std::size_t d = 0; d < measures.size(); ++d)
      measures[d] = measure_of_box(static_cast<PlanarDensity>(d), 1, 1);
    return measures;
  }();
  return measure_of_box(density, a, b) / whole[static_cast<std::size_t>(density)];
}

}  // namespace meander
