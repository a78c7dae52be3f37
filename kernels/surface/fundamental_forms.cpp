#include "kernels/surface/fundamental_forms.h"

#include <algorithm>
#include <cmath>

namespace meander {

namespace {

// The share (EG - F^2) / max(E, G)^2 below which rounding alone decides the curvature.
constexpr double degenerate_share = 1e-24;

}  // namespace

double area_element(Vector3 du, Vector3 dv) {
  const double area = norm(cross(du, dv));
  return std::isfinite(area) ? area : 0.0;
}

Vector3 unit_normal(Vector3 du, Vector3 dv) {
  const Vector3 n = cross(du, dv);
  const double length = norm(n);
  return length > 0 && std::isfinite(length) ? (1 / length) * n : Vector3{};
}

FundamentalForms fundamental_forms(const SurfaceJet& jet) {
  FundamentalForms forms;
  const auto finite = [](double value) { return std::isfinite(value) ? value : 0.0; };
  forms.E = finite(dot(jet.du, jet.du));
  forms.F = finite(dot(jet.du, jet.dv));
  forms.G = finite(dot(jet.dv, jet.dv));
  forms.area_element = area_element(jet.du, jet.dv);
  if (!(forms.area_element > 0)) return forms;
  forms.normal = unit_normal(jet.du, jet.dv);
  const double determinant = forms.area_element * forms.area_element, longer = std::max(forms.E, forms.G);
  if (!(determinant > degenerate_share * longer * longer)) return forms;
  const double L = dot(jet.duu, forms.normal), M = dot(jet.duv, forms.normal), N = dot(jet.dvv, forms.normal);
  const double mean = (forms.E * N - 2 * forms.F * M + forms.G * L) / (2 * determinant);
  const double gaussian = (L * N - M * M) / determinant;
  if (!std::isfinite(mean) || !std::isfinite(gaussian)) return forms;
  const double root = std::sqrt(std::max(0.0, mean * mean - gaussian));
  forms.L = L;
  forms.M = M;
  forms.N = N;
  forms.mean = mean;
  forms.gaussian = gaussian;
  forms.k1 = mean + root;
  forms.k2 = mean - root;
  return forms;
}

}  // namespace meander
