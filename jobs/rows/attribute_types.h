// Which columns of a run hold classes, and what attributes its models have.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/store/store_columns.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// Whether the headers of models are needed for it: an attribute that was named without its kind.
bool has_open_kinds(std::span<const AttributeColumn> columns);

// Gives plain columns the kind that the columns of the same name and width have in `known` (a store, or a
// run, that is to be continued); of the others classes to those that are integers in the first model by id
// that has the attribute, of the first 64 models; where none of them has it, numbered_attributes are classes.
// Does not depend on threads or the order of the inputs.
void choose_kinds(std::vector<AttributeColumn>& columns, const StoreColumns* known,
                  std::span<const PlanItem> items);

// The names of attributes of the first 64 models by id, as --attribute takes them, the nearest to `name` in
// spelling first; at most 5.
std::vector<std::string> near_attributes(const std::string& name, std::span<const PlanItem> items);

}  // namespace meander
