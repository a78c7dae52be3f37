// Loops on a given number of threads, whatever the machine has.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <cstddef>

namespace meander::test {

// Calls body() in an arena of that many threads (1 or more) and returns what it returns. A limit alone would
// leave fewer threads on a machine of fewer cores. A limit of the caller that is stricter stays in force.
template <class Body>
auto on_threads(std::size_t threads, const Body& body) {
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
  oneapi::tbb::task_arena arena(static_cast<int>(threads));
  return arena.execute(body);
}

}  // namespace meander::test
