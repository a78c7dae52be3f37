// Tables for terminals.
#pragma once

#include <string>

#include "io/table/table.h"

namespace meander {

// One line of names, then one line per row, each ending in a newline; columns two spaces apart and as wide as
// their widest entry, counted in code points. Columns that hold numbers are flush right with their names,
// columns with any text flush left. Line breaks and other control characters inside entries become spaces. No
// trailing spaces. A table without columns is the empty text. Throws what check_table throws.
std::string text_table(const Table& table);

}  // namespace meander
