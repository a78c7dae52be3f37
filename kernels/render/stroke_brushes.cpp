#include "kernels/render/stroke_brushes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kernels/core/parallel.h"

namespace meander {

namespace {

constexpr std::size_t lattice_side = 256;

double smooth_step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// One brush stroke: u from 0 to 1 along, v from -1 to 1 across. `row`: where in the noise its own values are.
class StrokeOfBrush {
 public:
  StrokeOfBrush(const BrushShape& shape, double ratio, double row, const LatticeNoise& noise)
      : shape_(shape), ratio_(ratio), row_(row), noise_(noise) {}

  BrushTexel at(double u, double v) const {
    const double wave = 0.6 * ratio_;  // of the outline, about one every other width
    const double shift = shape_.wobble * (noise_.at(u * wave, row_) - 0.5);
    const double swell = 1 - shape_.wobble * noise_.at(u * wave, row_ + 31.5);
    const double half = swell * outline(u);
    if (half <= 0) return {};
    const double off = std::abs(v - shift) / half;
    if (off >= 1) return {};
    const double inside = 1 - off,
                 edge = smooth_step(0, std::max(0.02, shape_.soft / std::max(half, 0.2)), inside);
    const double hair = bristle(u, v), ends = ragged_ends(u, v);
    // Paint runs out towards the end: the gaps between bristles open.
    double cover = edge * ends * (1 - shape_.streak * (1 - hair) * (0.35 + 0.65 * u));
    if (shape_.mottle > 0)
      cover *= 1 - shape_.mottle * (1 - noise_.at(u * 0.9 * ratio_ + 7, row_ + 3 + 1.3 * v));
    if (shape_.rim > 0) {
      // Pigment that the water carried to the edge, all around.
      const double to_end = std::min(u, 1 - u) * 2 * ratio_, border = std::min(inside, to_end);
      cover *= 1 - 0.35 * shape_.rim + shape_.rim * std::exp(-border * border / 0.03);
    }
    double height = cover * (0.4 + 0.6 * hair);
    if (shape_.ridge > 0) {
      height += shape_.ridge * cover * std::exp(-inside * inside / 0.02);
      height += 0.5 * shape_.ridge * cover * std::exp(-(1 - u) * (1 - u) * ratio_ * ratio_ * 8);
    }
    return {static_cast<float>(cover), static_cast<float>(height)};
  }

 private:
  // Half the width at u: blunt round ends, or tapered ones.
  double outline(double u) const {
    const double end = std::min(u, 1 - u);
    if (shape_.taper > 0.15) return std::pow(smooth_step(0, shape_.taper, end), 0.7);
    const double round = std::clamp(end * 2 * ratio_ / 0.8, 0.0, 1.0);
    return std::sqrt(1 - (1 - round) * (1 - round));
  }
  double bristle(double u, double v) const {
    if (shape_.bristles <= 0) return 1;
    const double across = (v + 1) * 0.5 * shape_.bristles;
    const double fine = noise_.at(across + 11, row_ + 60 + 0.15 * u * ratio_);
    const double finer = noise_.at(2.3 * across + 90, row_ + 80 + 0.4 * u * ratio_);
    return std::clamp(0.5 + 1.5 * (0.65 * fine + 0.35 * finer - 0.5), 0.0, 1.0);
  }
  double ragged_ends(double u, double v) const {
    if (shape_.ragged <= 0) return 1;
    const double across = (v + 1) * 0.5 * std::max(4.0, shape_.bristles);
    const double a = noise_.at(1.4 * across, row_ + 120), b = noise_.at(1.4 * across, row_ + 150);
    const double begin = 0.7 * shape_.ragged * a, end = 1 - 2 * shape_.ragged * b;
    const double fade = 0.04 + 0.3 * shape_.ragged;
    return smooth_step(begin, begin + 0.5 * fade, u) * (1 - smooth_step(end - fade, end, u));
  }

