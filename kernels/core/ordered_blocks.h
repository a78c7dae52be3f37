// Parallel blocks that throw the first error in the order of the blocks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <vector>

#include "kernels/core/parallel.h"

namespace meander {

// Calls body(begin, end) over [0, count) in blocks of at most `block` elements, each a task: for elements of
// a microsecond and more. When several blocks throw, the exception of the first block comes out, so that even
// the sentence of an error does not depend on the threads.
template <class Body>
void ordered_blocks(std::size_t count, std::size_t block, const Body& body) {
  const std::size_t blocks = (count + block - 1) / block;
  std::vector<std::exception_ptr> errors(blocks);
  parallel_tasks(blocks, [&](std::size_t b) {
    try {
      body(b * block, std::min(count, (b + 1) * block));
    } catch (...) {
      errors[b] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace meander
