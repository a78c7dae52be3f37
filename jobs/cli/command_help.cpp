#include "jobs/cli/command_help.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "kernels/core/joined_texts.h"

namespace meander {

namespace {

constexpr std::size_t text_column = 26;       // of the texts beside the names of options
constexpr std::size_t min_beside_width = 60;  // narrower lines have the texts below the names

// The word, or the parts that it may be broken into: each ends with | or a comma.
std::vector<std::string_view> parts_of(std::string_view word, std::size_t room) {
  std::vector<std::string_view> parts;
  const bool is_long = word.size() > room;
  for (std::size_t end; is_long && (end = word.find_first_of("|,")) + 1 < word.size() && end != word.npos;) {
    parts.push_back(word.substr(0, end + 1));
    word.remove_prefix(end + 1);
  }
  parts.push_back(word);
  return parts;
}

// Breaks the text into lines. The first continues at `column`, the others begin at `indent`; a line of the
// text that begins with blanks keeps them, and what it continues in is indented further. Ends with a line
// break.
std::string wrapped(std::string_view text, std::size_t column, std::size_t indent, std::size_t width) {
  std::string lines;
  std::size_t at = column;  // where the next character goes
  std::size_t next_indent = indent;
  bool has_words = false;  // in this line
  const auto put = [&](std::string_view piece, bool is_apart) {
    if (has_words && at + (is_apart ? 1 : 0) + piece.size() > width) {
      lines += '\n' + std::string(next_indent, ' ');
      at = next_indent;
    } else if (has_words && is_apart) {
      lines += ' ';
      ++at;
    }
    lines += piece;
    at += piece.size();
    has_words = true;
  };
  for (bool is_first = true; is_first || !text.empty(); is_first = false) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(text.size(), end + 1));
    const std::size_t blanks = std::min(line.find_first_not_of(' '), line.size());
    const std::size_t begin = is_first ? 0 : indent;
    if (blanks < line.size()) lines.append(begin + blanks, ' ');
    at = (is_first ? column : begin) + blanks;
    next_indent = indent + blanks + (blanks > 0 ? 2 : 0);
    has_words = false;
    while (!line.empty()) {
      const std::size_t word_end = std::min(line.find(' '), line.size());
      bool is_apart = true;
      if (word_end > 0)
        for (const std::string_view part :
             parts_of(line.substr(0, word_end), width - std::min(width, next_indent))) {
          put(part, is_apart);
          is_apart = false;
        }
      line.remove_prefix(std::min(line.size(), word_end + 1));
    }
    lines += '\n';
  }
  return lines;
}

std::string indented(std::string_view text, std::size_t indent, std::size_t width) {
  return std::string(indent, ' ') + wrapped(text, indent, indent, width);
}

// A name with its text beside it, or below it where it is long or the lines are short.
std::string entry(const std::string& name, const std::string& text, std::size_t width) {
  const bool is_narrow = width < min_beside_width;
  const std::size_t column = is_narrow ? 6 : text_column;
  if (!is_narrow && name.size() + 4 <= column)
    return fmt::format("  {:<{}}", name, column - 2) + wrapped(text, column, column, width);
  return "  " + wrapped(name, 2, 8, width) + indented(text, column, width);
}

std::string name_and_value(const OptionDescription& option) {
  std::string value = option.words.empty() ? option.value : joined_texts(option.words, "|");
  if (option.repeated) value += " ...";
  if (option.flags.empty()) return value;
  return fmt::format("{}{}{}", joined_texts(option.flags), value.empty() ? "" : " ", value);
}

std::string help_and_notes(const OptionDescription& option) {
  const std::string notes = option_notes(option);
  return notes.empty() ? option.help : option.help + " (" + notes + ")";
}

std::string usage(const CommandDescription& command, const std::string& words, std::size_t width) {
  std::string text = words;
  const auto is_option = [](const OptionDescription& option) { return !option.flags.empty(); };
  if (std::any_of(command.options.begin(), command.options.end(), is_option)) text += " [OPTIONS]";
  for (const OptionDescription& option : command.options) {
    if (is_option(option)) continue;
    const std::string name = option.value + (option.repeated ? " ..." : "");
    text += option.required ? " " + name : " [" + name + "]";
  }
  if (!command.subcommands.empty()) text += " COMMAND ...";
  return "Usage: " + wrapped(text, 7, 7, width);
}

