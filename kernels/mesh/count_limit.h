// Vertices, polygons, triangles and their corners are numbered by 32 bits; no_index is the one number that is
// none.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "kernels/core/status.h"
#include "kernels/mesh/polygon_mesh.h"

namespace meander {

// To be asked before a count becomes a 32-bit number and before memory is taken for it: throws
// ItemError(unsupported_format) for more than 2^32 - 2.
inline void check_count(std::uint64_t count, std::string_view of_what) {
  if (count >= no_index) [[unlikely]]
    throw ItemError(Status::unsupported_format,
                    std::to_string(count) + " " + std::string(of_what) + " are more than 32 bits can number");
}

}  // namespace meander
