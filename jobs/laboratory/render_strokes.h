// meander render strokes: models painted in strokes.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

JobFunction add_strokes(Command& render);

}  // namespace meander
