// A parametric surface that a Python function describes.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <cstdint>
#include <string_view>

#include "kernels/surface/surface.h"

namespace meander {

// function(u, v): two arrays of k numbers in [0, 1] to an array (k, 3) of finite positions, or to a tuple of
// three arrays. Derivatives are differences: about 1e-9 of the size for the first, 1e-6 for the second. Every
// call needs the GIL and may throw pybind11::error_already_set, so that it must be sampled by one thread,
// which holds it.
class CallableSurface : public ParametricSurface {
 public:
  // Evaluates a grid: its digest is the content unless 32 bytes are given.
  CallableSurface(pybind11::function function, const pybind11::object& content);

  std::string_view name() const override { return "callable"; }
  std::array<std::uint8_t, 16> content() const override;
  const std::array<std::uint8_t, 32>& content_sha256() const { return content_; }
  void positions(std::span<const double> u, std::span<const double> v,
                 std::span<Vector3> result) const override;
  void tangents(std::span<const double> u, std::span<const double> v,
                std::span<SurfaceTangents> result) const override;
  void jets(std::span<const double> u, std::span<const double> v,
            std::span<SurfaceJet> result) const override;

 private:
  pybind11::function function_;
  std::array<std::uint8_t, 32> content_{};
};

}  // namespace meander
