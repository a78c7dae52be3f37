#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "io/mesh/text_cursor.h"
#include "kernels/core/random.h"
#include "support/catch.h"

using namespace meander;

namespace {

// The number at the start of `token` followed by `behind`; NaN with *ok = false when there is none.
double parsed(const std::string& token, bool& ok, const std::string& behind = "") {
  const std::string text = token + behind;
  double value = std::numeric_limits<double>::quiet_NaN();
  const char* const end = text::parse_number(text.data(), text.data() + text.size(), value);
  ok = end == text.data() + token.size();
  return value;
}

// Text for the fast path, which needs some bytes after the number.
const std::string room = " 0.5 0.25 and so on until the end of the line is far enough away";

}  // namespace

TEST_CASE("parse_number: numbers in every spelling, with and without text after them") {
  const double inf = std::numeric_limits<double>::infinity();
  const std::pair<const char*, double> cases[] = {{"0", 0},
                                                  {"-0", -0.0},
                                                  {"1", 1},
                                                  {"+1.5", 1.5},
                                                  {"-1.5", -1.5},
                                                  {"1.", 1},
                                                  {".5", 0.5},
                                                  {"-.5", -0.5},
                                                  {"+.5", 0.5},
                                                  {"007", 7},
                                                  {"1e3", 1000},
                                                  {"1E+3", 1000},
                                                  {"1.5e-3", 0.0015},
                                                  {"12345678", 12345678},
                                                  {"123456789", 123456789},
                                                  {"0.12345678", 0.12345678},
                                                  {"0.1234567890123456", 0.1234567890123456},
                                                  {"0.12345678901234567", 0.12345678901234567},
                                                  {"9007199254740993", 9007199254740992.0},
                                                  {"123456.123456789012345", 123456.123456789012345},
                                                  {"100000000.0", 1e8},
                                                  {"99999999.9", 99999999.9},
                                                  {"1e-310", 1e-310},
                                                  {"4.9e-324", 4.9e-324},
                                                  {"2.2250738585072011e-308", 2.2250738585072011e-308},
                                                  {"1e400", inf},
                                                  {"-1e400", -inf},
                                                  {"1e-400", 0},
                                                  {"0e999999999999999999999", 0},
                                                  {"1e999999999999999999999", inf},
                                                  {"1e-999999999999999999999", 0},
                                                  {"0.000001e309", 1e303},
                                                  {"1000000e-329", 1e-323},
                                                  {"inf", inf},
                                                  {"-inf", -inf},
                                                  {"+Infinity", inf},
                                                  {"INF", inf},
                                                  {"1.#INF", inf},
                                                  {"-1.#INF", -inf},
                                                  {"1.#INF00", inf},
                                                  {"1.0D+00", 1},
                                                  {"-2.5d-1", -0.25},
                                                  {"1D3", 1000},
                                                  {".5d1", 5},
                                                  {"1D400", inf},
                                                  {"0.12345678901234567D+00", 0.12345678901234567}};
  for (const auto& [token, expected] : cases)
    for (const std::string& behind : {std::string(), std::string("\n"), std::string("#"), room}) {
      CAPTURE(token, behind);
      bool ok = false;
      const double value = parsed(token, ok, behind);
      REQUIRE(ok);
      REQUIRE(std::bit_cast<std::uint64_t>(value) == std::bit_cast<std::uint64_t>(expected));
    }
  for (const char* const token : {"nan", "NaN", "-nan", "nan(ind)", "-nan(ind)", "nan(snan)", "1.#QNAN",
                                  "-1.#IND", "1.#QNAN0", "1.#SNAN", "-1.#IND00"})
    for (const std::string& behind : {std::string(), std::string("\r\n"), room}) {
      CAPTURE(token, behind);
      bool ok = false;
      REQUIRE(std::isnan(parsed(token, ok, behind)));
      REQUIRE(ok);
    }
}

TEST_CASE("parse_number: text that is not a number is refused") {
  for (const char* const token :
       {"",       "-",           "+",      ".",   "-.",        "e5",           "1,5",
        "1.5.2",  "--1",         "+-1",    "1e",  "1e+",       "1x",           "0x10",
        "nanny",  "information", "1.#ABC", "1/2", "12345678x", "0.123456789x", "0.1\0215",
        "1\0165", "\1771",       "1D",     "D5",  "1D+",       "1e5D3",        "1D5e3",
        "1D1.5",  "1dd3"})
    for (const std::string& behind : {std::string(), room}) {
      CAPTURE(token, behind);
      bool ok = true;
      parsed(token, ok, behind);
      const std::string text = token + behind;
      double value = 0;
      REQUIRE(text::parse_number(text.data(), text.data() + text.size(), value) == nullptr);
    }
}

