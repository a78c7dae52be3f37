// The option that chooses the columns of samples: --store.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/store/store_columns.h"
#include "jobs/cli/command_line.h"

namespace meander {

// Adds --store for rows of this kind.
void add_store_columns_option(Command command, RowKind rows, std::vector<std::string>& stored);

// StoreColumns::left_out from the words of --store, none of which means all columns. Columns that have
// options of their own are stored whenever they are asked for, and may be named then.
ColumnSet parse_left_out(const std::vector<std::string>& words, const StoreColumns& columns,
                         std::vector<std::string>& problems);
// The words for such columns, in their order, with `points` first: what --store takes.
std::string stored_words(const StoreColumns& columns);

}  // namespace meander
