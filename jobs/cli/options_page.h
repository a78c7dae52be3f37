// The reference of all options as a document (docs/OPTIONS.md), made from the description of the command line.
#pragma once

#include <string>

#include "jobs/cli/command_line.h"

namespace meander {

// Markdown: a section for every command that takes arguments, with its help, its usage, and a table of its
// options under each heading. The same description makes the same bytes.
std::string options_page(const CommandDescription& program);

}  // namespace meander