TEST_CASE("parse_whole_number: integers written with points and exponents, and nothing else") {
  const auto whole = [](std::string_view text) {
    std::int64_t value = -77;
    const char* const next = text::parse_whole_number(text.data(), text.data() + text.size(), value);
    return next == nullptr ? std::int64_t{-77} : value;
  };
  REQUIRE(whole("3.0") == 3);
  REQUIRE(whole("3.000000000000000000e+00 1") == 3);
  REQUIRE(whole("-12") == -12);
  REQUIRE(whole("1.5e1") == 15);
  REQUIRE(whole("9007199254740992.0") == 9007199254740992);
  for (const char* const none : {"1.5", "x", "", "nan", "inf", "1e300", "-1e300", "3,0", "1e-300"})
    REQUIRE(whole(none) == -77);
}

TEST_CASE("parse_number: random decimals are rounded as by strtod") {
  for (std::uint32_t i = 0; i < 200000; ++i) {
    const PhiloxBlock random = philox4x32({i, 0, 0, 0}, {1, 2});
    const std::uint32_t shape = random[0];
    std::string token(shape & 1 ? 1 : 0, '-');
    const unsigned before = shape >> 1 & 7, behind = shape >> 4 & 15, exponent = shape >> 8 & 3;
    std::uint64_t digits = std::uint64_t{random[1]} << 32 | random[2];
    const auto append = [&](unsigned count) {
      for (unsigned k = 0; k < count; ++k, digits /= 10) token += static_cast<char>('0' + digits % 10);
    };
    append(before);
    if (behind > 0 || before == 0) {
      token += '.';
      append(behind + (before == 0 && behind == 0 ? 1 : 0));
    }
    if (exponent == 3) (token += 'e') += std::to_string(static_cast<int>(shape >> 12 & 1023) - 512);
    bool ok = false;
    const double value = parsed(token, ok, i % 2 == 0 ? room : "");
    CAPTURE(token);
    REQUIRE(ok);
    REQUIRE(std::bit_cast<std::uint64_t>(value) ==
            std::bit_cast<std::uint64_t>(std::strtod(token.c_str(), nullptr)));
  }
}

TEST_CASE("parse_digits: integers saturate and end at the first non-digit") {
  const std::pair<const char*, std::int64_t> cases[] = {{"0", 0},
                                                        {"-7", -7},
                                                        {"+7", 7},
                                                        {"1234567", 1234567},
                                                        {"12345678", 12345678},
                                                        {"-123456789012", -123456789012},
                                                        {"99999999999999999999999", 1000000000000000000}};
  for (const auto& [token, expected] : cases)
    for (const std::string& behind : {std::string(), std::string("/2"), room}) {
      const std::string text = token + behind;
      std::int64_t value = 0;
      CAPTURE(text);
      REQUIRE(text::parse_digits(text.data(), text.data() + text.size(), value) ==
              text.data() + std::string_view(token).size());
      REQUIRE(value == expected);
    }
  std::int64_t value = 0;
  for (const std::string& text : {std::string("x"), std::string(), std::string("-"), "-x" + room, room}) {
    CAPTURE(text);
    REQUIRE(text::parse_digits(text.data(), text.data() + text.size(), value) == nullptr);
  }
  REQUIRE(text::to_index(-1) == no_index);
  REQUIRE(text::to_index(4294967294) == 4294967294u);
  REQUIRE(text::to_index(4294967295) == no_index);
  REQUIRE(text::to_index(4294967296) == no_index);
}

TEST_CASE("text cursor: tokens, comments and lines") {
  const std::string text = " 1 # two three\n\n\t4 5#6\r\n7";
  text::TextCursor cursor{text.data(), text.data() + text.size()};
  double value = 0;
  REQUIRE(cursor.number(value) == text::Token::ok);
  REQUIRE(value == 1);
  REQUIRE_FALSE(cursor.token_on_line());
  REQUIRE(cursor.number(value) == text::Token::ok);
  REQUIRE(value == 4);
  REQUIRE(cursor.token_on_line());
  std::int64_t integer = 0;
  REQUIRE(cursor.integer(integer) == text::Token::ok);
  REQUIRE(integer == 5);
  REQUIRE(cursor.integer(integer) == text::Token::ok);
  REQUIRE(integer == 7);
  REQUIRE(cursor.integer(integer) == text::Token::ended);
  REQUIRE(text::line_of(text, cursor.at) == 4);
}

TEST_CASE("text cursor: quotations of a file are short and printable") {
  const std::string dirty =
      "ab\xFF"
      "cd ef";
  REQUIRE(text::quoted(dirty, dirty.data()) == "`ab?cd`");
  const std::string longer(100, 'x');
  REQUIRE(text::quoted(longer, longer.data()) == "`" + std::string(24, 'x') + "...`");
  REQUIRE(text::quoted(longer, longer.data() + 100) == "the end of the file");
}
