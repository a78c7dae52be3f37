#include "kernels/core/portable_functions.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "kernels/core/exact_sums.h"
#include "kernels/core/portable_angles.h"

namespace meander::portable {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// log(i / 32) for i = first_center ...
constexpr int first_center = 22;
constexpr std::array<DoublePair, 25> logarithms = {{{-0x1.7fafa3bd8151cp-2, 0x1.219024acd3b77p-58},
                                                    {-0x1.522ae0738a3d8p-2, 0x1.8f7e9b38a6979p-57},
                                                    {-0x1.269621134db92p-2, -0x1.e0efadd9db02bp-56},
                                                    {-0x1.f991c6cb3b379p-3, -0x1.f665066f980a2p-57},
                                                    {-0x1.a93ed3c8ad9e3p-3, -0x1.bcafa9de97203p-57},
                                                    {-0x1.5bf406b543db2p-3, 0x1.1f5b44c0df7e7p-61},
                                                    {-0x1.1178e8227e47cp-3, 0x1.0e63a5f01c691p-58},
                                                    {-0x1.9335e5d594989p-4, 0x1.478a85704ccb7p-58},
                                                    {-0x1.08598b59e3a07p-4, 0x1.dd7009902bf32p-58},
                                                    {-0x1.0415d89e74444p-5, -0x1.c05cf1d753622p-59},
                                                    {0x0.0p+0, 0x0.0p+0},
                                                    {0x1.f829b0e783300p-6, 0x1.33e3f04f1ef23p-60},
                                                    {0x1.f0a30c01162a6p-5, 0x1.85f325c5bbacdp-59},
                                                    {0x1.6f0d28ae56b4cp-4, -0x1.906d99184b992p-58},
                                                    {0x1.e27076e2af2e6p-4, -0x1.61578001e0162p-60},
                                                    {0x1.29552f81ff523p-3, 0x1.301771c407dbfp-57},
                                                    {0x1.5ff3070a793d4p-3, -0x1.bc60efafc6f6ep-58},
                                                    {0x1.9525a9cf456b4p-3, 0x1.d904c1d4e2e26p-57},
                                                    {0x1.c8ff7c79a9a22p-3, -0x1.4f689f8434012p-57},
                                                    {0x1.fb9186d5e3e2bp-3, -0x1.caaae64f21acbp-57},
                                                    {0x1.1675cababa60ep-2, 0x1.ce63eab883717p-61},
                                                    {0x1.2e8e2bae11d31p-2, -0x1.8f4cdb95ebdf9p-56},
                                                    {0x1.4618bc21c5ec2p-2, 0x1.f42decdeccf1dp-56},
                                                    {0x1.5d1bdbf5809cap-2, 0x1.4236383dc7fe1p-56},
                                                    {0x1.739d7f6bbd007p-2, -0x1.8c76ceb014b04p-56}}};

// 2^(i / 32)
constexpr std::array<DoublePair, 32> powers = {{{0x1.0000000000000p+0, 0x0.0p+0},
                                                {0x1.059b0d3158574p+0, 0x1.d73e2a475b465p-55},
                                                {0x1.0b5586cf9890fp+0, 0x1.8a62e4adc610bp-54},
                                                {0x1.11301d0125b51p+0, -0x1.6c51039449b3ap-54},
                                                {0x1.172b83c7d517bp+0, -0x1.19041b9d78a76p-55},
                                                {0x1.1d4873168b9aap+0, 0x1.e016e00a2643cp-54},
                                                {0x1.2387a6e756238p+0, 0x1.9b07eb6c70573p-54},
                                                {0x1.29e9df51fdee1p+0, 0x1.612e8afad1255p-55},
                                                {0x1.306fe0a31b715p+0, 0x1.6f46ad23182e4p-55},
                                                {0x1.371a7373aa9cbp+0, -0x1.63aeabf42eae2p-54},
                                                {0x1.3dea64c123422p+0, 0x1.ada0911f09ebcp-55},
                                                {0x1.44e086061892dp+0, 0x1.89b7a04ef80d0p-59},
                                                {0x1.4bfdad5362a27p+0, 0x1.d4397afec42e2p-56},
                                                {0x1.5342b569d4f82p+0, -0x1.07abe1db13cadp-55},
                                                {0x1.5ab07dd485429p+0, 0x1.6324c054647adp-54},
                                                {0x1.6247eb03a5585p+0, -0x1.383c17e40b497p-54},
                                                {0x1.6a09e667f3bcdp+0, -0x1.bdd3413b26456p-54},
                                                {0x1.71f75e8ec5f74p+0, -0x1.16e4786887a99p-55},
                                                {0x1.7a11473eb0187p+0, -0x1.41577ee04992fp-55},
                                                {0x1.82589994cce13p+0, -0x1.d4c1dd41532d8p-54},
                                                {0x1.8ace5422aa0dbp+0, 0x1.6e9f156864b27p-54},
                                                {0x1.93737b0cdc5e5p+0, -0x1.75fc781b57ebcp-57},
                                                {0x1.9c49182a3f090p+0, 0x1.c7c46b071f2bep-56},
                                                {0x1.a5503b23e255dp+0, -0x1.d2f6edb8d41e1p-54},
                                                {0x1.ae89f995ad3adp+0, 0x1.7a1cd345dcc81p-54},
                                                {0x1.b7f76f2fb5e47p+0, -0x1.5584f7e54ac3bp-56},
                                                {0x1.c199bdd85529cp+0, 0x1.11065895048ddp-55},
                                                {0x1.cb720dcef9069p+0, 0x1.503cbd1e949dbp-56},
                                                {0x1.d5818dcfba487p+0, 0x1.2ed02d75b3707p-55},
                                                {0x1.dfc97337b9b5fp+0, -0x1.1a5cd4f184b5cp-54},
                                                {0x1.ea4afa2a490dap+0, -0x1.e9c23179c2893p-54},
                                                {0x1.f50765b6e4540p+0, 0x1.9d3e12dd8a18bp-54}}};

// log 2, the first part short enough for its products with exponents to be exact.
constexpr DoublePair log_two = {0x1.62e42fefa2000p-1, 0x1.9ef35793c7673p-41};
// log 2 / 32, likewise for 32 times an exponent.
constexpr DoublePair log_step = {0x1.62e42fefa0000p-6, 0x1.cf79abc9e3b3ap-45};
constexpr DoublePair inverse_log_two = {0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};

// As std::frexp for positive finite numbers, and its inverse where the result is no subnormal number.
double split_exponent(double x, int& exponent) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const auto biased = static_cast<int>(bits >> 52);
  if (biased == 0) return std::frexp(x, &exponent);
  exponent = biased - 1022;
  return std::bit_cast<double>((bits & 0xFFFFFFFFFFFFFu) | std::uint64_t{1022} << 52);
}
double times_power_of_two(double x, int exponent) {
  if (exponent < -1022 || exponent > 1023) return std::ldexp(x, exponent);
  return x * std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

// x = m 2^exponent with m in [sqrt 1/2, sqrt 2).
double split_near_one(double x, int& exponent) {
  const double m = split_exponent(x, exponent);
  if (m >= 0x1.6a09e667f3bcdp-1) return m;
  --exponent;
  return 2 * m;
}

// log x for a positive finite x, to 2^-65.
DoublePair logarithm(double x) {
  int exponent = 0;
  const double m = split_near_one(x, exponent);
  // log m = log c + 2 artanh(q) with q = (m - c) / (m + c), |q| < 0.012
  const int center = static_cast<int>(32 * m + 0.5);
  const double c = center * 0x1p-5, difference = m - c;
  const DoublePair sum = two_sum(m, c);
  const double inverse = 1 / sum.high, q = difference * inverse;
  const DoublePair product = two_product(q, sum.high);
  const double q_low = ((difference - product.high) - product.low - q * sum.low) * inverse;
  const double qq = q * q;
  const double series =
      q * qq * (2.0 / 3 + qq * (2.0 / 5 + qq * (2.0 / 7 + qq * (2.0 / 9 + qq * (2.0 / 11)))));
  const DoublePair& of_center = logarithms[static_cast<std::size_t>(center - first_center)];
  const DoublePair first = two_sum(exponent * log_two.high, of_center.high);
  const DoublePair second = two_sum(first.high, 2 * q);
  return fast_two_sum(second.high,
                      first.low + second.low + (exponent * log_two.low + of_center.low + 2 * q_low + series));
}

// e^(x.high + x.low) for |x.high| < 800.
double exponential(DoublePair x) {
  const double steps = std::floor(x.high * (32 * inverse_log_two.high) + 0.5);
  const DoublePair rest = two_sum(x.high - steps * log_step.high, -steps * log_step.low);
  const double r = rest.high, low = rest.low + x.low;  // |r| < 0.011
  const double growth =
      r + (low * (1 + r) +
           r * r * (1.0 / 2 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120 + r * (1.0 / 720))))));
  const auto step = static_cast<int>(steps);
  const DoublePair& power = powers[static_cast<std::size_t>(step & 31)];
  return times_power_of_two(power.high + (power.low + power.high * growth), (step - (step & 31)) / 32);
}

