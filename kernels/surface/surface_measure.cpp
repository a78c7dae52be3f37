#include "kernels/surface/surface_measure.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "kernels/core/ordered_blocks.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/status.h"
#include "kernels/surface/fundamental_forms.h"

namespace meander {

namespace {

constexpr std::size_t quantile_grid = 128;
constexpr std::size_t warp_grid = 256;
constexpr int warp_levels = 6;  // Hilbert levels: 64 x 64 cells, 81 x 81 for the Peano curves
// The share of the plain square in the warp, so that no part of the surface shrinks to nothing.
constexpr double warp_floor = 0.02;
// Curvature x diagonal that rounding may leave on a flat surface.
constexpr double flat_curvature = 1e-9;
// Negative densities down to this are rounding (1 + cos at its zeros), not mistakes.
constexpr double rounding = 1e-12;

bool is_curvature(SurfaceDensityKind kind) {
  return kind == SurfaceDensityKind::mean || kind == SurfaceDensityKind::gaussian ||
         kind == SurfaceDensityKind::max;
}

// n x n points at the middles of cells.
struct Midpoints {
  std::vector<double> s, t;
  explicit Midpoints(std::size_t n) : s(n * n), t(n * n) {
    for (std::size_t k = 0; k < n * n; ++k) {
      s[k] = (static_cast<double>(k / n) + 0.5) / static_cast<double>(n);
      t[k] = (static_cast<double>(k % n) + 0.5) / static_cast<double>(n);
    }
  }
};

// The inverse, at k / cells, of the distribution with these weights on equal intervals of [0, 1], mixed with
// a little of the uniform distribution.
void inverse_distribution(std::span<const double> weights, std::size_t cells, std::span<double> inverse) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const auto count = static_cast<double>(weights.size());
  const double even = 1 / count;
  std::size_t at = 0;
  double below = 0;
  const auto share = [&](std::size_t i) {
    return total > 0 ? (1 - warp_floor) * weights[i] / total + warp_floor * even : even;
  };
  for (std::size_t k = 0; k <= cells; ++k) {
    const double target = static_cast<double>(k) / static_cast<double>(cells);
    while (at + 1 < weights.size() && below + share(at) <= target) below += share(at++);
    inverse[k] = std::min(1.0, (static_cast<double>(at) + (target - below) / share(at)) * even);
  }
  inverse[0] = 0;
  inverse[cells] = 1;
}

}  // namespace

SquareWarp::Image SquareWarp::operator()(double s, double t) const {
  const auto n = static_cast<double>(cells);
  const double i = std::min(std::floor(s * n), n - 1), j = std::min(std::floor(t * n), n - 1);
  const double a = s * n - i, b = t * n - j;
  const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
  const double* low = &v[row * (cells + 1) + column];
  const double* high = low + cells + 1;
  const double left = low[0] + a * (high[0] - low[0]), right = low[1] + a * (high[1] - low[1]);
  const double du = u[row + 1] - u[row];
  return {u[row] + a * du, left + b * (right - left), n * du * n * (right - left)};
}

SurfaceMeasure::SurfaceMeasure(const ParametricSurface& surface, const SurfaceSampleParameters& parameters,
                               const CancelToken& cancel)
    : surface_(surface), density_(parameters.density) {
  if (density_.kind == SurfaceDensityKind::expression) expression_.emplace(density_.expression);
  find_diagonal();
  if (is_curvature(density_.kind)) find_reference_curvature(cancel);
  if (parameters.reparameterize) warp_ = make_warp(parameters.curve == CurveKind::hilbert ? 64 : 81, cancel);
}

int SurfaceMeasure::warp_depth() const { return warp_ ? warp_levels : 0; }

void SurfaceMeasure::find_diagonal() {
  constexpr std::size_t n = 33;
  std::vector<double> u(n * n), v(n * n);
  for (std::size_t k = 0; k < n * n; ++k) {
    u[k] = static_cast<double>(k / n) / static_cast<double>(n - 1);
    v[k] = static_cast<double>(k % n) / static_cast<double>(n - 1);
  }
  std::vector<Vector3> p(n * n);
  surface_.positions(u, v, p);
  Vector3 low = p[0], high = p[0];
  for (const Vector3& q : p) {
    low = {std::min(low.x, q.x), std::min(low.y, q.y), std::min(low.z, q.z)};
    high = {std::max(high.x, q.x), std::max(high.y, q.y), std::max(high.z, q.z)};
  }
  box_ = {low.x, low.y, low.z, high.x, high.y, high.z};
  diagonal_ = distance(low, high);
}

double SurfaceMeasure::curvature(const SurfaceJet& jet) const {
  const FundamentalForms forms = fundamental_forms(jet);
  if (density_.kind == SurfaceDensityKind::mean) return std::abs(forms.mean);
  if (density_.kind == SurfaceDensityKind::gaussian) return std::abs(forms.gaussian);
  return std::max(std::abs(forms.k1), std::abs(forms.k2));
}

