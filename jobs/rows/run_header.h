// The header of the store that a run makes.
#pragma once

#include "io/store/store.h"
#include "jobs/inputs/inputs.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/run_options.h"

namespace meander {

StoreHeader run_header(const RunOptions& options, const Inputs& inputs, const Laboratory* laboratory);

}  // namespace meander
