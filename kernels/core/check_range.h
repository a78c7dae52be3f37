// A sentence for a parameter that is out of its range.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace meander {

// Adds "NAME is VALUE, must be MIN to MAX" to the problems unless min <= value <= max (NaN never is).
inline void check_range(std::vector<std::string>& problems, const char* name, double value, double min,
                        double max) {
  if (value >= min && value <= max) return;
  char numbers[96];
  std::snprintf(numbers, sizeof numbers, " is %.10g, must be %.10g to %.10g", value, min, max);
  problems.push_back(name + std::string(numbers));
}

}  // namespace meander
