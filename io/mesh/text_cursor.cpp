#include "io/mesh/text_cursor.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace meander::text {

namespace {

bool is_letter(char c) { return lower(c) >= 'a' && lower(c) <= 'z'; }

bool ends_token(const char* at, const char* end) { return at == end || is_separator(*at) || *at == '#'; }

// nan, inf, infinity, nan(...), with the sign already read; null when it is none of them.
const char* parse_special(const char* at, const char* end, double& value) {
  const char* p = at;
  while (p < end && is_letter(*p)) ++p;
  const std::string_view word(at, static_cast<std::size_t>(p - at));
  if (same_word(word, "inf") || same_word(word, "infinity")) {
    value = std::numeric_limits<double>::infinity();
  } else if (same_word(word, "nan") || same_word(word, "nanq") || same_word(word, "qnan") ||
             same_word(word, "nans") || same_word(word, "snan") || same_word(word, "ind")) {
    value = std::numeric_limits<double>::quiet_NaN();
    if (p < end && *p == '(') {
      while (p < end && *p != ')' && !is_separator(*p)) ++p;
      if (p < end && *p == ')') ++p;
    }
  } else {
    return nullptr;
  }
  return ends_token(p, end) ? p : nullptr;
}

// 1.#INF, 1.#QNAN, 1.#IND00 ...: `at` stands behind the #.
const char* parse_microsoft_special(const char* at, const char* end, double& value) {
  const char* p = at;
  while (p < end && is_letter(*p)) ++p;
  const std::string_view word(at, static_cast<std::size_t>(p - at));
  while (p < end && is_digit(*p)) ++p;
  if (same_word(word, "inf"))
    value = std::numeric_limits<double>::infinity();
  else if (same_word(word, "qnan") || same_word(word, "snan") || same_word(word, "ind") ||
           same_word(word, "nan"))
    value = std::numeric_limits<double>::quiet_NaN();
  else
    return nullptr;
  return ends_token(p, end) ? p : nullptr;
}

// The value of a decimal that from_chars reports as out of range: its digits decide between 0 and infinity.
double beyond_range(std::string_view digits) {
  const std::size_t mark = std::min(digits.find_first_of("eE"), digits.size());
  const std::string_view mantissa = digits.substr(0, mark);
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  const std::size_t leading = mantissa.find_first_of("123456789");
  if (leading == std::string_view::npos) return 0.0;
  std::int64_t power = 0;
  if (mark < digits.size()) parse_digits(digits.data() + mark + 1, digits.data() + digits.size(), power);
  power += static_cast<std::int64_t>(point) - static_cast<std::int64_t>(leading);
  return power > 0 ? std::numeric_limits<double>::infinity() : 0.0;
}

// 1.0D+00: an exponent of double precision, as Fortran writes it, behind the decimal that ends at `mark`.
const char* parse_fortran(const char* at, const char* mark, const char* end, double& value);

// A decimal without a sign.
const char* parse_decimal(const char* at, const char* end, double& value) {
  const auto [stop, error] = std::from_chars(at, end, value, std::chars_format::general);
  if (error == std::errc::invalid_argument) return nullptr;
  if (!ends_token(stop, end)) return lower(*stop) == 'd' ? parse_fortran(at, stop, end, value) : nullptr;
  if (error == std::errc::result_out_of_range)
    value = beyond_range({at, static_cast<std::size_t>(stop - at)});
  return stop;
}

const char* parse_fortran(const char* at, const char* mark, const char* end, double& value) {
  const char* stop = mark + 1;
  if (stop < end && (*stop == '-' || *stop == '+')) ++stop;
  const char* const digits = stop;
  while (stop < end && is_digit(*stop)) ++stop;
  std::string decimal(at, stop);
  decimal[static_cast<std::size_t>(mark - at)] = 'e';
  // No second exponent, so that this is not called again.
  const bool is_number = stop > digits && ends_token(stop, end) &&
                         decimal.find_first_of("eE") == static_cast<std::size_t>(mark - at);
  return is_number && parse_decimal(decimal.data(), decimal.data() + decimal.size(), value) != nullptr
             ? stop
             : nullptr;
}

}  // namespace

bool same_word(std::string_view word, std::string_view lower_case) {
  return word.size() == lower_case.size() && std::equal(word.begin(), word.end(), lower_case.begin(),
                                                        [](char a, char b) { return lower(a) == b; });
}

const char* parse_number_slowly(const char* at, const char* end, double& value) {
  const char* p = at;
  const bool negative = p < end && *p == '-';
  if (p < end && (*p == '-' || *p == '+')) ++p;
  if (p == end || *p == '-' || *p == '+') return nullptr;
  double size = 0;
  const char* next = nullptr;
  if (is_letter(*p)) {
    next = parse_special(p, end, size);
  } else if (end - p > 3 && is_digit(p[0]) && p[1] == '.' && p[2] == '#' && is_letter(p[3])) {
    next = parse_microsoft_special(p + 3, end, size);
  } else {
    next = parse_decimal(p, end, size);
  }
  if (next != nullptr) value = negative ? -size : size;
  return next;
}

const char* parse_digits_slowly(const char* at, const char* end, std::int64_t& value) {
  const char* p = at;
  const bool negative = p < end && *p == '-';
  if (p < end && (*p == '-' || *p == '+')) ++p;
  const char* const first = p;
  std::int64_t size = 0;
  while (p < end && is_digit(*p)) {
    size = size < 100'000'000'000'000'000 ? 10 * size + (*p - '0') : 1'000'000'000'000'000'000;
    ++p;
  }
  if (p == first) return nullptr;
  value = negative ? -size : size;
  return p;
}

const char* parse_whole_number(const char* at, const char* end, std::int64_t& value) {
  double number = 0;
  const char* const next = parse_number_slowly(at, end, number);
  constexpr double largest = std::int64_t{1} << 53;
  if (next == nullptr || !(std::abs(number) <= largest) || number != std::floor(number)) return nullptr;
  value = static_cast<std::int64_t>(number);
  return next;
}

std::size_t line_of(std::string_view text, const char* at) {
  return 1 + static_cast<std::size_t>(std::count(text.data(), at, '\n'));
}

std::string quoted(std::string_view text, const char* at) {
  constexpr std::size_t longest = 24;
  if (at == text.data() + text.size()) return "the end of the file";
  if (is_separator(*at)) return "the end of the line";
  std::string result = "`";
  for (const char* p = at; p < text.data() + text.size() && !is_separator(*p); ++p) {
    if (static_cast<std::size_t>(p - at) == longest) {
      result += "...";
      break;
    }
    result += *p > ' ' && *p <= '~' ? *p : '?';
  }
  return result + "`";
}

void fail_at(std::string_view text, const char* at, const std::string& what) {
  throw ItemError(Status::unreadable, "line " + std::to_string(line_of(text, at)) + ": " + what);
}

}  // namespace meander::text
