#include "pipeline/statistics.h"

namespace meander {

NodeTimer::~NodeTimer() {
  const auto busy = std::chrono::steady_clock::now() - start_;
  node_.items.fetch_add(1, std::memory_order_relaxed);
  node_.busy_nanoseconds.fetch_add(
      static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(busy).count()),
      std::memory_order_relaxed);
}

}  // namespace meander
