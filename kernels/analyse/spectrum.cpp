#include "kernels/analyse/spectrum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/parallel.h"
#include "kernels/core/portable_angles.h"

namespace meander {

namespace {

// exp(-2 pi i (fx x + fy y)) is a sum of four products of a cosine or sine of x with one of y, and the same
// four give (fx, fy) and (-fx, fy). So the sums over points are the product of two real matrices, here cut
// into tiles of 4 x 4: cosine and sine of two frequencies of either axis.
constexpr std::size_t tile = 4, tile_frequencies = 2;
constexpr std::size_t chunk = 256;           // points whose tiles of both axes fit into the L1 cache: 16 KiB
constexpr std::size_t chunks_at_once = 4;    // points between two rounds of tasks, in chunks
constexpr std::size_t anchor_distance = 32;  // frequencies reached by rotation from one computed directly

// Cosines and sines of 2 pi f x for one chunk of points: for every tile of frequencies, for every point, four
// numbers. Points beyond `count` are zero.
void fill_panels(const double* coordinates, std::size_t count, std::size_t tiles, double* panels) {
  std::array<double, chunk> turn_cosine, turn_sine, cosine, sine;
  const auto set = [&](std::array<double, chunk>& c, std::array<double, chunk>& s, double frequency) {
    for (std::size_t p = 0; p < count; ++p) {
      const double turns = frequency * coordinates[p];
      const Direction direction = direction_of(2 * std::numbers::pi * (turns - std::floor(turns)));
      c[p] = direction.cosine;
      s[p] = direction.sine;
    }
  };
  set(turn_cosine, turn_sine, 1);
  std::fill(panels, panels + tiles * chunk * tile, 0.0);
  for (std::size_t t = 0; t < tiles; ++t) {
    if (t * tile_frequencies % anchor_distance == 0)
      set(cosine, sine, static_cast<double>(t * tile_frequencies));
    double* out = panels + t * chunk * tile;
    for (std::size_t p = 0; p < count; ++p) {
      for (std::size_t f = 0; f < tile_frequencies; ++f) {
        const double c = cosine[p], s = sine[p];
        out[tile * p + 2 * f] = c;
        out[tile * p + 2 * f + 1] = s;
        cosine[p] = c * turn_cosine[p] - s * turn_sine[p];
        sine[p] = c * turn_sine[p] + s * turn_cosine[p];
      }
    }
  }
}

// sums[4 i + j] += sum over the points of a chunk of a[i] b[j].
void multiply_tiles(const double* a, const double* b, double* sums) {
  std::array<double, tile> r0{}, r1{}, r2{}, r3{};
  for (std::size_t p = 0; p < chunk; ++p, a += tile, b += tile) {
    for (std::size_t j = 0; j < tile; ++j) {
      r0[j] += a[0] * b[j];
      r1[j] += a[1] * b[j];
      r2[j] += a[2] * b[j];
      r3[j] += a[3] * b[j];
    }
  }
  for (std::size_t j = 0; j < tile; ++j) {
    sums[j] += r0[j];
    sums[tile + j] += r1[j];
    sums[2 * tile + j] += r2[j];
    sums[3 * tile + j] += r3[j];
  }
}

}  // namespace

PowerSpectrum make_power_spectrum(std::uint32_t radius) {
  if (radius < 1 || radius > 4096) throw std::invalid_argument("make_power_spectrum: radius is 1..4096");
  PowerSpectrum spectrum;
  spectrum.radius = radius;
  spectrum.sum.assign(spectrum.side() * spectrum.side(), 0.0);
  return spectrum;
}

std::uint32_t affordable_radius(std::size_t points) {
  const auto n = static_cast<double>(points);
  return static_cast<std::uint32_t>(
      std::clamp(std::min(2.5 * std::sqrt(n), std::sqrt(1e11 / (4 * n))), 8.0, 1024.0));
}

void add_periodogram(PowerSpectrum& spectrum, std::span<const double> x, std::span<const double> y) {
  if (x.size() != y.size() || x.empty())
    throw std::invalid_argument("add_periodogram: as many x as y, and at least one point");
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!std::isfinite(x[i]) || !std::isfinite(y[i]))
      throw std::invalid_argument("add_periodogram: coordinates must be finite");

  const std::size_t radius = spectrum.radius;
  const std::size_t tiles = radius / tile_frequencies + 1;
  const std::size_t panel = tiles * chunk * tile;  // of one chunk and axis
  std::vector<double> panels(2 * chunks_at_once * panel);
  std::vector<double> sums(tiles * tiles * tile * tile, 0.0);
  for (std::size_t begin = 0; begin < x.size(); begin += chunks_at_once * chunk) {
    const std::size_t chunks = std::min(chunks_at_once, (x.size() - begin + chunk - 1) / chunk);
    parallel_tasks(2 * chunks, [&](std::size_t task) {
      const std::span<const double> axis = task % 2 == 0 ? x : y;
      const std::size_t from = begin + task / 2 * chunk;
      fill_panels(axis.data() + from, std::min(chunk, x.size() - from), tiles, panels.data() + task * panel);
    });
    parallel_tasks(tiles, [&](std::size_t row) {
      for (std::size_t c = 0; c < chunks; ++c) {
        const double* of_x = panels.data() + 2 * c * panel + row * chunk * tile;
        const double* of_y = panels.data() + (2 * c + 1) * panel;
        for (std::size_t column = 0; column < tiles; ++column)
          multiply_tiles(of_x, of_y + column * chunk * tile,
                         sums.data() + (row * tiles + column) * tile * tile);
      }
    });
  }

