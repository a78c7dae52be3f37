// Independent pieces of work of which only a few may hold their memory at once.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "kernels/core/parallel.h"

namespace meander {

// Calls body(i) for i in [0, count), at most `lanes` >= 1 calls at a time whatever the number of threads: for
// pieces whose scratch would otherwise grow with it. Isolated like parallel_blocks. Exceptions of body are
// rethrown; no further call begins after one.
template <class Body>
void parallel_lanes(std::size_t count, std::size_t lanes, const Body& body) {
  std::atomic<std::size_t> next{0};
  parallel_tasks(std::min(count, lanes), [&](std::size_t) {
    try {
      for (std::size_t i; (i = next.fetch_add(1)) < count;) body(i);
    } catch (...) {
      next = count;
      throw;
    }
  });
}

}  // namespace meander
