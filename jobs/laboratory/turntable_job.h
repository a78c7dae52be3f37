// meander render turntable: frames of a model that turns, each with the samples that its view asks for.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

JobFunction add_turntable(Command& render);

}  // namespace meander
