#include "kernels/core/large_vector.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>

#include "kernels/core/parallel.h"

namespace meander {

void fetch_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_POPULATE_WRITE
  // Smaller blocks may be memory that was written before, where there is little to gain.
  constexpr std::size_t page = 4096, min_bytes = std::size_t{8} << 20, piece = std::size_t{8} << 20;
  if (bytes < min_bytes) return;
  // Only whole pages inside the block are fetched.
  auto* const first = static_cast<std::byte*>(memory);
  const std::size_t before = (page - reinterpret_cast<std::uintptr_t>(first) % page) % page,
                    whole = (bytes - before) / page * page;
  parallel_tasks((whole + piece - 1) / piece, [&](std::size_t i) {
    // An older kernel refuses, which does no harm.
    ::madvise(first + before + i * piece, std::min(piece, whole - i * piece), MADV_POPULATE_WRITE);
  });
#endif
}

}  // namespace meander
