#include "jobs/units.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "jobs/inputs.h"

namespace meander {

namespace {

// A positive number and the unit behind it.
std::pair<double, std::string> number_and_unit(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number) || number < 0)
    throw UsageError(text + ": is not a number with a unit");
  std::string unit(end, text.data() + text.size());
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return {number, unit};
}

}  // namespace

std::uint64_t parse_bytes(const std::string& text) {
  auto [number, unit] = number_and_unit(text);
  if (unit.ends_with("ib")) unit.resize(unit.size() - 2);
  if (unit.ends_with('b')) unit.resize(unit.size() - 1);
  const std::string_view prefixes = "kmgt";
  if (!unit.empty()) {
    const std::size_t power = unit.size() == 1 ? prefixes.find(unit[0]) : std::string_view::npos;
    if (power == std::string_view::npos)
      throw UsageError(text + ": has an unknown unit; use K, M, G or T (powers of 1024)");
    number = std::ldexp(number, 10 * (static_cast<int>(power) + 1));
  }
  if (number >= 0x1p63) throw UsageError(text + ": is too large");
  return static_cast<std::uint64_t>(number);
}

double parse_seconds(const std::string& text) {
  const auto [number, unit] = number_and_unit(text);
  if (unit.empty() || unit == "s") return number;
  if (unit == "ms") return number / 1000;
  if (unit == "m" || unit == "min") return number * 60;
  if (unit == "h") return number * 3600;
  throw UsageError(text + ": has an unknown unit; use ms, s, m or h");
}

Budgets parse_budgets(const std::string& memory, const std::string& timeout,
                      std::vector<std::string>& problems) {
  Budgets budgets;
  try {
    budgets.memory_bytes = parse_bytes(memory);
  } catch (const UsageError& error) {
    problems.push_back(std::string("--memory: ") + error.what());
  }
  try {
    budgets.timeout_seconds = parse_seconds(timeout);
  } catch (const UsageError& error) {
    problems.push_back(std::string("--timeout: ") + error.what());
  }
  return budgets;
}

}  // namespace meander
