#include "jobs/cli/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "io/store/run_array.h"
#include "io/word_list.h"
#include "jobs/cli/usage_error.h"

namespace meander {

namespace {

// A positive number and the unit behind it.
std::pair<double, std::string> number_and_unit(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number) || number < 0)
    throw UsageError("`" + text + "` is neither a size such as 4G nor a time such as 90s");
  return {number, lower_ascii({end, static_cast<std::size_t>(text.data() + text.size() - end)})};
}

}  // namespace

std::string plain_count(const std::string& text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto digits_end = [&](std::size_t at) {
    while (at < text.size() && is_digit(text[at])) ++at;
    return at;
  };
  std::size_t at = digits_end(0);
  std::string digits = text.substr(0, at);
  if (digits.empty() || at == text.size()) return text;
  int places = 0;  // by which the decimal point moves to the right
  if (text[at] == '.') {
    const std::size_t end = digits_end(at + 1);
    digits += text.substr(at + 1, end - at - 1);
    places -= static_cast<int>(end - at - 1);
    at = end;
  }
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    const std::size_t begin = at + 1 + (at + 1 < text.size() && text[at + 1] == '+');
    const std::size_t end = digits_end(begin);
    if (end == begin || end - begin > 2) return text;
    places += std::stoi(text.substr(begin, end - begin));
    at = end;
  }
  if (at + 1 == text.size()) {
    const std::size_t power = std::string_view("kmgt").find(static_cast<char>(std::tolower(text[at])));
    if (power == std::string_view::npos) return text;
    places += 3 * (static_cast<int>(power) + 1);
    ++at;
  }
  if (at != text.size()) return text;
  for (; places > 0; --places) digits += '0';
  for (; places < 0 && digits.ends_with('0'); ++places) digits.pop_back();
  if (places < 0 || digits.empty()) return text;
  const std::size_t first = std::min(digits.find_first_not_of('0'), digits.size() - 1);
  return digits.substr(first);
}

std::uint64_t parse_bytes(const std::string& text) {
  auto [number, unit] = number_and_unit(text);
  if (unit.ends_with("ib")) unit.resize(unit.size() - 2);
  if (unit.ends_with('b')) unit.resize(unit.size() - 1);
  const std::string_view prefixes = "kmgt";
  if (!unit.empty()) {
    const std::size_t power = unit.size() == 1 ? prefixes.find(unit[0]) : std::string_view::npos;
    if (power == std::string_view::npos)
      throw UsageError("`" + text + "` has an unknown unit: use K, M, G or T (powers of 1024)");
    number = std::ldexp(number, 10 * (static_cast<int>(power) + 1));
  }
  if (number >= 0x1p63) throw UsageError("`" + text + "` is too large");
  return static_cast<std::uint64_t>(number);
}

double parse_seconds(const std::string& text) {
  const auto [number, unit] = number_and_unit(text);
  if (unit.empty() || unit == "s") return number;
  if (unit == "ms") return number / 1000;
  if (unit == "m" || unit == "min") return number * 60;
  if (unit == "h") return number * 3600;
  throw UsageError("`" + text + "` has an unknown unit: use ms, s, m or h");
}

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end || text.empty()) return std::nullopt;
  return value;
}

StoreShard parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  const std::string_view all(text);
  const auto index = number_in(all.substr(0, slash));
  const auto count = number_in(slash == std::string::npos ? std::string_view() : all.substr(slash + 1));
  if (!index || !count || *count < 1 || *count > max_shards)
    throw UsageError(fmt::format("--shard: `{}` is not of the form i/n, such as 0/16", text));
  if (*index >= *count)
    throw UsageError(
        fmt::format("--shard: there is no shard {}: they are numbered from 0 to {}", *index, *count - 1));
  return {*index, *count};
}

}  // namespace meander
