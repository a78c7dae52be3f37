// meander render turntable draws frames of a turning model, each with the samples chosen for its view.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

JobFunction add_turntable(Command& render);

}  // namespace meander
