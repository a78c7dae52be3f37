#pragma once

#include <stdexcept>

namespace meander {

// A mistake in the arguments; the job ends with exit_usage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace meander
