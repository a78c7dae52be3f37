// Parallel loops whose result does not depend on the number of threads, isolated from the flow graph around
// them.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <new>
#include <span>
#include <vector>

#include "kernels/core/tsan_annotations.h"

namespace meander {

// Loops over fewer elements run in the calling thread: a task costs about as much as 10^3 cheap elements.
inline constexpr std::size_t parallel_threshold = 16384;
// Sums are cut into blocks of this size whatever the thread count, so that floating-point sums have one
// order.
inline constexpr std::size_t sum_block = 4096;

// Throws std::bad_alloc where too little memory or address space is left for oneTBB to start in. Call it
// before the first arena: oneTBB 2022.1 holds the lock of its settings while it allocates its first objects,
// and takes the same lock to throw where that fails, so that it would deadlock.
inline void require_task_memory() {
  constexpr std::size_t bytes = std::size_t{16} << 20;
  ::operator delete(::operator new(bytes));
}

// Calls body(i) for i in [0, count), each call a task of its own: for few, unequal, independent pieces of
// work (the components of a model). Isolated: a thread that waits here never starts an outer task (it could
// re-enter the node body it is in). Exceptions of body are rethrown.
template <class Body>
void parallel_tasks(std::size_t count, const Body& body) {
  if (count < 2) {
    if (count == 1) body(std::size_t{0});
    return;
  }
  const TsanLoop loop;
  oneapi::tbb::task_group_context unbound(oneapi::tbb::task_group_context::isolated);
  oneapi::tbb::this_task_arena::isolate([&] {
    oneapi::tbb::parallel_for(
        std::size_t{0}, count,
        [&](std::size_t i) MEANDER_CALLED_BY_TBB {
          const TsanLoop::Task task(loop);
          body(i);
        },
        unbound);
  });
}

// Calls body(begin, end) over [0, count) in blocks of at most `block` elements. Blocks are the same for every
// thread count; body must not touch another block's output. Isolated: a thread that waits here never starts
// an outer task (it could re-enter the node body it is in). Exceptions of body are rethrown.
template <class Body>
void parallel_blocks(std::size_t count, std::size_t block, const Body& body) {
  if (count == 0) return;
  const std::size_t blocks = (count + block - 1) / block;
  if (blocks == 1 || count < parallel_threshold) {
    for (std::size_t b = 0; b < blocks; ++b) body(b * block, std::min(count, (b + 1) * block));
    return;
  }
  parallel_tasks(blocks, [&](std::size_t b) { body(b * block, std::min(count, (b + 1) * block)); });
}

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

// Calls both functions, which must not depend on each other; one after the other where they work on few
// elements. `first` should be the longer one: the calling thread runs it, and only other threads can help
// with its loops.
template <class First, class Second>
void parallel_both(std::size_t elements, const First& first, const Second& second) {
  if (elements < parallel_threshold) {
    first();
    second();
    return;
  }
  parallel_tasks(2, [&](std::size_t task) { task == 0 ? first() : second(); });
}

// The number of ranges to divide work into that costs something for each range, whatever its size: one for
// each thread up to `max_ranges`, and one in all where there are fewer than `many` elements.
inline std::size_t ranges_for_threads(std::size_t elements, std::size_t many, std::size_t max_ranges) {
  if (elements < many) return 1;
  return std::clamp<std::size_t>(static_cast<std::size_t>(oneapi::tbb::this_task_arena::max_concurrency()), 1,
                                 max_ranges);
}

// Sums in fixed blocks with double accumulators: bit-identical for every thread count. O(n).
inline double blocked_sum(std::span<const double> values) {
  std::vector<double> partial((values.size() + sum_block - 1) / sum_block, 0.0);
  parallel_blocks(values.size(), sum_block, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += values[i];
    partial[begin / sum_block] = sum;
  });
  double total = 0.0;
  for (const double p : partial) total += p;
  return total;
}

}  // namespace meander
