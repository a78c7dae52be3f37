// A table of results, to be printed, written as CSV, as JSON or into a page.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace meander {

// Nothing, a number, a whole number or text.
class TableCell {
 public:
  TableCell() = default;
  TableCell(double number) : value(number) {}
  template <std::signed_integral T>
  TableCell(T number) : value(static_cast<std::int64_t>(number)) {}
  template <std::unsigned_integral T>
  requires(!std::same_as<T, bool>) TableCell(T number) : value(static_cast<std::uint64_t>(number)) {}
  TableCell(std::string text) : value(std::move(text)) {}
  TableCell(std::string_view text) : value(std::string(text)) {}
  TableCell(const char* text) : value(std::string(text)) {}

  std::variant<std::monostate, double, std::int64_t, std::uint64_t, std::string> value;
};

struct TableColumn {
  std::string name;
  int digits = 4;  // significant ones of numbers for the eye, 1..17; CSV and JSON always keep all
};

struct Table {
  std::vector<TableColumn> columns;
  std::vector<std::vector<TableCell>> rows;  // shorter ones end in empty cells
};

// Throws std::invalid_argument when a row is longer than there are columns or digits are out of range. Called
// by everything that writes a table.
void check_table(const Table& table);

// A number with that many significant digits for the eye: plain from 0.0001 to 9999999 (whole digits are
// never rounded away), else with an exponent; "-" for NaN, "inf", "-inf".
std::string readable_number(double number, int digits);

}  // namespace meander
