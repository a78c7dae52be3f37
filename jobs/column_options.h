// The options that choose the columns of samples: --attribute, --texcoord and --store.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/store/store.h"
#include "jobs/command_line.h"

namespace meander {

// Adds --store for rows of this kind.
void add_store_columns_option(Command command, RowKind rows, std::vector<std::string>& stored);

// NAME, NAME:WIDTH, and either with `:class` or `:linear` behind it, of each text; ascending by name. Adds to
// `problems` what is wrong.
std::vector<AttributeColumn> parse_attributes(const std::vector<std::string>& texts,
                                              std::vector<std::string>& problems);
// The same as one text: what --attribute takes, its commas included.
std::string text_of(const std::vector<AttributeColumn>& attributes);

// StoreColumns::left_out from the words of --store, none of which means all columns. Columns that have
// options of their own (`rgb`, `texcoord`, `attributes`) are stored whenever they are asked for, and may be
// named then.
std::uint32_t parse_left_out(const std::vector<std::string>& words, const StoreColumns& columns,
                             std::vector<std::string>& problems);
// The words for such columns, in their order, with `points` first: what --store takes.
std::string stored_words(const StoreColumns& columns);

}  // namespace meander
