// meander help shows the help of a command.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

#include "jobs/cli/command_help.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/terminal.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/joined_texts.h"
#include "kernels/core/spelling.h"

namespace meander {

namespace {

const CommandDescription& named_command(const CommandDescription& command, const std::string& name) {
  std::vector<std::string> names;
  for (const CommandDescription& subcommand : command.subcommands) {
    if (subcommand.name == name) return subcommand;
    names.push_back(subcommand.name);
  }
  if (names.empty()) throw UsageError(fmt::format("`{}` has no command `{}`", command.name, name));
  const std::string near = nearest(name, names);
  throw UsageError(fmt::format("`{}` is not a command{}", name,
                               near.empty() ? fmt::format(": the commands are {}", joined_texts(names))
                                            : ", did you mean `" + near + "`?"));
}

}  // namespace

JobFunction add_help_job(Command& program) {
  Command command = program.add_subcommand("help", "Show the help of a command");
  command.example("meander help run", "Examples and the common options of `meander run`");
  command.example("meander help retrieve query --all", "All options of `meander retrieve query`");
  struct Asked {
    std::vector<std::string> words;
    bool all = false;
  };
  auto asked = std::make_shared<Asked>();
  command.add_option("COMMAND", asked->words, "The command, such as run or `retrieve query`");
  command.add_flag("--all", asked->all, "All options, as --help-all shows them");
  return [program, asked] {
    const CommandDescription all = program.description();
    const CommandDescription* shown = &all;
    std::string words = all.name;
    for (const std::string& word : asked->words) {
      shown = &named_command(*shown, word);
      words += " " + word;
    }
    fmt::print("{}", command_help(*shown, words, asked->all ? HelpScope::all : HelpScope::common,
                                  terminal_width(STDOUT_FILENO)));
    return exit_done;
  };
}

}  // namespace meander
