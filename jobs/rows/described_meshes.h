// The mesh files behind the rows of a store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "jobs/inputs/input_options.h"
#include "pipeline/sampling_graph.h"

namespace meander {

class DescribedMeshes {
 public:
  DescribedMeshes() = default;
  // Collects the inputs and finds the rows of their ids in `store`; standard error names folders that could
  // not be read. Throws UsageError when no row is found.
  DescribedMeshes(const std::string& store, const std::vector<std::string>& ids,
                  const std::vector<std::string>& inputs, InputOptions collect);

  // Gives `item` the file of its row; false where the inputs have none.
  bool add_file(PlanItem& item) const;
  // Its length in bytes; 0 where it is unknown.
  std::uint64_t bytes(std::uint64_t row) const;
  // All files that the arguments name or contain.
  std::span<const std::filesystem::path> files_read() const { return read_; }
  // The memory of the access points of archives.
  std::uint64_t index_bytes() const { return index_bytes_; }

 private:
  const PlanItem* find(std::uint64_t row) const;

  std::map<std::uint64_t, PlanItem> files_;  // by row
  std::vector<std::filesystem::path> read_;
  std::uint64_t index_bytes_ = 0;
};

// Sets the reservation of every item from a peek at the header of its file, but at most `most_bytes`. In
// parallel. A file that cannot be read says so when it is read.
void reserve_described(std::span<PlanItem> plan, const SampleParameters& parameters, int threads,
                       std::uint64_t most_bytes);

}  // namespace meander