  const BrushShape& shape_;
  double ratio_, row_;  // length over width
  const LatticeNoise& noise_;
};

BrushTexture paint_brush(const BrushShape& shape, double width, double length, double row,
                         const LatticeNoise& noise) {
  BrushTexture made;
  made.along = static_cast<std::uint32_t>(std::clamp(std::ceil(length), 6.0, 320.0)) + 2;
  made.across = static_cast<std::uint32_t>(std::clamp(std::ceil(width), 4.0, 96.0)) + 2;
  made.texels.resize(std::size_t{made.along} * made.across);
  const StrokeOfBrush stroke(shape, std::max(1.0, length / width), row, noise);
  double sum = 0;
  for (std::uint32_t j = 1; j + 1 < made.across; ++j)
    for (std::uint32_t i = 1; i + 1 < made.along; ++i) {
      const BrushTexel texel = stroke.at((i - 0.5) / (made.along - 2), 2 * (j - 0.5) / (made.across - 2) - 1);
      made.texels[std::size_t{j} * made.along + i] = texel;
      sum += texel.cover;
    }
  made.mean_cover = static_cast<float>(sum / static_cast<double>(made.texels.size()));
  return made;
}

double weave(double x, double y) {
  const auto column = static_cast<std::int64_t>(std::floor(x)),
             row = static_cast<std::int64_t>(std::floor(y));
  const double across = std::sin(std::numbers::pi * (x - std::floor(x))),
               along = std::sin(std::numbers::pi * (y - std::floor(y)));
  // Threads pass over and under each other.
  return (column + row) % 2 == 0 ? across * (0.55 + 0.45 * along) : along * (0.55 + 0.45 * across);
}

double paper_height(PaperKind kind, double x, double y, const LatticeNoise& noise) {
  const auto octave = [&](double cell) { return noise.at(x / cell, y / cell) - 0.5; };
  switch (kind) {
    case PaperKind::smooth:
      return 0.5 + 0.5 * octave(1.7) + 0.3 * octave(5.3);
    case PaperKind::tooth:
      return 0.5 + 0.6 * octave(1.9) + 0.5 * octave(3.7) + 0.2 * octave(9.1);
    case PaperKind::cold_press:
      return 0.5 + 0.85 * octave(6.3) + 0.5 * octave(3.1) + 0.35 * octave(13.7);
    case PaperKind::canvas:
      return 0.15 + 0.6 * weave(x / 3.6, y / 3.6) + 0.3 * octave(2.3) + 0.3 * octave(17.3);
  }
  return 0.5;
}

}  // namespace

RandomKey picture_key(std::uint64_t seed) {
  constexpr std::array<std::uint8_t, 7> name = {'s', 't', 'r', 'o', 'k', 'e', 's'};
  return make_random_key(seed, name);
}

LatticeNoise::LatticeNoise(RandomKey key) : values_(lattice_side * lattice_side) {
  for (std::size_t i = 0; i < values_.size(); i += 4) {
    const PhiloxBlock words = random_words(key, Stream::test_shapes, i / 4);
    for (std::size_t k = 0; k < 4; ++k) values_[i + k] = static_cast<float>(words[k] >> 8) * 0x1p-24f;
  }
}

float LatticeNoise::at(double x, double y) const {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto column = static_cast<std::size_t>(static_cast<std::int64_t>(fx)) % lattice_side,
             row = static_cast<std::size_t>(static_cast<std::int64_t>(fy)) % lattice_side;
  const auto smooth = [](double t) { return static_cast<float>(t * t * (3 - 2 * t)); };
  const float s = smooth(x - fx), t = smooth(y - fy);
  const float* above = values_.data() + row * lattice_side;
  const float* below = values_.data() + (row + 1) % lattice_side * lattice_side;
  const std::size_t right = (column + 1) % lattice_side;
  const float up = above[column] + s * (above[right] - above[column]);
  const float down = below[column] + s * (below[right] - below[column]);
  return up + t * (down - up);
}

double brush_length(double shortest, double longest, std::size_t bin) {
  return shortest *
         std::pow(longest / shortest, static_cast<double>(bin) / static_cast<double>(brush_lengths - 1));
}

BrushSet make_brushes(const BrushShape& shape, double width, double shortest, double longest,
                      const LatticeNoise& noise) {
  BrushSet set;
  set.textures.resize(brush_lengths * brush_variations);
  parallel_tasks(set.textures.size(), [&](std::size_t i) {
    // Far enough apart in the noise that no two brushes share their values.
    set.textures[i] = paint_brush(shape, width, brush_length(shortest, longest, i / brush_variations),
                                  4.7 * static_cast<double>(i) + 0.37, noise);
  });
  return set;
}

std::vector<float> paper_heights(PaperKind kind, std::uint32_t width, std::uint32_t height, double unit,
                                 const LatticeNoise& noise) {
  std::vector<float> heights(std::size_t{width} * height);
  parallel_tasks(height, [&](std::size_t y) {
    for (std::uint32_t x = 0; x < width; ++x)
      heights[y * width + x] = static_cast<float>(
          std::clamp(paper_height(kind, x / unit, static_cast<double>(y) / unit, noise), 0.0, 1.0));
  });
  return heights;
}

}  // namespace meander
