// What `meander describe` says at its end.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "jobs/describe/describe_stages.h"
#include "kernels/core/failure.h"
#include "kernels/describe/describe_samples.h"

namespace meander {

// Why rows could not be described completely: the first reason of each, with the status ok where nothing
// failed but a descriptor does not exist for the model. add and of may be called from many
// threads.
class RowProblems {
 public:
  void add(std::uint64_t row, Failure problem);
  std::optional<Failure> of(std::uint64_t row) const;
  // Once no thread adds any more.
  const std::map<std::uint64_t, Failure>& all() const { return by_row_; }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint64_t, Failure> by_row_;
};

struct DescribeSummary {
  std::string store;
  std::span<const std::string> ids;
  std::span<const Descriptor> descriptors;
  const std::map<std::uint64_t, Failure>& problems;  // by row
  std::uint64_t not_ok = 0;                          // rows without samples
  double seconds = 0;
};

// Adds the rows that an earlier start of the job ended without their descriptors: those of `rows` (ascending)
// that are not described.
void add_earlier_problems(const StoreReader& store, const Describer& describer,
                          std::span<const std::uint64_t> rows, RowProblems& problems);

// On standard output, as text or as one JSON object.
void print_describe_summary(const DescribeSummary& summary, bool as_json);

}  // namespace meander
