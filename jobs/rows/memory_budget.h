// What --memory leaves for models.
#pragma once

#include <cstdint>

#include "io/store/store.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

// --memory is the budget of the whole process: models get what process_bytes does not take.
// `index_bytes` are those of the archives among the inputs. Throws UsageError, with the least value that will
// do, where that is not enough for a small model.
std::uint64_t memory_for_models(std::uint64_t budget, const StoreHeader& header,
                                const SampleParameters& parameters, int threads, std::uint64_t index_bytes);

}  // namespace meander
