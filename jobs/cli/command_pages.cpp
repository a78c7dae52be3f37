#include "jobs/cli/command_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "jobs/cli/command_help.h"
#include "kernels/core/joined_texts.h"

namespace meander {

namespace {

// A command with the words that lead to it: "meander retrieve query".
struct NamedCommand {
  std::vector<std::string> words;
  const CommandDescription* command;
};

void list_commands(const CommandDescription& command, std::vector<std::string> words,
                   std::vector<NamedCommand>& all) {
  words.push_back(command.name);
  all.push_back({words, &command});
  for (const CommandDescription& subcommand : command.subcommands) list_commands(subcommand, words, all);
}

std::vector<NamedCommand> all_commands(const CommandDescription& program) {
  std::vector<NamedCommand> all;
  list_commands(program, {}, all);
  return all;
}

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// ---- manual pages (man(7)) -------------------------------------------------------------------------------

// Text of a page: nothing in it is a request, and minus signs stay what they are when they are copied.
std::string roff(const std::string& text) {
  std::string escaped = replaced(replaced(text, "\\", "\\e"), "-", "\\-");
  escaped = replaced(escaped, "|", "|\\:");  // a list of words may be broken there
  std::string lines;
  for (std::size_t begin = 0; begin <= escaped.size();) {
    const std::size_t end = std::min(escaped.find('\n', begin), escaped.size());
    const std::string line = escaped.substr(begin, end - begin);
    if (begin > 0) lines += line.starts_with(" ") ? "\n" : "\n.br\n";  // a blank begins a line by itself
    if (line.starts_with(".") || line.starts_with("'")) lines += "\\&";
    lines += line;
    begin = end + 1;
  }
  return lines;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string slanted(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string value_text(const OptionDescription& option) {
  const std::string value =
      option.words.empty() ? slanted(option.value) : roff(joined_texts(option.words, "|"));
  return value + (option.repeated ? " ..." : "");
}

std::string head_of(const OptionDescription& option) {
  if (option.flags.empty()) return value_text(option);
  std::string text;
  for (const std::string& flag : option.flags) text += (text.empty() ? "" : ", ") + bold(flag);
  return option.value.empty() ? text : text + " " + value_text(option);
}

std::string synopsis(const NamedCommand& named) {
  const CommandDescription& command = *named.command;
  std::string text = bold(joined_texts(named.words, " "));
  if (std::any_of(command.options.begin(), command.options.end(),
                  [](const OptionDescription& o) { return !o.flags.empty() && !o.required; }))
    text += " [" + slanted("OPTIONS") + "]";
  for (const OptionDescription& option : command.options) {
    if (!option.flags.empty() && !option.required) continue;
    const std::string shown =
        option.flags.empty() ? value_text(option) : bold(option.flags.front()) + " " + value_text(option);
    text += option.required ? " " + shown : " [" + shown + "]";
  }
  if (!command.subcommands.empty()) text += " " + slanted("COMMAND") + " ...";
  return text + "\n";
}

std::string page_name(const std::vector<std::string>& words) { return joined_texts(words, "-"); }

std::string upper_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return text;
}

std::string options_text(const CommandDescription& command) {
  std::string arguments, options, heading;
  std::vector<std::string> headings;
  for (const OptionDescription& option : command.options)
    if (std::find(headings.begin(), headings.end(), option.heading) == headings.end())
      headings.push_back(option.heading);
  for (const std::string& wanted : headings)
    for (const OptionDescription& option : command.options) {
      if (option.heading != wanted) continue;
      std::string& text = option.flags.empty() ? arguments : options;
      if (!option.flags.empty() && heading != wanted) {
        heading = wanted;
        if (heading != "Options") options += ".SS " + roff(heading) + "\n";
      }
      text += ".TP\n" + head_of(option) + "\n" + roff(option.help);
      if (const std::string notes = option_notes(option); !notes.empty()) text += roff(" (" + notes + ")");
      text += "\n";
    }
  return (arguments.empty() ? "" : ".SH ARGUMENTS\n" + arguments) +
         (options.empty() ? "" : ".SH OPTIONS\n" + options);
}

std::string see_also(const NamedCommand& named, const std::vector<NamedCommand>& all) {
  std::vector<std::string> pages;
  for (const NamedCommand& other : all)
    if (other.command != named.command &&
        (named.words.size() == 1 || other.words.size() == 1 || other.words[1] == named.words[1]))
      pages.push_back(bold(page_name(other.words)) + "(1)");
  return pages.empty() ? "" : fmt::format(".SH SEE ALSO\n{}\n", joined_texts(pages, ",\n"));
}

std::string manual_page(const NamedCommand& named, const std::vector<NamedCommand>& all,
                        const std::string& version) {
  const CommandDescription& command = *named.command;
  const std::string& program = all.front().words.front();
  const std::string name = page_name(named.words);
  std::string text = fmt::format(".TH \"{}\" 1 \"\" \"{} {}\" \"User Commands\"\n.ad l\n",
                                 roff(upper_case(name)), roff(program), roff(version));
  text += fmt::format(".SH NAME\n{} \\- {}\n", roff(name), roff(first_line(command.help)));
  text += ".SH SYNOPSIS\n" + synopsis(named);
  text += ".SH DESCRIPTION\n" + roff(command.help) + ".\n";
  if (!command.subcommands.empty()) {
    text += ".SH COMMANDS\n";
    for (const CommandDescription& subcommand : command.subcommands)
      text += ".TP\n" + bold(subcommand.name) + "\n" + roff(subcommand.help) + "\n";
  }
  if (!command.examples.empty()) {
    text += ".SH EXAMPLES\n";
    for (const CommandExample& example : command.examples)
      text += ".TP\n" + bold(example.line) + "\n" + roff(example.purpose) + "\n";
  }
  text += options_text(command);
  const std::string& footer = all.front().command->footer;
  if (!footer.empty()) text += ".SH EXIT STATUS\n.nf\n" + replaced(roff(footer), ".br\n", "") + "\n.fi\n";
  return text + see_also(named, all);
}

// ---- completions -----------------------------------------------------------------------------------------

std::string in_shell_quotes(const std::string& text) { return "'" + replaced(text, "'", "'\\''") + "'"; }

std::string subcommand_names(const CommandDescription& command) {
  std::string names;
  for (const CommandDescription& subcommand : command.subcommands)
    names += (names.empty() ? "" : " ") + subcommand.name;
  return names;
}

std::string flag_names(const CommandDescription& command) {
  std::string names;
  for (const OptionDescription& option : command.options)
    for (const std::string& flag : option.flags) names += (names.empty() ? "" : " ") + flag;
  return names;
}

// The function finds the command among the words typed so far, then offers its subcommands, its options, or
// the words of the option before the cursor; file names else.
std::string bash_completion(const CommandDescription& program) {
  const std::vector<NamedCommand> all = all_commands(program);
  std::string subcommands, flags, values, words;
  for (const NamedCommand& named : all) {
    const std::string path = joined_texts(named.words, " ");
    if (!named.command->subcommands.empty())
      subcommands += fmt::format("    {}) echo {} ;;\n", in_shell_quotes(path),
                                 in_shell_quotes(subcommand_names(*named.command)));
    flags += fmt::format("    {}) echo {} ;;\n", in_shell_quotes(path),
                         in_shell_quotes(flag_names(*named.command)));
    for (const OptionDescription& option : named.command->options) {
      if (option.value.empty() || option.flags.empty()) continue;
      std::string patterns;
      for (const std::string& flag : option.flags)
        patterns += (patterns.empty() ? "" : "|") + in_shell_quotes(path + " " + flag);
      values += fmt::format("    {}) return 0 ;;\n", patterns);
      if (!option.words.empty())
        words +=
            fmt::format("    {}) echo {} ;;\n", patterns, in_shell_quotes(joined_texts(option.words, " ")));
    }
  }
  const std::string function = "_" + program.name;
  return fmt::format(R"(# Completion of {0} for bash. Made with the program from its options.
{1}_subcommands() {{
  case "$1" in
{2}  esac
}}
{1}_options() {{
  case "$1" in
{3}  esac
}}
{1}_takes_value() {{
  case "$1" in
{4}  esac
  return 1
}}
{1}_words() {{
  case "$1" in
{5}  esac
}}
{1}() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" before="" command={0} word i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word="${{COMP_WORDS[i]}}"
    if [[ $word == = ]]; then continue; fi
    if [[ -n $before ]]; then before=""; continue; fi
    if {1}_takes_value "$command $word"; then before=$word; continue; fi
    if [[ " $({1}_subcommands "$command") " == *" $word "* ]]; then command+=" $word"; fi
  done
  if [[ $current == = ]]; then current=""; fi
  local offered=""
  if [[ -n $before ]]; then
    offered=$({1}_words "$command $before")
  elif [[ $current == -* ]]; then
    offered=$({1}_options "$command")
  else
    offered=$({1}_subcommands "$command")
  fi
  if [[ -n $offered ]]; then
    COMPREPLY=($(compgen -W "$offered" -- "$current"))
  elif [[ $current != -* ]]; then
    local IFS=$'\n'
    COMPREPLY=($(compgen -f -- "$current"))
    compopt -o filenames 2>/dev/null
  fi
}}
complete -F {1} {0}
)",
                     program.name, function, subcommands, flags, values, words);
}

