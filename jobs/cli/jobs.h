// The subcommands. Each function adds one to the parser and returns the function that runs it, whose result
// is the exit code.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/sampling_graph.h"

namespace meander {

class Command;

using JobFunction = std::function<int()>;

class Laboratory;  // jobs/rows/laboratory.h; a null pointer in a program without it

// Changes the stages before a run: the laboratory adds its own by it, and tests inject failures into a real
// process.
using StageHook = std::function<void(GraphStages&)>;

JobFunction add_run_job(Command& program, const Laboratory* laboratory, StageHook hook = {});
JobFunction add_plan_job(Command& program, const Laboratory* laboratory, std::vector<std::string> arguments);
JobFunction add_status_job(Command& program);
JobFunction add_merge_job(Command& program, const Laboratory* laboratory);
JobFunction add_verify_job(Command& program);
JobFunction add_info_job(Command& program);
JobFunction add_export_job(Command& program);
JobFunction add_surface_job(Command& program);
JobFunction add_retrieve_job(Command& program, const Laboratory* laboratory);
JobFunction add_describe_job(Command& program);
JobFunction add_remesh_job(Command& program, StageHook hook = {});
JobFunction add_help_job(Command& program);
// The help does not show this one: the build calls it.
JobFunction add_pages_job(Command& program);

// A command with the function that runs it.
struct Job {
  const char* name;
  JobFunction run;
};

// Adds the commands: the one that the first argument names, or all where it names none or describes them
// (`help`, `pages`), since adding the options of all takes some milliseconds. The hook and the arguments must
// outlive the program.
std::vector<Job> add_jobs(Command& program, const Laboratory* laboratory, const StageHook& hook,
                          const std::vector<std::string>& arguments);

// The whole program: parses the arguments, runs the job and explains errors. Returns the exit code.
int run_program(int argc, char** argv, const Laboratory* laboratory, StageHook hook = {});

}  // namespace meander
