// A table of results, to be printed, written as CSV, as JSON or into a page.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meander {

enum class CellKind { empty, number, whole, text };

// Nothing, a number, a whole number or text.
struct TableCell {
  CellKind kind = CellKind::empty;
  double number = 0;
  bool negative = false;  // the whole number is -magnitude
  std::uint64_t magnitude = 0;
  std::string text{};

  TableCell() = default;
  TableCell(double value) : kind(CellKind::number), number(value) {}
  template <std::integral T>
  requires(!std::same_as<T, bool>) TableCell(T value) : kind(CellKind::whole), negative(value < T{0}) {
    magnitude =
        negative ? std::uint64_t{0} - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
  }
  TableCell(std::string value) : kind(CellKind::text), text(std::move(value)) {}
  TableCell(std::string_view value) : TableCell(std::string(value)) {}
  TableCell(const char* value) : TableCell(std::string(value)) {}
};

struct TableColumn {
  std::string name{};
  int digits = 4;  // significant ones of numbers for the eye, 1..17; CSV and JSON always keep all
};

struct Table {
  std::vector<TableColumn> columns{};
  std::vector<std::vector<TableCell>> rows{};  // shorter ones end in empty cells
};

// Throws std::invalid_argument when a row is longer than there are columns or digits are out of range. Called
// by everything that writes a table.
void check_table(const Table& table);

// A number with that many significant digits for the eye: plain from 0.0001 to 9999999 (whole digits are
// never rounded away), else with an exponent; "-" for NaN, "inf", "-inf".
std::string readable_number(double number, int digits);

// A whole number in full.
std::string whole_number(const TableCell& cell);

// A cell for the eye: readable_number for numbers, whole numbers in full, nothing for empty cells.
std::string readable_cell(const TableCell& cell, int digits);

// No text stands in the column (of a table that check_table accepts): its entries go flush right.
bool is_numeric_column(const Table& table, std::size_t column);

}  // namespace meander
