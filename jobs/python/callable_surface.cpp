#include "jobs/python/callable_surface.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "io/digest.h"
#include "jobs/python/array_mesh.h"

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

CallableSurface::CallableSurface(meander_function function, void* context, const std::uint8_t* content)
    : function_(function), context_(context) {
  if (content != nullptr) {
    std::copy_n(content, content_.size(), content_.begin());
    return;
  }
  constexpr std::size_t side = 17;
  Places grid;
  for (std::size_t i = 0; i < side * side; ++i)
    grid.add(static_cast<double>(i % side) / (side - 1), static_cast<double>(i / side) / (side - 1));
  std::vector<Vector3> points(grid.u.size());
  positions(grid.u, grid.v, points);
  content_ = sha256(std::as_bytes(std::span(points)));
}

std::array<std::uint8_t, 16> CallableSurface::content() const {
  std::array<std::uint8_t, 16> first{};
  std::copy_n(content_.begin(), first.size(), first.begin());
  return first;
}

void CallableSurface::positions(std::span<const double> u, std::span<const double> v,
                                std::span<Vector3> result) const {
  std::vector<double> triples(3 * u.size());
  if (function_(context_, u.size(), u.data(), v.data(), triples.data()) != 0) throw FunctionGaveUp();
  require_finite(triples, "the surface's positions");
  for (std::size_t i = 0; i < u.size(); ++i)
    result[i] = {triples[3 * i], triples[3 * i + 1], triples[3 * i + 2]};
}

void CallableSurface::tangents(std::span<const double> u, std::span<const double> v,
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

void CallableSurface::jets(std::span<const double> u, std::span<const double> v,
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
