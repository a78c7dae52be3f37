// meander render section draws the signed distance from surfaces on planes through them.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

JobFunction add_section(Command& render);

}  // namespace meander
