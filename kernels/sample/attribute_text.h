// Columns of attributes as texts: "NAME", "NAME:3", "NAME:class", "NAME:2:linear", with commas between them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kernels/data/samples.h"

namespace meander {

// Ascending by name, which may be any text. Returns what is wrong with the text, or "".
std::string take_attributes(std::string_view text, std::vector<AttributeColumn>& columns);
// The text that gives these.
std::string attributes_text(const std::vector<AttributeColumn>& columns);

}  // namespace meander
