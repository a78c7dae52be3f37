#include "io/table/table.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "io/special_values.h"
#include "support/catch.h"

using namespace meander;
using namespace meander::test;

namespace {

// An independent reader of RFC 4180.
std::vector<std::vector<std::string>> read_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row{""};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      row.back() += text[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && c == ',') {
      row.emplace_back();
    } else if (!quoted && c == '\n') {
      rows.push_back(row);
      row = {""};
    } else {
      row.back() += c;
    }
  }
  return rows;
}

Table results() {
  Table table;
  table.columns = {{"method"}, {"N"}, {"error"}, {"slope", 3}};
  table.rows = {
      {"random", 1024, 0.0123456, -0.5}, {"Owen \u2014 Sobol", 1572864, 0.5, not_a_number}, {"none"}};
  return table;
}

}  // namespace

TEST_CASE("readable_number: digits, exponents and special values") {
  CHECK(readable_number(0, 4) == "0");
  CHECK(readable_number(0.5, 4) == "0.5000");
  CHECK(readable_number(9.99996, 4) == "10.00");
  CHECK(readable_number(123456.7, 4) == "123457");
  CHECK(readable_number(-0.65123, 3) == "-0.651");
  CHECK(readable_number(0.000123456, 3) == "0.000123");
  CHECK(readable_number(0.0000123456, 3) == "1.23e-05");
  CHECK(readable_number(12345678, 3) == "1.23e+07");
  CHECK(readable_number(5, 1) == "5");
  CHECK(readable_number(not_a_number, 4) == "-");
  CHECK(readable_number(-infinity, 4) == "-inf");
}

TEST_CASE("TableCell: integers of every type are exact") {
  CHECK(whole_number(TableCell(-7)) == "-7");
  CHECK(whole_number(TableCell(std::numeric_limits<std::int64_t>::min())) == "-9223372036854775808");
  CHECK(whole_number(TableCell(std::numeric_limits<std::uint64_t>::max())) == "18446744073709551615");
  CHECK(whole_number(TableCell(std::uint8_t{200})) == "200");
  CHECK(whole_number(TableCell(std::int8_t{-128})) == "-128");
}

TEST_CASE("text_table: names and numbers are aligned in columns") {
  CHECK(text_table(results()) ==
        "method              N    error   slope\n"
        "random           1024  0.01235  -0.500\n"
        "Owen \u2014 Sobol  1572864   0.5000       -\n"
        "none\n");
}

TEST_CASE("text_table: no columns, no rows, control characters") {
  CHECK(text_table({}) == "");
  Table table;
  table.columns = {{"a"}, {"long name"}};
  CHECK(text_table(table) == "a  long name\n");
  table.rows = {{"x\ny\x1B[31m", 3}};
  CHECK(text_table(table) ==
        "a         long name\n"
        "x y [31m          3\n");
}

TEST_CASE("csv_text: numbers and texts survive a round trip") {
  Table table;
  table.columns = {{"a, \"b\""}, {"number"}};
  const std::vector<std::string> texts{"plain",      "",       "a,b",  "say \"so\"", "two\nlines", " edge",
                                       "carriage\r", "\u00E9", "\xFF", "\"",         ","};
  const std::vector<double> numbers{0.1,     -0.0,      1e-320, 1.7976931348623157e308,
                                    1.0 / 3, 123456789, 2.5e-9, std::nextafter(1.0, 2.0),
                                    5e-324,  1e22,      -7};
  for (std::size_t i = 0; i < texts.size(); ++i) table.rows.push_back({texts[i], numbers[i]});
  const auto rows = read_csv(csv_text(table));
  REQUIRE(rows.size() == texts.size() + 1);
  CHECK(rows[0] == std::vector<std::string>{"a, \"b\"", "number"});
  for (std::size_t i = 0; i < texts.size(); ++i) {
    REQUIRE(rows[i + 1].size() == 2);
    CHECK(rows[i + 1][0] == texts[i]);
    double again = not_a_number;
    const std::string& digits = rows[i + 1][1];
    std::from_chars(digits.data(), digits.data() + digits.size(), again);
    CHECK(std::bit_cast<std::uint64_t>(again) == std::bit_cast<std::uint64_t>(numbers[i]));
  }
}

TEST_CASE("csv_text: numbers, missing values and infinities as text") {
  Table table = results();
  table.rows.push_back({"odd", TableCell(), -not_a_number, -infinity});
  CHECK(csv_text(table) ==
        "method,N,error,slope\n"
        "random,1024,0.0123456,-0.5\n"
        "Owen \u2014 Sobol,1572864,0.5,nan\n"
        "none,,,\n"
        "odd,,nan,-inf\n");
  CHECK(csv_text({}) == "");
  table.rows.clear();
  CHECK(csv_text(table) == "method,N,error,slope\n");
}

TEST_CASE("write_table: JSON objects, one per row") {
  JsonWriter json;
  json.begin_object();
  json.key("rows");
  Table table = results();
  table.rows.push_back({"n", std::numeric_limits<std::int64_t>::min()});
  write_table(json, table);
  json.end_object();
  CHECK(json.text() ==
        "{\"rows\":[{\"method\":\"random\",\"N\":1024,\"error\":0.0123456,\"slope\":-0.5},"
        "{\"method\":\"Owen \u2014 Sobol\",\"N\":1572864,\"error\":0.5,\"slope\":null},"
        "{\"method\":\"none\",\"N\":null,\"error\":null,\"slope\":null},"
        "{\"method\":\"n\",\"N\":-9223372036854775808,\"error\":null,\"slope\":null}]}");
}

TEST_CASE("check_table: invalid tables are errors") {
  Table table = results();
  table.rows.push_back({1, 2, 3, 4, 5});
  CHECK_THROWS_AS(text_table(table), std::invalid_argument);
  CHECK_THROWS_AS(csv_text(table), std::invalid_argument);
  table = results();
  table.columns[0].digits = 0;
  CHECK_THROWS_AS(text_table(table), std::invalid_argument);
}
