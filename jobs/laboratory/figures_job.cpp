// meander figures reproduces the figures of Quinn et al. 2013, by a Python program.
#include <fmt/format.h>

#include <memory>

#include "jobs/cli/command_line.h"
#include "jobs/cli/output_guard.h"
#include "jobs/laboratory/commands.h"
#include "jobs/laboratory/python_program.h"
#include "kernels/core/joined_texts.h"

namespace meander {

namespace {

struct FiguresOptions {
  std::string folder, up, view;
  std::vector<std::string> models, points, only;
  std::uint32_t size = 0;
  std::uint64_t seed = 1;
  int threads = 0;
  bool quick = false;
};

std::vector<std::string> words_of(const FiguresOptions& options) {
  std::vector<std::string> words = {"--output",  options.folder,
                                    "--seed",    std::to_string(options.seed),
                                    "--threads", std::to_string(options.threads)};
  const auto add = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) words.push_back(name + "=" + value);  // views begin with a minus
  };
  add("--only", joined_texts(options.only, ","));
  add("--up", options.up);
  add("--view", options.view);
  if (options.size > 0) add("--size", std::to_string(options.size));
  if (options.quick) words.emplace_back("--quick");
  for (const std::string& model : options.models) add("--model", model);
  for (const std::string& set : options.points) add("--points", set);
  return words;
}

// The program replaces only files of earlier figures: it writes no names but its own.
int draw_figures(const FiguresOptions& options) {
  OutputGuard guard;
  guard.check_folder(options.folder, "-o");
  become_figures_program(words_of(options));
}

}  // namespace

JobFunction add_figures_job(Command& program) {
  Command command = program.add_subcommand(
      "figures", "Reproduce the figures of Quinn et al. 2013: pictures, data and an HTML page");
  command.example("meander figures -o figures --quick", "All figures with fewer points, in minutes");
  command.example("meander figures -o figures --only 15,16 --models bunny.obj",
                  "Two of them, on your own mesh");
  auto options = std::make_shared<FiguresOptions>();
  command.add_option("-o,--output", options->folder, "Output folder, created if missing").required();
  command.add_option("--models", options->models,
                     "Triangle meshes for the figures that show models (default: the bunny of the package "
                     "glmark2-data where it is installed, else a torus)");
  command.add_option(
      "--points", options->points,
      "NAME=FILE: point sets of other programs on the model, for the figure `limit`; the files of "
      "one NAME are one curve");
  command
      .add_option("--only", options->only,
                  "These figures only, by number or name: 1 to 26, table-1, and those of our own, as a wrong "
                  "name lists them")
      .separator(',');
  command.add_option(
      "--view", options->view,
      "Direction from the models towards the eye, X,Y,Z (default: in front, to the right and above)");
  command.add_option("--up", options->up, "The axis of the models that points up (default: y)")
      .one_of({"x", "y", "z"});
  command.add_option("--size", options->size, "Pixels of a picture of a model, 64 to 4096").range(64, 4096);
  command.add_option("--seed", options->seed, "Seed, 0 to 2^53").show_default();
  command.add_option("-j,--threads", options->threads, "Threads, up to 1024 (0: all available)")
      .show_default()
      .range(0, 1024);
  command.add_flag("--quick", options->quick, "Fewer points, shapes and sets");
  return [options] { return draw_figures(*options); };
}

}  // namespace meander
