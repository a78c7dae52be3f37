// The help of a command as text for a terminal.
#pragma once

#include <string>

#include "jobs/cli/command_line.h"

namespace meander {

// common: positional arguments, required options and those that are marked as common.
enum class HelpScope { common, all };

// Examples, arguments and options, in lines of at most `width` columns (20 or more) that are broken between
// words; a word that is longer than a line is broken behind | or a comma, where it has any. `words` lead to
// the command: "meander retrieve query".
std::string command_help(const CommandDescription& command, const std::string& words, HelpScope scope,
                         int width);

// "default: 4; only with --picture"; empty where there is nothing to add to the help of the option.
std::string option_notes(const OptionDescription& option);

// The examples alone, each with its purpose below it.
std::string example_text(const CommandDescription& command, int width);

}  // namespace meander
