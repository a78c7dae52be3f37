// Columns of an item as members of JSON.
#pragma once

#include <functional>

#include "io/json_writer.h"
#include "kernels/data/columns.h"

namespace meander {

// Adds the member of a column of the report: numbers, words and texts as such, digests in hexadecimal, lists
// of numbers as arrays, counts by name as an object of those above 0. `real` writes a real number.
void write_item(JsonWriter& json, const ItemColumn& column, const ItemReport& report,
                const std::function<void(double)>& real);

}  // namespace meander
