// Parametric surfaces f: [0, 1]^2 -> R^3, evaluated in batches over flat arrays (docs/METHODS.md 10).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "kernels/core/vector3.h"
#include "kernels/public/surface.h"

namespace meander {

// Position and first derivatives by u and v.
struct SurfaceTangents {
  Vector3 position, du, dv;
};

// Position, first and second derivatives.
struct SurfaceJet {
  Vector3 position, du, dv, duu, duv, dvv;
};

// A surface over the unit square. All evaluations are pure and thread-safe; u, v and the result have equal
// length, u and v lie in [0, 1] (both ends included: poles and seams must give finite values there).
// Derivatives are those of the map itself, so they vanish at a pole. Prefer batches of 100 to 10,000 points,
// each of one virtual call.
class ParametricSurface {
 public:
  virtual ~ParametricSurface() = default;

  virtual std::string_view name() const = 0;
  // Bytes that key the randomness: the name (cut to 16 bytes), or a digest of its data where the surface
  // holds data of its own.
  virtual std::array<std::uint8_t, 16> content() const;

  virtual void positions(std::span<const double> u, std::span<const double> v,
                         std::span<Vector3> result) const = 0;
  virtual void tangents(std::span<const double> u, std::span<const double> v,
                        std::span<SurfaceTangents> result) const = 0;
  virtual void jets(std::span<const double> u, std::span<const double> v,
                    std::span<SurfaceJet> result) const = 0;
};

// A surface that evaluates point by point: Surface::jet(u, v, derivatives) with the derivatives of order 0, 1
// or 2 and below.
template <class Surface>
class PointwiseSurface : public ParametricSurface {
 public:
  void positions(std::span<const double> u, std::span<const double> v,
                 std::span<Vector3> result) const override {
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = jet(u[i], v[i], 0).position;
  }
  void tangents(std::span<const double> u, std::span<const double> v,
                std::span<SurfaceTangents> result) const override {
    for (std::size_t i = 0; i < result.size(); ++i) {
      const SurfaceJet at = jet(u[i], v[i], 1);
      result[i] = {at.position, at.du, at.dv};
    }
  }
  void jets(std::span<const double> u, std::span<const double> v,
            std::span<SurfaceJet> result) const override {
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = jet(u[i], v[i], 2);
  }

 private:
  SurfaceJet jet(double u, double v, int derivatives) const {
    return static_cast<const Surface&>(*this).jet(u, v, derivatives);
  }
};

// The analytic surface of that name, differentiated automatically; null for a name that surface_names()
// lacks.
std::unique_ptr<ParametricSurface> make_surface(std::string_view name);

}  // namespace meander
