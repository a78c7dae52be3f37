// Tables as JSON.
#pragma once

#include "io/json_writer.h"
#include "io/table/table.h"

namespace meander {

// Appends an array of one object per row, with the columns' names as keys; empty cells and numbers that are
// not finite are null. Throws what check_table throws.
void write_table(JsonWriter& json, const Table& table);

}  // namespace meander
