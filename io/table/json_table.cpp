#include "io/table/json_table.h"

#include <cstddef>
#include <cstdint>
#include <limits>

namespace meander {

namespace {

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
  json.value(std::numeric_limits<double>::quiet_NaN());  // written as null
}

}  // namespace

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
