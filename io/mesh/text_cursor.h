// Internal to the mesh readers: a cursor over the bytes of a text, its numbers, and sentences about places in
// it.
//
// Everything up to a space (tabs, carriage returns, form feeds, the NUL bytes of padded files) separates
// tokens. Numbers are those of the C locale whatever the program's locale is. Nothing reads at or behind
// `end`.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "kernels/core/status.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander::text {

inline bool is_separator(char c) { return static_cast<unsigned char>(c) <= ' '; }
inline bool is_blank(char c) { return is_separator(c) && c != '\n'; }
inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }
inline char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; }
// Whether `word` (any case) is `lower_case`.
bool same_word(std::string_view word, std::string_view lower_case);

// The whole story of parse_number: specials, long mantissas, large exponents. Same result and cost class
// ~100 ns.
const char* parse_number_slowly(const char* at, const char* end, double& value);

// The number that starts at `at`, correctly rounded; returns where it ends, or null when there is no number
// or something other than a separator or `#` follows it. Accepts a leading +, 1. and .5, nan and inf in the
// spellings of C, Microsoft (-nan(ind), 1.#QNAN, 1.#INF) and others; overflow gives +-inf, underflow +-0.
inline const char* parse_number(const char* at, const char* end, double& value) {
  // Products and quotients of integers up to 2^53 and powers of ten up to 10^22 are rounded once (Clinger
  // 1990).
  static constexpr std::array<double, 23> power_of_ten = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                          1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                          1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const char* p = at;
  const bool negative = p < end && *p == '-';
  if (p < end && (*p == '-' || *p == '+')) ++p;
  std::uint64_t mantissa = 0;
  const char* const integer = p;
  while (p < end && is_digit(*p)) mantissa = 10 * mantissa + static_cast<std::uint64_t>(*p++ - '0');
  auto digits = p - integer;
  std::int64_t exponent = 0;
  if (p < end && *p == '.') {
    const char* const fraction = ++p;
    while (p < end && is_digit(*p)) mantissa = 10 * mantissa + static_cast<std::uint64_t>(*p++ - '0');
    exponent = fraction - p;
    digits += p - fraction;
  }
  if (digits == 0 || digits > 19) return parse_number_slowly(at, end, value);
  if (p < end && !is_separator(*p)) {
    if (*p != 'e' && *p != 'E') return *p == '#' ? parse_number_slowly(at, end, value) : nullptr;
    const char* q = p + 1;
    const bool down = q < end && *q == '-';
    if (q < end && (*q == '-' || *q == '+')) ++q;
    const char* const first = q;
    std::int64_t power = 0;
    while (q < end && is_digit(*q) && power < 100000) power = 10 * power + (*q++ - '0');
    if (q == first || (q < end && !is_separator(*q))) return parse_number_slowly(at, end, value);
    exponent += down ? -power : power;
    p = q;
  }
  if (mantissa > (std::uint64_t{1} << 53) || exponent < -22 || exponent > 22)
    return parse_number_slowly(at, end, value);
  const double whole = static_cast<double>(mantissa);
  const double size = exponent < 0 ? whole / power_of_ten[static_cast<std::size_t>(-exponent)]
                                   : whole * power_of_ten[static_cast<std::size_t>(exponent)];
  value = negative ? -size : size;
  return p;
}

// The integer that starts at `at`, saturated at +-10^18; returns where its digits end, or null without
// digits. What follows is not looked at.
inline const char* parse_digits(const char* at, const char* end, std::int64_t& value) {
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

// A zero-based vertex number as PolygonMesh keeps it.
inline std::uint32_t to_index(std::int64_t number) {
  return number < 0 || number >= std::int64_t{no_index} ? no_index : static_cast<std::uint32_t>(number);
}

inline const char* find_line_end(const char* at, const char* end) {
  const void* const found = at < end ? std::memchr(at, '\n', static_cast<std::size_t>(end - at)) : nullptr;
  return found != nullptr ? static_cast<const char*>(found) : end;
}

enum class Token : std::uint8_t { ok, bad, ended };

// Tokens one after the other, over line ends; with `hash_comments`, # starts a comment up to the end of its
// line.
struct TextCursor {
  const char* at;
  const char* end;
  bool hash_comments = true;

  // Moves to the next token; false at the end.
  bool skip_to_token() {
    for (;;) {
      while (at < end && is_separator(*at)) ++at;
      if (at == end) return false;
      if (*at != '#' || !hash_comments) return true;
      skip_line();
    }
  }
  // Moves to the start of the next line, or the end.
  void skip_line() {
    at = find_line_end(at, end);
    if (at < end) ++at;
  }
  // Whether the current line holds another token.
  bool token_on_line() {
    while (at < end && is_blank(*at)) ++at;
    return at < end && *at != '\n' && (*at != '#' || !hash_comments);
  }
  // A bad token is not consumed.
  Token number(double& value) {
    if (!skip_to_token()) return Token::ended;
    const char* const next = parse_number(at, end, value);
    if (next == nullptr) return Token::bad;
    at = next;
    return Token::ok;
  }
  Token integer(std::int64_t& value) {
    if (!skip_to_token()) return Token::ended;
    const char* const next = parse_digits(at, end, value);
    if (next == nullptr || (next < end && !is_separator(*next) && *next != '#')) return Token::bad;
    at = next;
    return Token::ok;
  }
  // The token up to the next separator.
  std::string_view word() {
    if (!skip_to_token()) return {};
    const char* const first = at;
    while (at < end && !is_separator(*at)) ++at;
    return {first, static_cast<std::size_t>(at - first)};
  }
};

// 1 + the number of line ends before `at`.
std::size_t line_of(std::string_view text, const char* at);
// The token at `at` in quotes: at most 24 bytes, what is not printable ASCII replaced.
std::string quoted(std::string_view text, const char* at);
// Throws ItemError(unreadable, "line 12: ...").
[[noreturn]] void fail_at(std::string_view text, const char* at, const std::string& what);

}  // namespace meander::text