bool is_odd(double y) { return std::abs(std::fmod(y, 2)) == 1; }

// pow of a positive finite x other than 1, and a finite y other than 0.
double positive_power(double x, double y) {
  const DoublePair log_x = logarithm(x);
  const double estimate = log_x.high * y;
  if (!(std::abs(estimate) < 800)) return estimate > 0 ? infinity : 0;
  if (std::abs(y) < 0x1p-200) return 1;  // the products below would lose their digits
  const DoublePair product = two_product(log_x.high, y);
  return exponential(fast_two_sum(product.high, product.low + log_x.low * y));
}

}  // namespace

double exp(double x) {
  if (x != x) return x;
  if (!(std::abs(x) < 800)) return x > 0 ? infinity : 0;
  return exponential({x, 0});
}

double log(double x) {
  if (x == 0) return -infinity;
  if (x < 0) return not_a_number;
  return x < infinity ? logarithm(x).high : x;
}

double log2(double x) {
  if (!(x > 0 && x < infinity)) return log(x);
  int exponent = 0;
  const double m = split_near_one(x, exponent);
  const DoublePair log_m = logarithm(m);
  const DoublePair product = two_product(log_m.high, inverse_log_two.high);
  const DoublePair sum = two_sum(exponent, product.high);
  return sum.high +
         (sum.low + product.low + log_m.low * inverse_log_two.high + log_m.high * inverse_log_two.low);
}

