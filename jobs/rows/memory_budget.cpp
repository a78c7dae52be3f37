#include "jobs/rows/memory_budget.h"

#include <fmt/format.h>

#include "jobs/cli/usage_error.h"
#include "pipeline/memory_estimate.h"

namespace meander {

std::uint64_t memory_for_models(std::uint64_t budget, const StoreHeader& header,
                                const SampleParameters& parameters, int threads, std::uint64_t index_bytes) {
  constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20;
  constexpr MeshEstimate small{64 * 1024, 1000, 2000};
  const auto taken = [&](std::uint64_t bytes, const SampleParameters& sample) {
    return process_bytes(bytes, header, threads) + index_bytes + estimate_bytes(small, sample, threads);
  };
  const auto least = [&](const SampleParameters& sample) {
    std::uint64_t bytes = budget;
    while (bytes < taken(bytes, sample)) bytes = (taken(bytes, sample) + mebibyte - 1) / mebibyte * mebibyte;
    return bytes;
  };
  if (budget < taken(budget, parameters)) {
    std::string message = fmt::format(
        "--memory: {} MiB are less than meander itself needs beside a small model, with {} threads and {} "
        "samples a model; give at least {}M",
        budget / mebibyte, threads, header.samples, least(parameters) / mebibyte);
    if (parameters.sequence == SequenceKind::spaced) {
      SampleParameters other = parameters;
      other.sequence = SequenceKind::shifted;
      message += fmt::format(", or {}M with --sequence shifted", least(other) / mebibyte);
    }
    throw UsageError(message);
  }
  return budget - process_bytes(budget, header, threads) - index_bytes;
}

}  // namespace meander
