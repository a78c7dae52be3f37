// Vectors of any other program as a descriptor of a store: --vectors and --ids.
#pragma once

#include <memory>
#include <string>

#include "io/store/store_reader.h"
#include "jobs/rows/described_rows.h"

namespace meander {

// Reads a 2-D array of numpy, float32 or float64: a row for each line of `ids`, a text with the id of a model
// in each line, or a CSV table with a column `id`; without one, for each row of the store in its order. The
// descriptor is called like the file without its extension. A vector that is not finite, and a model that the
// file does not have, count as not described. Throws UsageError, naming the file: ids that the store does not
// have or that come twice, another number of rows, an array of another kind, a name that the store has; and
// FileError.
std::shared_ptr<const SideVectors> read_foreign_vectors(const StoreReader& store, const std::string& vectors,
                                                        const std::string& ids);

// What read_foreign_vectors calls the descriptor.
std::string foreign_name(const std::string& vectors);

}  // namespace meander
