// The check of an argument.
#pragma once

#include <stdexcept>

namespace meander {

// Throws std::invalid_argument(what) unless the argument is fine.
inline void require(bool fine, const char* what) {
  if (!fine) throw std::invalid_argument(what);
}

}  // namespace meander
