// The options of `meander remesh`.
#pragma once

#include <string>

#include "io/mesh/mesh_reader.h"
#include "jobs/remesh/carried_values.h"
#include "jobs/rows/run_options.h"
#include "kernels/remesh/remesh_surface.h"

namespace meander {

struct RemeshOptions {
  RunOptions run;  // inputs, samples and budgets, as `run` has them; `store` is the output folder
  RunOptionTexts texts;
  MeshFormat format = MeshFormat::ply;
  RemeshParameters mesh;
};

// Adds the subcommand with its options. They refer to `options`.
Command add_remesh_command(Command& program, RemeshOptions& options);
// Throws UsageError with every problem at once.
void resolve_remesh_options(RemeshOptions& options);

// What --colors, --attribute and --texcoord ask for.
CarriedColumns carried_columns(const RemeshOptions& options);

}  // namespace meander
