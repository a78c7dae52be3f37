// Tables as CSV (RFC 4180 with plain newlines).
#pragma once

#include <string>

#include "io/table/table.h"

namespace meander {

// The header, then one line per row. Numbers as shortest decimals that read back to the same double (nan,
// inf, -inf for the others), empty cells as nothing, text in double quotes when it holds a comma, a quote, a
// line break or spaces at its ends, or is empty; texts that are not UTF-8 are passed on as they are. Throws
// what check_table throws.
std::string csv_text(const Table& table);

}  // namespace meander