std::string subcommand_text(const CommandDescription& command, std::size_t width) {
  std::string text;
  for (const CommandDescription& subcommand : command.subcommands)
    text += entry(subcommand.name, subcommand.help, width);
  return text.empty() ? "" : "\nCommands:\n" + text;
}

std::string option_text(const CommandDescription& command, const std::string& words, HelpScope scope,
                        std::size_t width) {
  const bool is_marked = std::any_of(command.options.begin(), command.options.end(),
                                     [](const OptionDescription& option) { return option.common; });
  const auto is_shown = [&](const OptionDescription& option) {
    return scope == HelpScope::all || !is_marked || option.common || option.required || option.flags.empty();
  };
  std::vector<std::string> headings;
  std::size_t left_out = 0;
  std::string arguments;
  for (const OptionDescription& option : command.options) {
    left_out += is_shown(option) ? 0 : 1;
    if (option.flags.empty())
      arguments += entry(name_and_value(option), help_and_notes(option), width);
    else if (is_shown(option) &&
             std::find(headings.begin(), headings.end(), option.heading) == headings.end())
      headings.push_back(option.heading);
  }
  std::string text = arguments.empty() ? "" : "\nArguments:\n" + arguments;
  // A short list needs no headings.
  if (left_out > 0) headings.resize(1);
  for (const std::string& heading : headings) {
    text += "\n" + wrapped((left_out > 0 ? "Common options" : heading) + ":", 0, 0, width);
    for (const OptionDescription& option : command.options)
      if (!option.flags.empty() && is_shown(option) && (left_out > 0 || option.heading == heading))
        text += entry(name_and_value(option), help_and_notes(option), width);
  }
  if (left_out > 0)
    text += "\n" + wrapped(fmt::format("`{} --help-all` shows {} more option{}.", words, left_out,
                                       left_out == 1 ? "" : "s"),
                           0, 0, width);
  return text;
}

}  // namespace

std::string option_notes(const OptionDescription& option) {
  std::vector<std::string> notes;
  if (option.required && !option.flags.empty()) notes.push_back("required");
  if (!option.initial.empty()) notes.push_back("default: " + option.initial);
  if (!option.needs.empty()) notes.push_back(fmt::format("only with {}", joined_texts(option.needs)));
  if (!option.excludes.empty()) notes.push_back(fmt::format("not with {}", joined_texts(option.excludes)));
  return joined_texts(notes, "; ");
}

namespace {

// A command in lines that a shell takes as one; an option stays with its value.
std::string command_lines(std::string_view line, std::size_t width) {
  constexpr std::string_view goes_on = " \\";
  std::string text = "  ";
  std::size_t at = text.size();
  bool is_first = true;
  while (!line.empty()) {
    std::size_t end = line.find(' ');
    if (line.starts_with('-') && end != line.npos && line.substr(end + 1, 1) != "-")
      end = line.find(' ', end + 1);
    const std::string_view words = line.substr(0, end);
    line.remove_prefix(std::min(line.size(), words.size() + 1));
    if (!is_first && at + 1 + words.size() + (line.empty() ? 0 : goes_on.size()) > width) {
      text += std::string(goes_on) + "\n    ";
      at = 4;
    } else if (!is_first) {
      text += ' ';
      ++at;
    }
    text += words;
    at += words.size();
    is_first = false;
  }
  return text + "\n";
}

}  // namespace

std::string example_text(const CommandDescription& command, int width) {
  std::string text;
  for (const CommandExample& example : command.examples)
    text += command_lines(example.line, static_cast<std::size_t>(width)) +
            indented(example.purpose, 6, static_cast<std::size_t>(width));
  return text;
}

std::string command_help(const CommandDescription& command, const std::string& words, HelpScope scope,
                         int width) {
  const auto columns = static_cast<std::size_t>(width);
  std::string text = wrapped(command.help, 0, 0, columns);
  if (!command.examples.empty()) text += "\n" + example_text(command, width);
  text += "\n" + usage(command, words, columns);
  text += subcommand_text(command, columns);
  text += option_text(command, words, scope, columns);
  if (!command.footer.empty()) text += "\n" + wrapped(command.footer, 0, 0, columns);
  return text;
}

}  // namespace meander
