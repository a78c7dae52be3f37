// A parametric surface from a formula, written once and differentiated automatically.
//
//   struct Cylinder {
//     static constexpr std::string_view name = "cylinder";
//     template <class Scalar>
//     std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
//       const auto [c, s] = cosine_sine(2 * std::numbers::pi * u);
//       return {c, s, v};
//     }
//   };
//   const AnalyticSurface<Cylinder> surface;   // ready for sample_surface
//
// To make it available by name to make_surface and the command line, add the struct to analytic_surfaces.cpp
// and to the list at the end of that file.
#pragma once

#include <array>
#include <cstddef>

#include "kernels/core/jets.h"
#include "kernels/surface/surface.h"

namespace meander {

template <class Formula>
class AnalyticSurface final : public ParametricSurface {
 public:
  explicit AnalyticSurface(const Formula& formula = {}) : formula_(formula) {}

  std::string_view name() const override { return Formula::name; }

  void positions(std::span<const double> u, std::span<const double> v,
                 std::span<Vector3> result) const override {
    for (std::size_t i = 0; i < result.size(); ++i) {
      const std::array<double, 3> p = formula_(u[i], v[i]);
      result[i] = {p[0], p[1], p[2]};
    }
  }

  void tangents(std::span<const double> u, std::span<const double> v,
                std::span<SurfaceTangents> result) const override {
    for (std::size_t i = 0; i < result.size(); ++i) {
      const std::array<Jet1, 3> p = formula_(Jet1(u[i], 1, 0), Jet1(v[i], 0, 1));
      result[i] = {{p[0].f, p[1].f, p[2].f}, {p[0].u, p[1].u, p[2].u}, {p[0].v, p[1].v, p[2].v}};
    }
  }

  void jets(std::span<const double> u, std::span<const double> v,
            std::span<SurfaceJet> result) const override {
    for (std::size_t i = 0; i < result.size(); ++i) {
      const std::array<Jet2, 3> p = formula_(Jet2(u[i], 1, 0), Jet2(v[i], 0, 1));
      result[i] = {{p[0].f, p[1].f, p[2].f},    {p[0].u, p[1].u, p[2].u},    {p[0].v, p[1].v, p[2].v},
                   {p[0].uu, p[1].uu, p[2].uu}, {p[0].uv, p[1].uv, p[2].uv}, {p[0].vv, p[1].vv, p[2].vv}};
    }
  }

 private:
  Formula formula_;
};

}  // namespace meander
