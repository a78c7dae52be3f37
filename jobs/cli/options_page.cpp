#include "jobs/cli/options_page.h"

#include <fmt/format.h>

#include "kernels/core/joined_texts.h"

namespace meander {

namespace {

// Text of a cell: no bar ends it, and no line.
std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|' || c == '<' || c == '*' || c == '_') escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

std::string name_of(const OptionDescription& option) {
  if (option.flags.empty()) return fmt::format("`{}`{}", option.value, option.repeated ? " ..." : "");
  std::string text = fmt::format("`{}`", joined_texts(option.flags, "`, `"));
  if (option.words.empty() && !option.value.empty()) text += " " + cell(option.value);
  return text + (option.repeated ? " ..." : "");
}

std::string meaning_of(const OptionDescription& option) {
  std::string text = cell(option.help);
  if (!option.words.empty()) text += fmt::format(" (`{}`)", joined_texts(option.words, "`, `"));
  return text + (option.required && !option.flags.empty() ? " (required)" : "");
}

void add(const CommandDescription& command, const std::string& before, std::string& page) {
  const std::string name = before.empty() ? command.name : before + " " + command.name;
  if (!before.empty() && !command.options.empty() && command.subcommands.empty()) {
    page += fmt::format("\n## {}\n\n{}.\n", name, command.help);
    std::string heading;
    bool is_first = true;
    for (const OptionDescription& option : command.options) {
      if (!option.flags.empty() && option.flags.back().starts_with("--help"))
        continue;  // every command has them
      const std::string own = option.flags.empty() ? "Arguments" : option.heading;
      if (is_first || own != heading)
        page += fmt::format("\n| {} | default | |\n|---|---|---|\n", heading = own);
      is_first = false;
      page += fmt::format("| {} | {} | {} |\n", name_of(option), cell(option.initial), meaning_of(option));
    }
  }
  for (const CommandDescription& subcommand : command.subcommands) add(subcommand, name, page);
}

}  // namespace

std::string options_page(const CommandDescription& program) {
  std::string page =
      "# Options\n\nEvery command with all of its options, as `meander pages` writes them; `meander help "
      "COMMAND` "
      "shows the same.\nValues that an option lists are the only ones that it takes.\n";
  add(program, "", page);
  return page;
}

}  // namespace meander
