#include "io/table/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "io/utf8.h"

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
  // The exponent of the rounded number: 9.9996 with four digits has that of 10.
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

namespace {

std::string on_one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return text;
}

// In code points; a byte that is not UTF-8 counts as one.
std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  for (; !text.empty(); ++width) text.remove_prefix(std::max<std::size_t>(1, utf8_sequence_length(text)));
  return width;
}

void append_text(std::string& out, std::string_view text) {
  const bool plain = !text.empty() && text.find_first_of(",\"\r\n") == std::string_view::npos &&
                     text.front() != ' ' && text.back() != ' ';
  if (plain) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

void append_cell(std::string& out, const TableCell& cell) {
  if (cell.kind == CellKind::text) append_text(out, cell.text);
  if (cell.kind == CellKind::whole) out += whole_number(cell);
  if (cell.kind != CellKind::number) return;
  if (std::isnan(cell.number)) {
    out += "nan";  // never "-nan"
    return;
  }
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), cell.number).ptr;
  out.append(digits.data(), end);
}

void write_cell(JsonWriter& json, const TableCell& cell) {
  switch (cell.kind) {
    case CellKind::number:
      return json.value(cell.number);
    case CellKind::whole:
      if (!cell.negative) return json.value(cell.magnitude);
      return json.value(static_cast<std::int64_t>(std::uint64_t{0} - cell.magnitude));
    case CellKind::text:
      return json.value(cell.text);
    case CellKind::empty:
      break;
  }
  json.null();
}

}  // namespace

std::string text_table(const Table& table) {
  check_table(table);
  const std::size_t columns = table.columns.size();
  if (columns == 0) return {};
  std::vector<std::vector<std::string>> lines(1 + table.rows.size(), std::vector<std::string>(columns));
  std::vector<std::size_t> widths(columns, 0);
  for (std::size_t c = 0; c < columns; ++c) {
    lines[0][c] = on_one_line(table.columns[c].name);
    for (std::size_t r = 0; r < table.rows.size(); ++r)
      if (c < table.rows[r].size())
        lines[r + 1][c] = on_one_line(readable_cell(table.rows[r][c], table.columns[c].digits));
    for (const auto& line : lines) widths[c] = std::max(widths[c], display_width(line[c]));
  }
  std::string out;
  for (const auto& line : lines) {
    std::string row;
    for (std::size_t c = 0; c < columns; ++c) {
      const std::string padding(widths[c] - display_width(line[c]), ' ');
      if (c > 0) row += "  ";
      row += is_numeric_column(table, c) ? padding + line[c] : line[c] + padding;
    }
    row.erase(row.find_last_not_of(' ') + 1);
    out += row + "\n";
  }
  return out;
}

std::string csv_text(const Table& table) {
  check_table(table);
  if (table.columns.empty()) return {};
  std::string out;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    if (c > 0) out += ',';
    append_text(out, table.columns[c].name);
  }
  out += '\n';
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      if (c > 0) out += ',';
      if (c < row.size()) append_cell(out, row[c]);
    }
    out += '\n';
  }
  return out;
}

void write_table(JsonWriter& json, const Table& table) {
  check_table(table);
  json.begin_array();
  for (const auto& row : table.rows) {
    json.begin_object();
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      json.key(table.columns[c].name);
      write_cell(json, c < row.size() ? row[c] : TableCell());
    }
    json.end_object();
  }
  json.end_array();
}

}  // namespace meander
