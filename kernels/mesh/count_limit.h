// Bounds counts to 32 bits: vertices, polygons, triangles and their corners are numbered by 32 bits, and
// no_index is the invalid number.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "kernels/core/status.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// Throws ItemError(unsupported_format) for more than 2^32 - 2. Ask before a count becomes a 32-bit number and
// before memory is taken for it.
inline void check_count(std::uint64_t count, std::string_view of_what) {
  if (count >= no_index) [[unlikely]]
    throw ItemError(Status::unsupported_format,
                    std::to_string(count) + " " + std::string(of_what) + " are more than 32 bits can number");
}

}  // namespace meander