// The quantile by area; where it is zero (a flat surface with a bent part), over the bent part alone.
void SurfaceMeasure::find_reference_curvature(const CancelToken& cancel) {
  const Midpoints grid(quantile_grid);
  std::vector<SurfaceJet> jets(grid.s.size());
  ordered_blocks(jets.size(), quantile_grid, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    surface_.jets(std::span(grid.s).subspan(begin, end - begin),
                  std::span(grid.t).subspan(begin, end - begin), std::span(jets).subspan(begin, end - begin));
  });
  const double flat = density_.kind == SurfaceDensityKind::gaussian ? flat_curvature / (diagonal_ * diagonal_)
                                                                    : flat_curvature / diagonal_;
  std::vector<std::pair<double, double>> bent;  // curvature and area
  double area = 0, bent_area = 0;
  for (const SurfaceJet& jet : jets) {
    const double element = area_element(jet.du, jet.dv), c = curvature(jet);
    area += element;
    if (!(c > flat)) continue;
    bent.emplace_back(c, element);
    bent_area += element;
  }
  if (!(bent_area > 0)) return;
  std::sort(bent.begin(), bent.end());
  double target = density_.quantile * area - (area - bent_area);
  if (!(target > 0)) target = density_.quantile * bent_area;
  double below = 0;
  for (const auto& [c, element] : bent) {
    below += element;
    reference_ = c;
    if (below >= target) break;
  }
}

SquareWarp SurfaceMeasure::make_warp(std::size_t cells, const CancelToken& cancel) const {
  constexpr std::size_t n = warp_grid;
  SquareWarp warp;
  warp.cells = cells;
  warp.u.resize(cells + 1);
  warp.v.resize((cells + 1) * (cells + 1));
  {
    const Midpoints grid(n);
    std::vector<double> weight(n);
    ordered_blocks(n, 1, [&](std::size_t row, std::size_t) {
      cancel.check();
      MeasureBatch batch;
      evaluate(std::span(grid.s).subspan(row * n, n), std::span(grid.t).subspan(row * n, n), batch);
      weight[row] = std::accumulate(batch.value.begin(), batch.value.end(), 0.0);
    });
    inverse_distribution(weight, cells, warp.u);
  }
  ordered_blocks(cells + 1, 1, [&](std::size_t k, std::size_t) {
    cancel.check();
    // The clamp keeps off the border, where a pole would have no measure.
    const double u = std::clamp(warp.u[k], 0.5 / n, 1 - 0.5 / n);
    const std::vector<double> s(n, u);
    std::vector<double> t(n);
    for (std::size_t j = 0; j < n; ++j) t[j] = (static_cast<double>(j) + 0.5) / n;
    MeasureBatch batch;
    evaluate(s, t, batch);
    inverse_distribution(batch.value, cells, std::span(warp.v).subspan(k * (cells + 1), cells + 1));
  });
  return warp;
}

void SurfaceMeasure::evaluate(std::span<const double> s, std::span<const double> t,
                              MeasureBatch& batch) const {
  const std::size_t n = s.size();
  batch.u.assign(s.begin(), s.end());
  batch.v.assign(t.begin(), t.end());
  batch.area.assign(n, 1.0);
  if (warp_)
    for (std::size_t i = 0; i < n; ++i) {
      const SquareWarp::Image image = (*warp_)(s[i], t[i]);
      batch.u[i] = image.u;
      batch.v[i] = image.v;
      batch.area[i] = image.jacobian;
    }
  batch.position.resize(n);
  batch.du_cross_dv.resize(n);
  batch.density.assign(n, 1.0);
  batch.value.resize(n);
  const auto take = [&](std::size_t i, const auto& at) {
    if (!std::isfinite(at.position.x + at.position.y + at.position.z))
      throw ItemError(Status::non_finite, "the surface is not finite at u = " + std::to_string(batch.u[i]) +
                                              ", v = " + std::to_string(batch.v[i]));
    batch.position[i] = at.position;
    batch.du_cross_dv[i] = cross(at.du, at.dv);
    const double element = norm(batch.du_cross_dv[i]);
    batch.area[i] = std::isfinite(element) ? batch.area[i] * element : 0.0;
  };
  if (is_curvature(density_.kind) && reference_ > 0) {
    batch.jets.resize(n);
    surface_.jets(batch.u, batch.v, batch.jets);
    for (std::size_t i = 0; i < n; ++i) {
      take(i, batch.jets[i]);
      const double share = std::min(1.0, curvature(batch.jets[i]) / reference_);
      batch.density[i] =
          density_.floor +
          (1 - density_.floor) * (density_.exponent == 1 ? share : portable::pow(share, density_.exponent));
    }
  } else {
    batch.tangents.resize(n);
    surface_.tangents(batch.u, batch.v, batch.tangents);
    for (std::size_t i = 0; i < n; ++i) take(i, batch.tangents[i]);
    if (expression_) evaluate_density(batch);
  }
  for (std::size_t i = 0; i < n; ++i) batch.value[i] = batch.area[i] * batch.density[i];
}

void SurfaceMeasure::evaluate_density(MeasureBatch& batch) const {
  const std::size_t n = batch.u.size();
  batch.x.resize(n);
  batch.y.resize(n);
  batch.z.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    batch.x[i] = batch.position[i].x;
    batch.y[i] = batch.position[i].y;
    batch.z[i] = batch.position[i].z;
  }
  const std::array<std::span<const double>, 5> inputs = {batch.u, batch.v, batch.x, batch.y, batch.z};
  expression_->evaluate(inputs, batch.density);
  for (std::size_t i = 0; i < n; ++i) {
    double& density = batch.density[i];
    if (!(batch.area[i] > 0) || (density < 0 && density >= -rounding)) density = 0;
    if (!(density >= 0) || !std::isfinite(density))
      throw ItemError(Status::unreadable,
                      "the density is " + std::to_string(density) + " at u = " + std::to_string(batch.u[i]) +
                          ", v = " + std::to_string(batch.v[i]) + "; it must be finite and not negative");
  }
}

}  // namespace meander
