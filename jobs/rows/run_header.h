// The inputs of a run, and the header of the store that it makes.
#pragma once

#include "io/store/store.h"
#include "jobs/inputs/inputs.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/run_options.h"

namespace meander {

// The inputs of a run: collected, with their files of tensors; unread folders are named on standard error.
// Throws UsageError when there is no mesh file.
Inputs collect_run_inputs(const RunOptions& options);

StoreHeader run_header(const RunOptions& options, const Inputs& inputs, const Laboratory* laboratory);

}  // namespace meander
