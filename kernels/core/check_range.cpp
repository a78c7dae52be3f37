#include "kernels/core/check_range.h"

#include <cstdio>

namespace meander {

void check_range(std::vector<std::string>& problems, const char* name, double value, double min, double max) {
  if (value >= min && value <= max) return;
  char numbers[96];
  std::snprintf(numbers, sizeof numbers, " is %.10g, must be %.10g to %.10g", value, min, max);
  problems.push_back(name + std::string(numbers));
}

}  // namespace meander
