// The subcommands of the laboratory; see jobs/cli/jobs.h.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

JobFunction add_measure_job(Command& program);
JobFunction add_figures_job(Command& program);
JobFunction add_render_job(Command& program);

}  // namespace meander
