// What `meander describe` says at its end.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "kernels/core/failure.h"
#include "kernels/describe/describe_samples.h"

namespace meander {

struct DescribeSummary {
  std::string store;
  std::span<const std::string> ids;
  std::span<const Descriptor> descriptors;
  const std::map<std::uint64_t, Failure>& problems;  // by row
  std::uint64_t not_ok = 0;                          // rows without samples
  double seconds = 0;
};

// On standard output, as text or as one JSON object.
void print_describe_summary(const DescribeSummary& summary, bool as_json);

}  // namespace meander
