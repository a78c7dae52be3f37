// Peak memory of one model, for the admission by bytes.
#pragma once

#include <cstdint>
#include <vector>

#include "io/mesh/mesh_reader.h"
#include "io/store/store.h"
#include "kernels/model/model.h"

namespace meander {

// Upper bound of the bytes that are alive at once on the way from the file to the encoded row: those of the
// file and its columns, and the most that a stage declares (ModelStage::bytes), with `threads` >= 1 that may
// work on the one model. Measured per vertex, triangle and sample: memory_estimate_test compares every method
// with generated meshes and those of the shared collection, with 1, 2 and 16 threads.
//
// One object serves all models of a run, from any number of threads. The parameters must outlive it.
class MemoryEstimate {
 public:
  MemoryEstimate(const SampleParameters& parameters, int threads);
  std::uint64_t operator()(const MeshEstimate& mesh) const;

 private:
  const SampleParameters& parameters_;
  int threads_;
  std::vector<StageBytes> stages_;
};
// The same for a single model.
std::uint64_t estimate_bytes(const MeshEstimate& mesh, const SampleParameters& parameters, int threads);

// What the process takes beside the models in flight, of a budget for all of it: program and libraries,
// threads, the plan, rows on their way from the journals into the store, and what the allocator keeps
// of the budget.
std::uint64_t process_bytes(std::uint64_t budget, const StoreHeader& header, int threads);

}  // namespace meander
