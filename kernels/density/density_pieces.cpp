#include "kernels/density/density_pieces.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "kernels/core/ordered_blocks.h"
#include "kernels/core/portable_functions.h"
#include "kernels/density/pieces.h"

namespace meander {

namespace {

constexpr int max_pieces_per_pixel = 4;  // as a power of two
constexpr int max_piece_levels = std::bit_width(most_density_pieces) - 1;

// Pieces for a pixel, as a power of two, that are not too many in all. levels: by the power of two of the
// pixels of triangles, how many there are.
int pieces_per_pixel(const std::array<std::uint64_t, 64>& triangles_of_level) {
  int fitting = max_pieces_per_pixel;
  for (;; --fitting) {
    double pieces = 0;
    for (int level = 0; level < 64; ++level)
      if (level + fitting > 0)
        pieces += static_cast<double>(triangles_of_level[static_cast<std::size_t>(level)]) *
                  std::ldexp(1.0, std::min(level + fitting, max_piece_levels + 1));
    if (pieces <= static_cast<double>(most_density_pieces)) return fitting;
  }
}

// The means over the pieces of a triangle.
class TrianglePieces {
 public:
  explicit TrianglePieces(const PieceValues& values) : values_(values) {}

  // Pieces down to `depth` bisections; `extra` more lead to the places that are looked up.
  void fill(std::size_t t, const WorkPiece& whole, int depth, int extra, double* means) {
    t_ = t;
    depth_ = depth;
    deepest_ = depth + extra;
    means_ = means;
    fill(whole, 0);
    const double* const pieces = means + (std::size_t{1} << depth);
    means[0] = *std::max_element(pieces, pieces + (std::size_t{1} << depth));
  }

 private:
  static constexpr int max_at_once = 10;  // bisections: so many values that an evaluation of arrays pays

  double fill(const WorkPiece& piece, int level) {
    const int below = deepest_ - level;
    if (below <= max_at_once) return fill_at_once(piece, level, below);
    const auto [first, second] = bisect(piece);
    double mean = 0.5 * fill(first, level + 1);
    mean += 0.5 * fill(second, level + 1);
    if (level <= depth_) means_[piece.path] = mean;
    return mean;
  }

  double fill_at_once(const WorkPiece& piece, int level, int below) {
    weight_.clear();
    add_centroids(piece, below);
    value_.resize(weight_.size());
    values_(t_, weight_, value_);
    for (;; --below) {
      const std::size_t parts = std::size_t{1} << below;
      if (level + below <= depth_)
        std::copy_n(value_.data(), parts, means_ + (std::size_t{piece.path} << below));
      if (below == 0) return value_[0];
      for (std::size_t k = 0; k < parts / 2; ++k) value_[k] = 0.5 * value_[2 * k] + 0.5 * value_[2 * k + 1];
    }
  }

  // In the order of their paths.
  void add_centroids(const WorkPiece& piece, int bisections) {
    if (bisections == 0) {
      weight_.push_back(centroid(piece.weights));
      return;
    }
    for (const WorkPiece& child : bisect(piece)) add_centroids(child, bisections - 1);
  }

  const PieceValues& values_;
  std::size_t t_ = 0;
  int depth_ = 0, deepest_ = 0;
  double* means_ = nullptr;
  std::vector<std::array<double, 2>> weight_;
  std::vector<double> value_;
};

}  // namespace

std::uint8_t pixel_level(double pixels) {
  return static_cast<std::uint8_t>(std::clamp(std::ceil(portable::log2(std::max(1.0, pixels))), 0.0, 63.0));
}

Density density_in_pieces(const PreparedMesh& mesh, std::span<const std::uint8_t> level,
                          const PieceValues& values, const CancelToken& cancel) {
  const std::size_t count = mesh.triangle_count(), block = std::clamp<std::size_t>(count / 64, 1, 4096);
  std::array<std::uint64_t, 64> triangles_of_level{};
  for (const std::uint8_t l : level)
    if (l != no_pixels) ++triangles_of_level[l];
  Density density;
  if (std::ranges::all_of(level, [](std::uint8_t l) { return l == no_pixels; })) return density;
  const int per_pixel = pieces_per_pixel(triangles_of_level);
  const int extra = per_pixel >= 1 ? 0 : per_pixel >= -2 ? 2 : 3;
  const auto depth_of = [&](std::size_t t) {
    return level[t] == no_pixels ? 0 : std::max(0, level[t] + per_pixel);
  };
  density.piece_begin.resize(count + 1);
  for (std::size_t t = 0; t < count; ++t)
    density.piece_begin[t + 1] = density.piece_begin[t] + (std::size_t{2} << depth_of(t));
  density.piece_mean.assign(density.piece_begin[count], 1);
  ordered_blocks(count, block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    TrianglePieces pieces(values);
    for (std::size_t t = begin; t < end; ++t)
      if (level[t] != no_pixels)
        pieces.fill(t, whole_triangle(bisection_corners(mesh, static_cast<std::uint32_t>(t))), depth_of(t),
                    extra, density.piece_mean.data() + density.piece_begin[t]);
  });
  return density;
}

}  // namespace meander
