// meander retrieve graph makes the graph of nearest neighbors that queries rank a store by.
#include <fmt/format.h>

#include <chrono>
#include <memory>

#include "io/json_writer.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/usage_error.h"
#include "jobs/retrieve/retrieve_commands.h"
#include "jobs/rows/graph_file.h"
#include "jobs/rows/rank_option.h"
#include "jobs/rows/retrieve_base.h"

namespace meander {

namespace {

int make_graph(const CompareOptions& options) {
  const std::filesystem::path path = graph_path(options.store);
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  guard.check(path.string(), {FileKind::graph}, "retrieve graph");
  const auto start = std::chrono::steady_clock::now();
  const StoreReader store(options.store, options.check);
  BaseRequest request = request_of(store, options);
  if (options.rank.empty()) request.rank.kind = RankKind::diffusion;
  if (request.rank.kind != RankKind::diffusion)
    throw UsageError("--rank: `" + options.rank + "` needs no graph");
  request.graph_of.clear();
  const RetrievalBase base = load_ranked_base(store, request);
  write_graph(path, origin_of_graph(options.store, base, request), base.ranking);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (options.json)
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("graph", path.string());
                 json.member("descriptor", joined(base.terms));
                 json.member("distance", options.distance);
                 json.member("rank", rank_word(base.ranking));
                 json.member("models", std::uint64_t{base.rows.size()});
                 json.member("edges", std::uint64_t{base.ranking.rows.size() / 2});
                 json.member("mutual_share", base.ranking.mutual_share);
                 json.member("seconds", seconds.count());
               }));
  else
    fmt::print("{}: {} models, {} edges; descriptor {}, distance {}, {}; in {:.2f} s\n", path.string(),
               base.rows.size(), base.ranking.rows.size() / 2, joined(base.terms), options.distance,
               rank_text(base.ranking), seconds.count());
  return exit_done;
}

}  // namespace

JobFunction add_graph_command(Command& retrieve) {
  auto options = std::make_shared<CompareOptions>();
  Command command = retrieve.add_subcommand(
      "graph",
      "Make the graph of nearest neighbors once, for queries of a large store with --rank diffusion");
  command.example("meander retrieve graph store.h5", "Write store.h5.graph");
  command.example("meander retrieve graph store.h5 --descriptor pairs --rank diffusion:8,0.85",
                  "Of one descriptor, with eight neighbors of each model");
  add_comparison_options(command, *options);
  command.add_flag("--json", options->json, "Print the summary as JSON").common();
  return [options] { return make_graph(*options); };
}

}  // namespace meander
