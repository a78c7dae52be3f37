#include "io/table/text_table.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "io/utf8.h"

namespace meander {

namespace {

// Fit for one line of a terminal.
std::string on_one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return text;
}

// Code points; a byte that is no UTF-8 counts as one.
std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  for (; !text.empty(); ++width) text.remove_prefix(std::max<std::size_t>(1, utf8_sequence_length(text)));
  return width;
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

}  // namespace meander
