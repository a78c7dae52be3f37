// meander render strokes paints models in strokes.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

JobFunction add_strokes(Command& render);

}  // namespace meander
