// meander retrieve query: the models of a store that are most similar to its own, or to any mesh.
#pragma once

#include "jobs/cli/jobs.h"

namespace meander {

// Adds `query` to the parser of `retrieve`; the returned function runs it.
JobFunction add_query_command(Command& retrieve, const Laboratory* laboratory);

}  // namespace meander
