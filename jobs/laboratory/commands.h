// The subcommands of the laboratory; see jobs/jobs.h.
#pragma once

#include "jobs/jobs.h"

namespace meander {

JobFunction add_measure_job(Command& program);
JobFunction add_figures_job(Command& program);
JobFunction add_render_job(Command& program);

}  // namespace meander
