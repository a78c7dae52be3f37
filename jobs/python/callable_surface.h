// A parametric surface that a function of the caller describes.
#pragma once

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "jobs/python/array_mesh.h"
#include "jobs/python/interface.h"
#include "kernels/surface/surface.h"

namespace meander {

// Ends the work when a function gives up.
struct FunctionGaveUp : std::runtime_error {
  FunctionGaveUp() : std::runtime_error("the function of a surface gave up") {}
};

// Derivatives are differences: about 1e-9 of the size for the first, 1e-6 for the second. The function is
// called from the thread that samples, which must be one alone. Throws FunctionGaveUp, and
// std::invalid_argument for positions that are not finite.
class CallableSurface : public ParametricSurface {
 public:
  // Evaluates a grid: its digest is the content unless 32 bytes are given.
  CallableSurface(meander_function function, void* context, const std::uint8_t* content);

  std::string_view name() const override { return "callable"; }
  std::array<std::uint8_t, 16> content() const override;
  const Content& content_sha256() const { return content_; }
  void positions(std::span<const double> u, std::span<const double> v,
                 std::span<Vector3> result) const override;
  void tangents(std::span<const double> u, std::span<const double> v,
                std::span<SurfaceTangents> result) const override;
  void jets(std::span<const double> u, std::span<const double> v,
            std::span<SurfaceJet> result) const override;

 private:
  meander_function function_;
  void* context_;
  Content content_{};
};

}  // namespace meander
