// A table of results, printed on a terminal, written as CSV or JSON, or shown in a page.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/json_writer.h"

namespace meander {

enum class CellKind { empty, number, whole, text };

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
  int digits = 4;  // significant digits of printed numbers, 1 to 17; CSV and JSON keep all
};

struct Table {
  std::vector<TableColumn> columns{};
  std::vector<std::vector<TableCell>> rows{};  // shorter ones end in empty cells
};

// Throws std::invalid_argument when a row has more cells than the table has columns, or digits are out of
// range. Everything that writes a table calls it.
void check_table(const Table& table);

// A number rounded for reading to `digits` significant digits: plain from 0.0001 to 9999999 (whole digits are
// never rounded away), else with an exponent; "-" for NaN, "inf", "-inf".
std::string readable_number(double number, int digits);

// The digits of a whole number, with its sign.
std::string whole_number(const TableCell& cell);

// A cell for reading: readable_number for numbers, whole numbers in full, nothing for empty cells.
std::string readable_cell(const TableCell& cell, int digits);

// Whether a column (of a table that check_table accepts) has no text: its entries are aligned right.
bool is_numeric_column(const Table& table, std::size_t column);

// The table for a terminal: one line of names, then one line per row, each ending in a newline; columns two
// spaces apart and as wide as their widest entry, counted in code points. Numeric columns and their names are
// aligned right, columns with any text left. Control characters inside entries become spaces. No trailing
// spaces; "" for a table without columns. Throws what check_table throws.
std::string text_table(const Table& table);

// CSV (RFC 4180 with plain newlines): the header, then one line per row. Numbers are the shortest decimals
// that read back to the same double (nan, inf, -inf for the others); empty cells are empty; text is quoted
// where it is empty or holds a comma, a quote, a line break or spaces at its ends, and is not checked to be
// UTF-8. Throws what check_table throws.
std::string csv_text(const Table& table);

// Appends a JSON array of one object per row, with the names of the columns as keys; empty cells and numbers
// that are not finite are null. Throws what check_table throws.
void write_table(JsonWriter& json, const Table& table);

}  // namespace meander
