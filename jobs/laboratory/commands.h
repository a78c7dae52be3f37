// The subcommands of the laboratory; see jobs/jobs.h.
#pragma once

#include "jobs/jobs.h"

namespace meander {

JobFunction add_measure_job(CLI::App& program);
JobFunction add_figures_job(CLI::App& program);

}  // namespace meander