  const std::size_t side = spectrum.side();
  const double scale = 1 / static_cast<double>(x.size());
  const auto cell = [&](std::size_t row, std::size_t column) -> double& {
    return spectrum.sum[row * side + column];
  };
  for (std::size_t fx = 0; fx <= radius; ++fx)
    for (std::size_t fy = 0; fy <= radius; ++fy) {
      const double* block =
          sums.data() + ((fx / tile_frequencies) * tiles + fy / tile_frequencies) * tile * tile;
      const double* at = block + 2 * (fx % tile_frequencies) * tile + 2 * (fy % tile_frequencies);
      const double cc = at[0], cs = at[1], sc = at[tile], ss = at[tile + 1];
      const double same = ((cc - ss) * (cc - ss) + (sc + cs) * (sc + cs)) * scale;   // of (fx, fy)
      const double other = ((cc + ss) * (cc + ss) + (cs - sc) * (cs - sc)) * scale;  // of (-fx, fy)
      cell(radius + fy, radius + fx) += same;
      if (fx + fy > 0) cell(radius - fy, radius - fx) += same;
      if (fx > 0 && fy > 0) {
        cell(radius + fy, radius - fx) += other;
        cell(radius - fy, radius + fx) += other;
      }
    }
  ++spectrum.sets;
}

namespace {

std::vector<double> mean_power(const PowerSpectrum& spectrum) {
  if (spectrum.sets == 0) throw std::invalid_argument("radial_power: no set was added");
  std::vector<double> mean(spectrum.sum);
  for (double& power : mean) power /= spectrum.sets;
  return mean;
}

// S with determinant 1.
TangentTensor unit_stretch(TangentTensor log_spacing) {
  const double half = 0.5 * trace(log_spacing);
  return exponential(log_spacing + TangentTensor{-half, 0, -half});
}

}  // namespace

RadialProfile radial_power(const PowerSpectrum& spectrum) {
  return radial_profile(mean_power(spectrum), spectrum.side(), 0.5, 1);
}

RadialProfile radial_power(const PowerSpectrum& spectrum, TangentTensor log_spacing) {
  return radial_profile(mean_power(spectrum), spectrum.side(), 0.5, 1, unit_stretch(log_spacing));
}

AngularPower angular_power(const PowerSpectrum& spectrum, TangentTensor log_spacing, double low, double high,
                           std::uint32_t sectors) {
  const std::vector<double> mean = mean_power(spectrum);
  const TangentTensor stretch = unit_stretch(log_spacing);
  const TensorAxes axes = tensor_axes(log_spacing);
  if (!(low > 0) || !(high >= low + 1) || sectors < 2 || sectors > 360)
    throw std::invalid_argument("angular_power: 0 < low, low + 1 <= high, 2..360 sectors");
  const RadialProfile rings = radial_profile(mean, spectrum.side(), low, 1, stretch);
  const auto count = static_cast<std::size_t>(std::floor((high - low) * (1 + 1e-12)));
  if (count > rings.rings()) throw std::invalid_argument("angular_power: the rings do not fit the spectrum");

  AngularPower result;
  result.sector.assign(sectors, 0.0);
  result.bins.assign(sectors, 0);
  const auto radius = static_cast<std::ptrdiff_t>(spectrum.radius);
  const std::size_t half = spectrum.sum.size() / 2;  // P(-f) = P(f): one of each pair
  for (std::size_t c = 0; c < half; ++c) {
    const auto fx = static_cast<double>(static_cast<std::ptrdiff_t>(c % spectrum.side()) - radius);
    const auto fy = static_cast<double>(static_cast<std::ptrdiff_t>(c / spectrum.side()) - radius);
    const double x = stretch.xx * fx + stretch.xy * fy, y = stretch.xy * fx + stretch.yy * fy;
    const double ring = std::floor(std::sqrt(x * x + y * y) - low);
    if (!(ring >= 0 && ring < static_cast<double>(count))) continue;
    const double ring_mean = rings.mean[static_cast<std::size_t>(ring)];
    if (!(ring_mean > 0)) continue;
    const double turn =
        std::atan2(axes.x * y - axes.y * x, axes.x * x + axes.y * y) / std::numbers::pi;  // (-1, 1]
    const double at = (turn < 0 ? turn + 1 : turn) * sectors;
    const std::size_t k = std::min<std::size_t>(static_cast<std::size_t>(at), sectors) % sectors;
    result.sector[k] += mean[c] / ring_mean;
    ++result.bins[k];
  }
  double bins = 0, squares = 0;
  for (std::size_t k = 0; k < sectors; ++k) {
    bins += result.bins[k];
    if (result.bins[k] == 0) continue;
    result.sector[k] /= result.bins[k];
    squares += result.bins[k] * (result.sector[k] - 1) * (result.sector[k] - 1);
  }
  if (!(bins > 0)) throw std::invalid_argument("angular_power: no frequency is in the rings");
  result.deviation = std::sqrt(squares / bins);
  result.noise = std::sqrt((sectors - 1) / (spectrum.sets * bins));
  return result;
}

}  // namespace meander
