// Manual pages and completions of shells, made from the description of the command line, which is their only
// source.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "jobs/cli/command_line.h"

namespace meander {

// A file below share/ of an installation, and its text.
using CommandPage = std::pair<std::string, std::string>;

// man/man1/PROGRAM.1 and one for every subcommand (PROGRAM-run.1), and completions for bash, zsh and fish.
// `version` stands in the footers of the manual pages. The same description makes the same bytes.
std::vector<CommandPage> command_pages(const CommandDescription& program, const std::string& version);

}  // namespace meander
