// Functions of the product over arrays, which the C interface calls by name.
#pragma once

#include <optional>
#include <string_view>

#include "jobs/python/laboratory_call.h"

namespace meander {

// Calls the function of that name; none where there is none. Throws what the function throws.
std::optional<LaboratoryResult> call_array_function(std::string_view name, const LaboratoryArguments& given);

}  // namespace meander