double pow(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (x != x || y != y) return not_a_number;
  const double size = std::abs(x);
  if (std::isinf(y)) return size == 1 ? 1 : (size > 1) == (y > 0) ? infinity : 0;
  double power = 1;
  if (size == 0 || size == infinity)
    power = (size == 0) == (y > 0) ? 0 : infinity;
  else if (size != 1)
    power = positive_power(size, y);
  if (!std::signbit(x)) return power;
  if (is_odd(y)) return -power;
  return x < 0 && size != infinity && y != std::floor(y) ? not_a_number : power;
}

double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  int exponent = 0;
  double m = split_exponent(std::abs(x), exponent);
  const int third = exponent >= 0 ? (exponent + 2) / 3 : -(-exponent / 3);
  m = times_power_of_two(m, exponent - 3 * third);  // in [1/8, 1)
  // A cubic within .6 %; each step cubes the relative error (Halley 1694).
  double root = 0.3408 + m * (1.4581 - m * (1.3859 - m * 0.5922));
  for (int step = 0; step < 2; ++step) {
    const double cube = root * root * root;
    root -= root * (cube - m) / (2 * cube + m);
  }
  return std::copysign(times_power_of_two(root, third), x);
}

double hypot(double x, double y) { return hypot(x, y, 0); }

double hypot(double x, double y, double z) {
  if (std::isinf(x) || std::isinf(y) || std::isinf(z)) return infinity;
  if (x != x || y != y || z != z) return not_a_number;
  const double largest = std::fmax(std::abs(x), std::fmax(std::abs(y), std::abs(z)));
  if (largest == 0) return 0;
  if (largest > 0x1p-400 && largest < 0x1p400) return std::sqrt(x * x + y * y + z * z);
  int exponent = 0;
  std::frexp(largest, &exponent);
  const double a = std::ldexp(x, -exponent), b = std::ldexp(y, -exponent), c = std::ldexp(z, -exponent);
  return std::ldexp(std::sqrt(a * a + b * b + c * c), exponent);
}

double atan2(double y, double x) { return y < 0 ? -upper_angle(-y, x) : upper_angle(y, x); }

}  // namespace meander::portable
