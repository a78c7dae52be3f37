// meander pages: manual pages, completions and the page of all options, written while the program is built.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "io/file/atomic_file.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/command_pages.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/options_page.h"
#include "meander_version.h"

namespace meander {

JobFunction add_pages_job(Command& program) {
  Command command = program.add_unlisted_subcommand("pages", "Write manual pages and completions of shells");
  auto folder = std::make_shared<std::string>();
  command.add_option("FOLDER", *folder, "The share/ of an installation, created if missing").required();
  return [program, folder] {
    const CommandDescription description = program.description();
    std::vector<CommandPage> pages = command_pages(description, meander_version);
    pages.emplace_back("doc/meander/OPTIONS.md", options_page(description));
    for (const auto& [name, text] : pages) {
      const std::filesystem::path file = std::filesystem::path(*folder) / name;
      std::filesystem::create_directories(file.parent_path());
      replace_file(file, text);
    }
    fmt::print("{} files in {}\n", pages.size(), *folder);
    return exit_done;
  };
}

}  // namespace meander
