#include "io/table/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace meander {

void check_table(const Table& table) {
  for (const TableColumn& column : table.columns)
    if (column.digits < 1 || column.digits > 17)
      throw std::invalid_argument(
          fmt::format("column {}: {} digits, not 1 to 17", column.name, column.digits));
  for (const auto& row : table.rows)
    if (row.size() > table.columns.size())
      throw std::invalid_argument(
          fmt::format("a row of {} cells in a table of {} columns", row.size(), table.columns.size()));
}

std::string readable_number(double number, int digits) {
  if (std::isnan(number)) return "-";
  if (std::isinf(number)) return number > 0 ? "inf" : "-inf";
  if (number == 0) return "0";
  const std::string scientific = fmt::format("{:.{}e}", number, digits - 1);
  // Of the rounded number: 9.9996 with four digits has the exponent of 10.
  const int exponent = std::stoi(scientific.substr(scientific.find('e') + 1));
  if (exponent < -4 || exponent > 6) return scientific;
  return fmt::format("{:.{}f}", number, std::max(0, digits - 1 - exponent));
}

std::string whole_number(const TableCell& cell) {
  return (cell.negative ? "-" : "") + std::to_string(cell.magnitude);
}

std::string readable_cell(const TableCell& cell, int digits) {
  switch (cell.kind) {
    case CellKind::number:
      return readable_number(cell.number, digits);
    case CellKind::whole:
      return whole_number(cell);
    case CellKind::text:
      return cell.text;
    case CellKind::empty:
      break;
  }
  return {};
}

bool is_numeric_column(const Table& table, std::size_t column) {
  return std::ranges::none_of(table.rows, [&](const std::vector<TableCell>& row) {
    return column < row.size() && row[column].kind == CellKind::text;
  });
}

}  // namespace meander
