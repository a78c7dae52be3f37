// A parametric surface that a function of the caller describes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "kernels/public/surface.h"
#include "kernels/surface/surface.h"

namespace meander {

// The positions of a grid of 17 x 17 parameters, 3 numbers each: what names a function that has no name.
std::vector<double> surface_grid(const SurfaceFunction& function);

// Derivatives are differences: about 1e-9 of the size for the first, 1e-6 for the second. What the function
// throws passes through.
class FunctionSurface : public ParametricSurface {
 public:
  // content: the first 16 bytes name the surface; empty: a digest of its positions on a grid.
  explicit FunctionSurface(SurfaceFunction function, std::span<const std::uint8_t> content = {});

  std::string_view name() const override { return "callable"; }
  std::array<std::uint8_t, 16> content() const override { return content_; }
  void positions(std::span<const double> u, std::span<const double> v,
                 std::span<Vector3> result) const override;
  void tangents(std::span<const double> u, std::span<const double> v,
                std::span<SurfaceTangents> result) const override;
  void jets(std::span<const double> u, std::span<const double> v,
            std::span<SurfaceJet> result) const override;

 private:
  SurfaceFunction function_;
  std::array<std::uint8_t, 16> content_{};
};

}  // namespace meander
