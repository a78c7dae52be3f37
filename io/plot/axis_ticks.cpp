#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "io/plot/svg_plot.h"

namespace meander {

namespace {

// mantissa x 10^power, correctly rounded for the powers that fit.
double scaled_ten(double mantissa, int power) {
  return power >= 0      ? mantissa * std::pow(10.0, power)
         : power >= -300 ? mantissa / std::pow(10.0, -power)
                         : mantissa / 1e300 / std::pow(10.0, -power - 300);
}

std::string with_minus(double value, int decimals) {
  const std::string digits = fmt::format("{:.{}f}", std::abs(value), decimals);
  return value < 0 ? "\u2212" + digits : digits;
}

std::string power_of_ten(int power) { return "10^{" + with_minus(power, 0) + "}"; }

// value is a multiple of 10^power; large_power is that of the largest tick.
AxisTick labelled(double value, int power, int large_power) {
  AxisTick tick{value, "0", true};
  if (value == 0) return tick;
  if (power >= -4 && large_power <= 5) {
    tick.label = with_minus(value, std::max(0, -power));
    return tick;
  }
  const double mantissa = scaled_ten(value, -large_power);
  const std::string digits = with_minus(mantissa, std::max(0, large_power - power));
  const std::string factor = digits == "1" ? "" : digits == "\u22121" ? "\u2212" : digits + "\u00D7";
  tick.label = factor + power_of_ten(large_power);
  return tick;
}

int floor_log10(double value) { return static_cast<int>(std::floor(std::log10(value))); }

std::vector<AxisTick> linear_ticks(double lower, double upper, std::size_t most) {
  // Halves: the whole difference may overflow.
  const double least_step = 2 * ((0.5 * upper - 0.5 * lower) / static_cast<double>(most));
  int power = floor_log10(std::max(least_step, 1e-300)) - 1;
  // A tick that rounding puts a hair outside still counts.
  const double slack = 1e-9;
  for (;; ++power)
    for (const int factor : {1, 2, 5}) {
      const double step = scaled_ten(factor, power);
      const double first = std::ceil(lower / step - slack), last = std::floor(upper / step + slack);
      if (last - first + 1 > static_cast<double>(most)) continue;
      std::vector<AxisTick> ticks;
      const double largest = step * std::max(std::abs(first), std::abs(last));
      const int large_power = largest > 0 ? floor_log10(largest * (1 + slack)) : power;
      for (double i = 0; i <= last - first; i += 1) {
        const double value = std::clamp(scaled_ten((first + i) * factor, power), lower, upper);
        // In a range of a few units in the last place neighbours may coincide.
        if (ticks.empty() || value > ticks.back().value) ticks.push_back(labelled(value, power, large_power));
      }
      return ticks;
    }
}

std::vector<AxisTick> log_ticks(double lower, double upper, std::size_t most) {
  const double slack = 1 + 1e-9;
  const auto inside = [&](double value) { return value >= lower / slack && value <= upper * slack; };
  const int first = floor_log10(lower) - 1, last = floor_log10(upper) + 1;
  std::size_t powers = 0, rounds = 0;
  for (int power = first; power <= last; ++power)
    for (const int digit : {1, 2, 5})
      if (inside(scaled_ten(digit, power))) {
        ++rounds;
        if (digit == 1) ++powers;
      }
  if (rounds < 2) return linear_ticks(lower, upper, most);
  const bool decades = powers >= 2;
  const int stride = decades ? static_cast<int>((powers + most - 1) / most) : 1;
  std::vector<AxisTick> ticks;
  for (int power = first; power <= last; ++power)
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = scaled_ten(digit, power);
      if (!inside(value)) continue;
      const double kept = std::clamp(value, lower, upper);
      if (decades && digit == 1 && power % stride == 0)
        ticks.push_back({kept, power_of_ten(power), true});
      else if (!decades && (digit == 1 || digit == 2 || digit == 5))
        ticks.push_back(labelled(kept, power, power));
      else if (digit == 1 || stride == 1)
        ticks.push_back({kept, "", false});
    }
  return ticks;
}

}  // namespace

std::vector<AxisTick> axis_ticks(AxisScale scale, double lower, double upper, std::size_t most) {
  if (!std::isfinite(lower) || !std::isfinite(upper) || !(lower < upper) || most < 2 ||
      (scale == AxisScale::log10 && !(lower > 0)))
    throw std::invalid_argument("axis_ticks: no such range");
  return scale == AxisScale::log10 ? log_ticks(lower, upper, most) : linear_ticks(lower, upper, most);
}

}  // namespace meander
