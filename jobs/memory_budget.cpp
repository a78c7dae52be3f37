#include "jobs/memory_budget.h"

#include <fmt/format.h>

#include "jobs/inputs.h"
#include "pipeline/memory_estimate.h"

namespace meander {

std::uint64_t memory_for_models(std::uint64_t budget, const StoreHeader& header,
                                const SampleParameters& parameters, int threads, std::uint64_t index_bytes) {
  constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20;
  constexpr MeshEstimate small{64 * 1024, 1000, 2000};
  const std::uint64_t needed = estimate_bytes(small, parameters, threads);
  const auto taken = [&](std::uint64_t bytes) {
    return process_bytes(bytes, header, threads) + index_bytes + needed;
  };
  if (budget < taken(budget)) {
    std::uint64_t least = budget;
    while (least < taken(least)) least = (taken(least) + mebibyte - 1) / mebibyte * mebibyte;
    throw UsageError(
        fmt::format("--memory: {} MiB are less than meander itself needs beside a small model, with {} "
                    "threads and {} samples a "
                    "model; give at least {}M",
                    budget / mebibyte, threads, header.samples, least / mebibyte));
  }
  return budget - process_bytes(budget, header, threads) - index_bytes;
}

}  // namespace meander
