// meander verify checks a store completely.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "io/json_writer.h"
#include "io/store/store_verify.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"

namespace meander {

namespace {

struct VerifyOptions {
  std::string store;
  std::size_t limit = 100;
  bool json = false;
};

int verify(const VerifyOptions& options) {
  warn_of_unfinished_run(options.store);
  if (!std::filesystem::is_regular_file(options.store))
    throw UsageError(fmt::format("`{}` is not a store: it is not a regular file", options.store));
  const VerifyResult result = verify_store(options.store, options.limit);
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("store", options.store);
                 json.member("rows", result.rows);
                 json.member("ok_rows", result.ok_rows);
                 json.list("problems", result.problems);
               }));
  } else {
    for (const std::string& problem : result.problems) fmt::print("{}\n", problem);
    fmt::print("{}: {} rows, {} ok, {}\n", options.store, result.rows, result.ok_rows,
               result.problems.empty() ? "whole"
                                       : fmt::format("{} problem{}", result.problems.size(),
                                                     result.problems.size() == 1 ? "" : "s"));
  }
  return result.problems.empty() ? exit_done : exit_some_failed;
}

}  // namespace

JobFunction add_verify_job(Command& program) {
  Command command = program.add_subcommand("verify", "Check a store completely: every byte, every row");
  command.example("meander verify store.h5", "Exit code 0: the store is whole");
  command.example("meander verify store.h5 --json", "The result for a program");
  auto options = std::make_shared<VerifyOptions>();
  command.add_option("STORE", options->store, "The store").required();
  command.add_option("--limit", options->limit, "Maximum number of problems to list")
      .show_default()
      .range(1, 1000000);
  command.add_flag("--json", options->json, "The result as JSON");
  return [options] { return verify(*options); };
}

}  // namespace meander
