#include "kernels/sample/scrambled_net.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

#include "kernels/core/instruction_set.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/reversed_bits.h"

namespace meander {

namespace {

constexpr int net_bits = 32;
using Directions = std::array<std::uint32_t, net_bits>;

// A primitive polynomial of a degree, with the coefficients between the first and the last, and the first
// direction numbers.
struct Polynomial {
  int degree;
  std::uint32_t coefficients;
  std::array<std::uint32_t, 4> first;
};

constexpr Directions directions_of(const Polynomial& polynomial) {
  Directions v{};
  const int s = polynomial.degree;
  for (int k = 0; k < net_bits; ++k) {
    if (k < s) {
      v[k] = polynomial.first[k] << (net_bits - 1 - k);
      continue;
    }
    v[k] = v[k - s] ^ v[k - s] >> s;
    for (int j = 1; j < s; ++j)
      if ((polynomial.coefficients >> (s - 1 - j) & 1) != 0) v[k] ^= v[k - j];
  }
  return v;
}

// Four dimensions together: vectors that all processors have.
constexpr std::size_t net_lanes = 4;
using NetWords = std::uint32_t __attribute__((vector_size(16)));
using NetBytes = std::uint8_t __attribute__((vector_size(16)));

// The sums of direction numbers of all dimensions, and of two that are not used, by each four bits of the
// index and their value; their bits reversed, as the scrambling begins with that.
constexpr int part_bits = 4, net_parts = net_bits / part_bits;
constexpr auto net_sums = [] {
  std::array<Directions, ScrambledNet::dimensions> of{};
  for (int k = 0; k < net_bits; ++k) of[0][k] = std::uint32_t{1} << (net_bits - 1 - k);  // van der Corput's
  of[1] = directions_of({1, 0, {1}});
  of[2] = directions_of({2, 1, {1, 3}});
  of[3] = directions_of({3, 1, {1, 3, 1}});
  of[4] = directions_of({3, 2, {1, 1, 1}});
  of[5] = directions_of({4, 1, {1, 1, 3, 3}});
  std::array<std::array<std::array<std::uint32_t, 8>, 1 << part_bits>, net_parts> sums{};
  for (std::size_t part = 0; part < net_parts; ++part)
    for (std::size_t value = 1; value < 1 << part_bits; ++value)
      for (std::size_t d = 0; d < of.size(); ++d) {
        const auto bit = static_cast<std::size_t>(std::countr_zero(value));
        sums[part][value][d] =
            sums[part][value & (value - 1)][d] ^ reversed_bits(of[d][part_bits * part + bit]);
      }
  return sums;
}();

MEANDER_INLINE NetWords words_at(const std::uint32_t* from) {
  NetWords words;
  std::memcpy(&words, from, sizeof words);
  return words;
}

MEANDER_INLINE NetWords reversed(NetWords x) {
  x = (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
  x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
  x = (x & 0x0F0F0F0Fu) << 4 | (x >> 4 & 0x0F0F0F0Fu);
  const auto bytes = std::bit_cast<NetBytes>(x);
  return std::bit_cast<NetWords>(
      __builtin_shufflevector(bytes, bytes, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
}

// A bit of the result depends on those bits of x alone that are not below it. x: its bits reversed.
MEANDER_INLINE NetWords scrambled(NetWords x, NetWords seed) {
  x += seed;
  x ^= x * 0x6C50B47Cu;
  x ^= x * 0xB82F1E52u;
  x ^= x * 0xC7AFE638u;
  x ^= x * 0x8D22F6E6u;
  return reversed(x);
}

// Four coordinates from dimension `first` on.
MEANDER_INLINE std::array<double, net_lanes> coordinates(
    const std::array<std::uint32_t, 2 * net_lanes>& seeds, std::uint32_t index, std::size_t first) {
  NetWords x{};
  for (std::size_t part = 0; part < net_parts; ++part)
    x ^= words_at(&net_sums[part][index >> (part_bits * part) & ((1u << part_bits) - 1)][first]);
  x = scrambled(x, words_at(&seeds[first]));
  std::array<double, net_lanes> point;
  for (std::size_t d = 0; d < net_lanes; ++d) point[d] = (static_cast<double>(x[d]) + 0.5) * 0x1p-32;
  return point;
}

// c[0] + c[1] x + ...
constexpr double polynomial_at(std::span<const double> c, double x) {
  double value = 0;
  for (std::size_t i = c.size(); i-- > 0;) value = value * x + c[i];
  return value;
}

}  // namespace

ScrambledNet::ScrambledNet(RandomKey key, Stream stream, std::uint32_t number) {
  for (std::uint32_t block = 0; block < 2; ++block) {
    const PhiloxBlock words = random_words(key, stream, number, block);
    for (std::size_t k = 0; k < 4 && 4 * block + k < dimensions; ++k) seeds_[4 * block + k] = words[k];
  }
}

std::array<double, ScrambledNet::dimensions> ScrambledNet::operator()(std::uint32_t index) const {
  const auto low = coordinates(seeds_, index, 0), high = coordinates(seeds_, index, net_lanes);
  return {low[0], low[1], low[2], low[3], high[0], high[1]};
}

std::array<double, 4> ScrambledNet::first_four(std::uint32_t index) const {
  return coordinates(seeds_, index, 0);
}

double normal_quantile(double p) {
  constexpr double near_middle[] = {3.3871328727963666080e0,  1.3314166789178437745e+2,
                                    1.9715909503065514427e+3, 1.3731693765509461125e+4,
                                    4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                    3.3430575583588128105e+4, 2.5090809287301226727e+3},
                   below_middle[] = {1.0,
                                     4.2313330701600911252e+1,
                                     6.8718700749205790830e+2,
                                     5.3941960214247511077e+3,
                                     2.1213794301586595867e+4,
                                     3.9307895800092710610e+4,
                                     2.8729085735721942674e+4,
                                     5.2264952788528545610e+3};
  constexpr double near_tail[] = {1.42343711074968357734e0,  4.63033784615654529590e0,
                                  5.76949722146069140550e0,  3.64784832476320460504e0,
                                  1.27045825245236838258e0,  2.41780725177450611770e-1,
                                  2.27238449892691845833e-2, 7.74545014278341407640e-4},
                   below_near_tail[] = {1.0,
                                        2.05319162663775882187e0,
                                        1.67638483018380384940e0,
                                        6.89767334985100004550e-1,
                                        1.48103976427480074590e-1,
                                        1.51986665636164571966e-2,
                                        5.47593808499534494600e-4,
                                        1.05075007164441684324e-9};
  constexpr double far_tail[] = {6.65790464350110377720e0,  5.46378491116411436990e0,
                                 1.78482653991729133580e0,  2.96560571828504891230e-1,
                                 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                 2.71155556874348757815e-5, 2.01033439929228813265e-7},
                   below_far_tail[] = {1.0,
                                       5.99832206555887937690e-1,
                                       1.36929880922735805310e-1,
                                       1.48753612908506148525e-2,
                                       7.86869131145613259100e-4,
                                       1.84631831751005468180e-5,
                                       1.42151175831644588870e-7,
                                       2.04426310338993978564e-15};
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q * polynomial_at(near_middle, r) / polynomial_at(below_middle, r);
  }
  double r = std::sqrt(-portable::log(q < 0 ? p : 1 - p));
  double value = 0;
  if (r <= 5) {
    r -= 1.6;
    value = polynomial_at(near_tail, r) / polynomial_at(below_near_tail, r);
  } else {
    r -= 5;
    value = polynomial_at(far_tail, r) / polynomial_at(below_far_tail, r);
  }
  return q < 0 ? -value : value;
}

double normal_share(double limit) {
  double below = 0.5, above = 1;
  for (double middle = 0.75; below < middle && middle < above; middle = 0.5 * (below + above))
    (normal_quantile(middle) <= limit ? below : above) = middle;
  return 2 * (below - 0.5);
}

}  // namespace meander
