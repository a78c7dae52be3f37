// meander retrieve select: every setting scored, and the choice among them judged on classes left out.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

// Adds `select` to the parser of `retrieve`; the returned function runs it.
JobFunction add_select_command(Command& retrieve);

}  // namespace meander