// One line of _arguments: '(-o --output)'{-o,--output}'[help]:TEXT:_files'.
std::string zsh_argument(const OptionDescription& option) {
  std::string help = first_line(option.help);
  for (const char* special : {"\\", "[", "]", ":"})
    help = replaced(help, special, std::string("\\") + special);
  const std::string action = option.words.empty()
                                 ? (option.value == "N" || option.value == "X" ? " " : "_files")
                                 : fmt::format("({})", joined_texts(option.words, " "));
  if (option.flags.empty()) return in_shell_quotes((option.repeated ? "*:" : ":") + option.value + ":_files");
  const std::string value = option.value.empty() ? "" : ":" + option.value + ":" + action;
  const std::string rest = in_shell_quotes("[" + help + "]" + value);
  const std::string many = option.repeated ? "*" : "";
  if (option.flags.size() == 1) return in_shell_quotes(many + option.flags.front()) + rest;
  const std::string group =
      many.empty() ? in_shell_quotes(fmt::format("({})", joined_texts(option.flags, " "))) : "'*'";
  return fmt::format("{}{{{}}}{}", group, joined_texts(option.flags, ","), rest);
}

std::string zsh_function(const NamedCommand& named) {
  std::string text = fmt::format("_{}() {{\n", joined_texts(named.words, "_"));
  const CommandDescription& command = *named.command;
  std::string arguments;
  for (const OptionDescription& option : command.options) arguments += " \\\n    " + zsh_argument(option);
  if (command.subcommands.empty()) return text + "  _arguments -s" + arguments + "\n}\n";
  text += "  local context state line\n  _arguments -C" + arguments;
  text +=
      " \\\n    '1: :->command' \\\n    '*:: :->rest'\n  case $state in\n    command)\n      local -a "
      "commands=(";
  for (const CommandDescription& subcommand : command.subcommands)
    text += "\n        " +
            in_shell_quotes(subcommand.name + ":" + replaced(first_line(subcommand.help), ":", "\\:"));
  text += fmt::format(")\n      _describe command commands ;;\n    rest)\n      case $line[1] in\n");
  for (const CommandDescription& subcommand : command.subcommands)
    text += fmt::format("        {1}) _{0}_{1} ;;\n", joined_texts(named.words, "_"), subcommand.name);
  return text + "      esac ;;\n  esac\n}\n";
}

