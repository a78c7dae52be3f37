#include "io/table/csv_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace meander {

namespace {

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

}  // namespace

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

}  // namespace meander
