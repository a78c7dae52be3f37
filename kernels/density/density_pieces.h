// Densities that are finer than triangles: constant on the pieces that bisection makes of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "kernels/density/density.h"

namespace meander {

// The most pieces that the triangles of a mesh are divided into, beside one for each: what a texture of
// 512 x 512 pixels has.
inline constexpr std::size_t most_density_pieces = std::size_t{1} << 18;

// A triangle that is not divided, of density 1.
inline constexpr std::uint8_t no_pixels = 255;
// The power of two at or above a number of pixels, up to 63.
std::uint8_t pixel_level(double pixels);

// value[i] = density >= 0 of triangle t at the point of barycentric weights weight[i], those of its corners 1
// and 2. Called in parallel.
using PieceValues = std::function<void(std::size_t t, std::span<const std::array<double, 2>> weight,
                                       std::span<double> value)>;

// level: T powers of two of the pixels, details of the density, that triangles cover (pixel_level), or
// no_pixels. Each triangle is bisected as curve elements are (Density::piece_mean): into 16 pieces a pixel,
// or as many fewer on all triangles alike as most_density_pieces allows. A piece has the mean over 1 value
// (pieces of up to half a pixel), 4 (up to four pixels) or 8 at the centroids of its parts. Uniform where no
// triangle has pixels. O(T + pieces). Deterministic for every thread count.
// Throws what `values` throws for the first triangle that it throws for, RunCanceled, timeout.
Density density_in_pieces(const PreparedMesh& mesh, std::span<const std::uint8_t> level,
                          const PieceValues& values, const CancelToken& cancel);

// Upper bound of the bytes that it has.
constexpr double piece_density_bytes(double triangles) {
  return sizeof(double) * 2 * (triangles + static_cast<double>(most_density_pieces)) +
         (sizeof(std::size_t) + 1) * (triangles + 1);
}

}  // namespace meander
