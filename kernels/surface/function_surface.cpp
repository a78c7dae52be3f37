#include "kernels/surface/function_surface.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "kernels/surface/digest_bytes.h"

namespace meander {

namespace {

// Steps of the differences: rounding and the next term of the series are about equal for a smooth surface.
constexpr double first_step = 0x1p-17, second_step = 0x1p-11;

double middle(double at, double step) { return std::clamp(at, step, 1 - step); }

// Three points in a row at a distance of `step`: derivatives of the parabola through them at `offset` from
// the middle.
Vector3 slope(const Vector3* f, double step, double offset) {
  return 0.5 / step * (f[2] - f[0]) + offset / (step * step) * (f[2] - 2 * f[1] + f[0]);
}
Vector3 bend(const Vector3* f, double step) { return 1 / (step * step) * (f[2] - 2 * f[1] + f[0]); }

struct Places {
  std::vector<double> u, v;
  void add(double at_u, double at_v) {
    u.push_back(at_u);
    v.push_back(at_v);
  }
  // Three in a row along u, three along v.
  void add_cross(double at_u, double at_v, double step) {
    const double mu = middle(at_u, step), mv = middle(at_v, step);
    for (const double d : {-step, 0.0, step}) add(mu + d, at_v);
    for (const double d : {-step, 0.0, step}) add(at_u, mv + d);
  }
};

}  // namespace

std::vector<double> surface_grid(const SurfaceFunction& function) {
  constexpr std::size_t side = 17;
  Places grid;
  for (std::size_t i = 0; i < side * side; ++i)
    grid.add(static_cast<double>(i % side) / (side - 1), static_cast<double>(i / side) / (side - 1));
  std::vector<double> positions(3 * grid.u.size());
  function(grid.u, grid.v, positions);
  return positions;
}

FunctionSurface::FunctionSurface(SurfaceFunction function, std::span<const std::uint8_t> content)
    : function_(std::move(function)) {
  if (!content.empty()) {
    std::copy_n(content.begin(), std::min(content.size(), content_.size()), content_.begin());
    return;
  }
  DigestBytes digest;
  for (const double number : surface_grid(function_)) digest.add(number);
  content_ = digest.bytes();
}

void FunctionSurface::positions(std::span<const double> u, std::span<const double> v,
                                std::span<Vector3> result) const {
  std::vector<double> triples(3 * u.size());
  function_(u, v, triples);
  for (std::size_t i = 0; i < u.size(); ++i)
    result[i] = {triples[3 * i], triples[3 * i + 1], triples[3 * i + 2]};
}

void FunctionSurface::tangents(std::span<const double> u, std::span<const double> v,
                               std::span<SurfaceTangents> result) const {
  Places places;
  for (std::size_t i = 0; i < u.size(); ++i) {
    places.add(u[i], v[i]);
    places.add_cross(u[i], v[i], first_step);
  }
  std::vector<Vector3> f(places.u.size());
  positions(places.u, places.v, f);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vector3* at = f.data() + 7 * i;
    result[i] = {at[0], slope(at + 1, first_step, u[i] - middle(u[i], first_step)),
                 slope(at + 4, first_step, v[i] - middle(v[i], first_step))};
  }
}

void FunctionSurface::jets(std::span<const double> u, std::span<const double> v,
                           std::span<SurfaceJet> result) const {
  std::vector<SurfaceTangents> first(u.size());
  tangents(u, v, first);
  Places places;
  for (std::size_t i = 0; i < u.size(); ++i) {
    places.add_cross(u[i], v[i], second_step);
    const double mu = middle(u[i], second_step), mv = middle(v[i], second_step);
    for (const double du : {-second_step, second_step})
      for (const double dv : {-second_step, second_step}) places.add(mu + du, mv + dv);
  }
  std::vector<Vector3> f(places.u.size());
  positions(places.u, places.v, f);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vector3* at = f.data() + 10 * i;
    const Vector3 mixed = 0.25 / (second_step * second_step) * (at[9] - at[8] - at[7] + at[6]);
    result[i] = {first[i].position,     first[i].du, first[i].dv,
                 bend(at, second_step), mixed,       bend(at + 3, second_step)};
  }
}

}  // namespace meander
