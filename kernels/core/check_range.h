// A sentence for a parameter that is out of its range.
#pragma once

#include <string>
#include <vector>

namespace meander {

// Adds "NAME is VALUE, must be MIN to MAX" to the problems unless min <= value <= max (NaN never is).
void check_range(std::vector<std::string>& problems, const char* name, double value, double min, double max);

}  // namespace meander
