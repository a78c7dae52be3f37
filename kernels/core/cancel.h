// Cooperative deadline and cancellation, checked between stages and inside long loops.
#pragma once

#include <atomic>
#include <chrono>

#include "kernels/core/status.h"

namespace meander {

struct CancelToken {
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  const std::atomic<bool>* cancelled = nullptr;  // set by the owner of the run; may be null

  // Throws RunCancelled when the run stops, and ItemError(timeout) once the deadline has passed. Cost: one
  // clock read.
  void check() const {
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) throw RunCancelled();
    if (deadline != std::chrono::steady_clock::time_point::max() &&
        std::chrono::steady_clock::now() > deadline)
      throw ItemError(Status::timeout, "the time limit per model passed");
  }
};

}  // namespace meander
