#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <functional>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "io/digest.h"
#include "io/file/folder_lock.h"
#include "jobs/cli/command_help.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/terminal.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/working_process.h"
#include "jobs/inputs/run_report.h"
#include "jobs/rows/laboratory.h"
#include "kernels/core/instruction_set.h"
#include "kernels/core/status.h"
#include "meander_version.h"

namespace meander {

namespace {

constexpr const char* footer =
    "Exit codes:\n"
    "  0 everything was done\n"
    "  1 internal error\n"
    "  2 wrong options, or the command cannot start\n"
    "  3 finished, but some items failed, or no model has an attribute that was asked for\n"
    "  75 stopped early; the same command continues";

int say(int status, const std::string& text) {
  fmt::print(stderr, "meander: {}\n", text);
  return status;
}

// Writes the output that is still buffered; a failure becomes the exit code.
int end_output(int status) {
  const std::string problem = flush_standard_output();
  return problem.empty() ? status : say(exit_usage, problem);
}

// A command of the laboratory in a program without it: hidden, and refused whatever its arguments are.
JobFunction add_missing_command(Command& program, const char* name) {
  program.add_hidden_subcommand(name);
  return [name]() -> int {
    require_laboratory(nullptr, name);
    return exit_usage;
  };
}

std::string version_text() {
  return fmt::format("meander {}\nBuilt by {}\nInstruction set: {}", meander_version, build_text(),
                     name_of(best_instruction_set()));
}

struct Subcommand {
  const char* name;
  std::function<JobFunction()> add;
};

std::vector<Subcommand> all_subcommands(Command& program, const Laboratory* laboratory, const StageHook& hook,
                                        const std::vector<std::string>& arguments) {
  const auto in_laboratory = [&program, laboratory](const char* name,
                                                    JobFunction (Laboratory::*add)(Command&) const) {
    return Subcommand{name, [&program, laboratory, name, add]() -> JobFunction {
                        return laboratory ? (laboratory->*add)(program) : add_missing_command(program, name);
                      }};
  };
  return {{"run", [&, laboratory] { return add_run_job(program, laboratory, hook); }},
          {"plan", [&, laboratory] { return add_plan_job(program, laboratory, arguments); }},
          {"status", [&] { return add_status_job(program); }},
          {"merge", [&, laboratory] { return add_merge_job(program, laboratory); }},
          {"verify", [&] { return add_verify_job(program); }},
          {"info", [&] { return add_info_job(program); }},
          {"export", [&] { return add_export_job(program); }},
          {"surface", [&] { return add_surface_job(program); }},
          in_laboratory("measure", &Laboratory::add_measure_job),
          in_laboratory("figures", &Laboratory::add_figures_job),
          in_laboratory("render", &Laboratory::add_render_job),
          {"retrieve", [&, laboratory] { return add_retrieve_job(program, laboratory); }},
          {"describe", [&] { return add_describe_job(program); }},
          {"remesh", [&] { return add_remesh_job(program, hook); }},
          {"help", [&] { return add_help_job(program); }},
          {"pages", [&] { return add_pages_job(program); }}};
}

// What a command line without arguments shows.
std::string first_steps(const Command& program) {
  return fmt::format(
      "meander: a command is missing. To begin with:\n\n{}\n`meander help` lists all commands.\n",
      example_text(program.description(), terminal_width(STDERR_FILENO)));
}

}  // namespace

std::vector<Job> add_jobs(Command& program, const Laboratory* laboratory, const StageHook& hook,
                          const std::vector<std::string>& arguments) {
  const std::vector<Subcommand> subcommands = all_subcommands(program, laboratory, hook, arguments);
  const std::string first = arguments.empty() ? "" : arguments.front();
  std::vector<Job> jobs;
  const auto named = std::find_if(subcommands.begin(), subcommands.end(),
                                  [&](const Subcommand& subcommand) { return subcommand.name == first; });
  const bool one = named != subcommands.end() && first != "help" && first != "pages";
  for (const Subcommand& subcommand : subcommands)
    if (!one || &subcommand == &*named) jobs.push_back({subcommand.name, subcommand.add()});
  program.example("meander run models/ -o store.h5 -n 2048",
                  "Sample every mesh of a folder, or a single mesh file, into one store");
  program.example("meander export store.h5 --html page.html",
                  "Look at the samples: a page to turn the models in");
  program.example("meander help run", "The options of a command, after two examples");
  return jobs;
}

int run_program(int argc, char** argv, const Laboratory* laboratory, StageHook hook) {
  prepare_standard_streams();
  leave_out_openssl_configuration();
  remove_temporaries_on_signals();
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on file sizes is reported like a full disk
  CommandLine line("meander", "Low-discrepancy sampling of whole collections of surfaces", version_text(),
                   footer);
  Command program = line.program();
  program.require_subcommand();
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::vector<Job> jobs = add_jobs(program, laboratory, hook, arguments);
  if (arguments.empty()) {
    fmt::print(stderr, "{}", first_steps(program));
    return exit_usage;
  }
  const bool begins_anew = std::find(arguments.begin(), arguments.end(), "--fresh") != arguments.end();
  std::string chosen;
  try {
    if (!line.parse(argc, argv)) return end_output(exit_done);
    for (const Job& job : jobs)
      if (program.chose(job.name)) {
        chosen = job.name;
        return end_output(job.run());
      }
  } catch (const UsageError& error) {
    return say(exit_usage, error.what());
  } catch (const FolderHeld& error) {
    return say(exit_stopped, fmt::format("{}; repeat the command when that one has ended", error.what()));
  } catch (const RunError& error) {
    if (error.kind() != RunError::Kind::stopped) return say(exit_usage, error.what());
    return say(exit_stopped, fmt::format("{}; the same command{} continues", error.what(),
                                         begins_anew ? " without --fresh" : ""));
  } catch (const ItemError& error) {  // a file of a job without rows that could hold its status
    if (error.status() != Status::internal)
      return say(exit_usage, fmt::format("{}: {}", name_of(error.status()), error.what()));
    return say(exit_internal,
               fmt::format("internal error (a bug of meander, please report it): {}", error.what()));
  } catch (const std::bad_alloc&) {
    const bool resumable = chosen == "run" || chosen == "merge" || chosen == "describe" || chosen == "remesh";
    return say(resumable ? exit_stopped : exit_usage,
               resumable
                   ? "out of memory: finished rows are kept; repeat the command when more memory is free"
                   : "out of memory");
  } catch (const std::system_error& error) {  // a file or folder cannot be made or written
    return say(exit_usage, error.what());
  } catch (const std::exception& error) {
    return say(exit_internal,
               fmt::format("internal error (a bug of meander, please report it): {}", error.what()));
  }
  return say(exit_internal, "internal error: no job ran");
}

}  // namespace meander
