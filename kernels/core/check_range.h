// A sentence for a parameter that is out of its range.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace meander {

// Adds "NAME is VALUE, must be LEAST to MOST" to the problems unless least <= value <= most (NaN never is).
inline void check_range(std::vector<std::string>& problems, const char* name, double value, double least,
                        double most) {
  if (value >= least && value <= most) return;
  char numbers[96];
  std::snprintf(numbers, sizeof numbers, " is %.10g, must be %.10g to %.10g", value, least, most);
  problems.push_back(name + std::string(numbers));
}

}  // namespace meander