std::string zsh_completion(const CommandDescription& program) {
  std::string text = fmt::format(
      "#compdef {0}\n# Completion of {0} for zsh. Made with the program from its options.\n", program.name);
  for (const NamedCommand& named : all_commands(program)) text += zsh_function(named);
  return text + fmt::format("_{} \"$@\"\n", program.name);
}

std::string fish_completion(const CommandDescription& program) {
  std::string text =
      fmt::format("# Completion of {} for fish. Made with the program from its options.\n", program.name);
  for (const NamedCommand& named : all_commands(program)) {
    const CommandDescription& command = *named.command;
    std::string condition;
    for (std::size_t i = 1; i < named.words.size(); ++i)
      condition += (i > 1 ? "; and " : "") + ("__fish_seen_subcommand_from " + named.words[i]);
    if (!command.subcommands.empty()) {
      const std::string none = "not __fish_seen_subcommand_from " + subcommand_names(command);
      condition += (condition.empty() ? "" : "; and ") + none;
    }
    const std::string start = fmt::format("complete -c {} -n {}", program.name, in_shell_quotes(condition));
    for (const CommandDescription& subcommand : command.subcommands)
      text += fmt::format("{} -f -a {} -d {}\n", start, subcommand.name,
                          in_shell_quotes(first_line(subcommand.help)));
    for (const OptionDescription& option : command.options) {
      if (option.flags.empty()) continue;
      text += start;
      for (const std::string& flag : option.flags)
        text += flag.starts_with("--") ? " -l " + flag.substr(2) : " -s " + flag.substr(1);
      if (!option.value.empty()) text += " -r";
      if (!option.words.empty())
        text += fmt::format(" -f -a {}", in_shell_quotes(joined_texts(option.words, " ")));
      text += " -d " + in_shell_quotes(first_line(option.help)) + "\n";
    }
  }
  return text;
}

}  // namespace

std::vector<CommandPage> command_pages(const CommandDescription& program, const std::string& version) {
  const std::vector<NamedCommand> all = all_commands(program);
  std::vector<CommandPage> pages;
  for (const NamedCommand& named : all)
    pages.emplace_back(fmt::format("man/man1/{}.1", page_name(named.words)),
                       manual_page(named, all, version));
  pages.emplace_back("bash-completion/completions/" + program.name, bash_completion(program));
  pages.emplace_back("zsh/vendor-completions/_" + program.name, zsh_completion(program));
  pages.emplace_back("fish/vendor_completions.d/" + program.name + ".fish", fish_completion(program));
  return pages;
}

}  // namespace meander
