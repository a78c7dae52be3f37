// Samples of a surface with the spacings that are wanted at them: what anisotropic measures take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/tensor/tangent_tensor.h"

namespace meander {

// N samples as flat arrays. Spacings are lengths: s1 s2 is the area per sample (see sample_spacing_scale).
struct TangentSamples {
  std::span<const double> points;   // 3 N
  std::span<const double> normals;  // 3 N, of any positive length
  // 3 N: primary directions e1 of any length and sign, made orthogonal to the normal; one that is parallel to
  // it stands for any direction.
  std::span<const double> axes;
  std::span<const double> s1, s2;  // N each: spacing along e1 and across, positive

  std::size_t count() const { return s1.size(); }
};

// The factor that turns spacings whose density 1 / (s1 s2) has the integral `measure` over the domain into
// those of `samples` samples: sqrt(measure / samples). Throws std::invalid_argument unless both are positive.
double sample_spacing_scale(double measure, std::uint64_t samples);

// The same with the frames made orthonormal: frame.x along e1. O(N).
struct PreparedTangentSamples {
  std::vector<Vector3> points;
  std::vector<TangentFrame> frames;
  std::vector<double> s1, s2;
};
// Throws std::invalid_argument when lengths differ, a number is not finite, a normal is zero or a spacing not
// positive.
PreparedTangentSamples prepare_tangent_samples(const TangentSamples& samples);

// Orthonormal frame with this unit normal: x along the projection of `first`; along one of two other
// directions where that has none.
TangentFrame frame_along(Vector3 unit_normal, Vector3 first);

}  // namespace meander
