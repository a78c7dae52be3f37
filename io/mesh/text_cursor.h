// Internal to the mesh readers: a cursor over the bytes of a text, its numbers, and sentences about places in
// it.
//
// Spaces, tabs, line ends, form feeds and the NUL bytes of padded files separate tokens. Other control bytes
// do not: one bit away from a digit, they would make two numbers of one. Numbers are those of the C locale
// whatever the program's locale is. Nothing reads at or behind `end`.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "kernels/core/status.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander::text {

inline bool is_separator(char c) {
  // NUL, tab, line feed, vertical tab, form feed, carriage return, ^Z (the end of a DOS text) and space.
  constexpr std::uint64_t separators = 1u | 0x1fu << 9 | 1u << 26 | std::uint64_t{1} << 32;
  const auto byte = static_cast<unsigned char>(c);
  return byte <= ' ' && (separators >> byte & 1) != 0;
}
inline bool is_blank(char c) { return is_separator(c) && c != '\n'; }
inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }
inline char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; }
// Whether `word` (any case) is `lower_case`.
bool same_word(std::string_view word, std::string_view lower_case);

// Any number, however it is written.
const char* parse_number_slowly(const char* at, const char* end, double& value);
// Any integer, saturated.
const char* parse_digits_slowly(const char* at, const char* end, std::int64_t& value);
// A whole number that may have a point and an exponent, as programs write it that have one format for all:
// `3.0`, `3.000000e+00`. Null for other numbers and beyond +-2^53.
const char* parse_whole_number(const char* at, const char* end, std::int64_t& value);

// The digits that eight bytes begin with, all at once: no branch depends on how many there are.
struct Digits {
  std::uint64_t value;
  unsigned count;  // 0 .. 8

  // Eight bytes can be read at `at`.
  static Digits at(const char* at) {
    std::uint64_t bytes;
    std::memcpy(&bytes, at, sizeof bytes);
    if constexpr (std::endian::native == std::endian::big) bytes = __builtin_bswap64(bytes);
    bytes ^= 0x3030303030303030u;  // digits become 0 .. 9
    // The top bit of the first byte that is not a digit; carries only reach bytes behind it.
    const std::uint64_t others = (bytes | (bytes + 0x7676767676767676u)) & 0x8080808080808080u;
    if (others == 0) return {combine(bytes), 8};
    const auto bits = static_cast<unsigned>(std::countr_zero(others)) & ~7u;
    return {bits == 0 ? 0 : combine(bytes << (64 - bits)), bits / 8};
  }

 private:
  // Pairs, then fours, then eight (Lemire 2021, the parsing of eight digits).
  static std::uint64_t combine(std::uint64_t bytes) {
    bytes = bytes * 10 + (bytes >> 8);
    return (((bytes & 0x000000FF000000FFu) * 0x000F424000000064u) +
            (((bytes >> 16) & 0x000000FF000000FFu) * 0x0000271000000001u)) >>
           32;
  }
};

// The number that starts at `at`, correctly rounded; returns where it ends, or null when there is no number
// or something other than a separator or `#` follows it. Accepts a leading +, 1. and .5, nan and inf in the
// spellings of C, Microsoft (-nan(ind), 1.#QNAN, 1.#INF) and others, and exponents of Fortran (1.0D+00);
// overflow gives +-inf, underflow +-0.
inline const char* parse_number(const char* at, const char* end, double& value) {
  // An integer up to 2^53 over a power of ten up to 10^22 is rounded once (Clinger 1990).
  static constexpr std::array<double, 17> power_of_ten = {1e0, 1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7, 1e8,
                                                          1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16};
  static constexpr std::array<std::uint64_t, 9> scale = {1,      10,      100,      1000,     10000,
                                                         100000, 1000000, 10000000, 100000000};
  if (end - at < 40) return parse_number_slowly(at, end, value);
  const char* p = at;
  const bool negative = *p == '-';
  p += negative ? 1 : 0;
  const Digits integer = Digits::at(p);
  p += integer.count;
  std::uint64_t mantissa = integer.value;
  unsigned decimals = 0;
  if (*p == '.') {
    const Digits fraction = Digits::at(++p);
    p += fraction.count;
    mantissa = mantissa * scale[fraction.count] + fraction.value;
    decimals = fraction.count;
    if (fraction.count == 8) {
      const Digits more = Digits::at(p);
      p += more.count;
      // Eight digits before the point and sixteen behind it would not fit.
      if (integer.count > 3) return parse_number_slowly(at, end, value);
      mantissa = mantissa * scale[more.count] + more.value;
      decimals += more.count;
    }
  }
  if (!is_separator(*p) || integer.count + decimals == 0 || integer.count == 8 ||
      mantissa > (std::uint64_t{1} << 53))
    return parse_number_slowly(at, end, value);
  const double size = static_cast<double>(mantissa) / power_of_ten[decimals];
  value = negative ? -size : size;
  return p;
}

// The integer that starts at `at`, saturated at +-10^18; returns where its digits end, or null without
// digits. What follows is not looked at.
inline const char* parse_digits(const char* at, const char* end, std::int64_t& value) {
  if (end - at < 16) return parse_digits_slowly(at, end, value);
  const bool negative = *at == '-';
  const Digits digits = Digits::at(at + (negative ? 1 : 0));
  if (digits.count == 0 || digits.count == 8) return parse_digits_slowly(at, end, value);
  value = negative ? -static_cast<std::int64_t>(digits.value) : static_cast<std::int64_t>(digits.value);
  return at + (negative ? 1 : 0) + digits.count;
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
  // The length of a list that follows. One that the rest of the text cannot hold is bad, or the text ends in
  // it.
  Token length(std::int64_t& value) {
    const Token token = integer(value);
    return token == Token::ok ? fitting(value) : token;
  }
  Token fitting(std::int64_t value) const {
    if (value >= 0 && value <= end - at) return Token::ok;
    return value > 0 && find_line_end(at, end) == end ? Token::ended : Token::bad;
  }
  // The token up to the next separator.
  std::string_view word() {
    if (!skip_to_token()) return {at, 0};
    const char* const first = at;
    while (at < end && !is_separator(*at)) ++at;
    return {first, static_cast<std::size_t>(at - first)};
  }
};

// 1 + the number of line ends before `at`.
std::size_t line_of(std::string_view text, const char* at);
// The token at `at` in quotes: at most 24 bytes, what is not printable ASCII replaced; or that there is none.
std::string quoted(std::string_view text, const char* at);
// Throws ItemError(unreadable, "line 12: ...").
[[noreturn]] void fail_at(std::string_view text, const char* at, const std::string& what);

}  // namespace meander::text
