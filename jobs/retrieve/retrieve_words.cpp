// meander retrieve words learns what local pairs of a store have in common, and codes its models.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>

#include "io/json_writer.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/option_words.h"
#include "jobs/cli/output_guard.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/store_items.h"
#include "jobs/retrieve/retrieve_commands.h"
#include "jobs/rows/local_codes.h"

namespace meander {

namespace {

struct WordsOptions {
  std::string store;
  LocalPairParameters pairs;
  std::string unit = "size";
  bool replace = false, json = false, shapes_pairs = false;  // shapes_pairs: any of the three was given
  StoreCheck check = StoreCheck::every_byte;
};

std::string histograms_text(const LocalPairParameters& pairs) {
  return fmt::format("{} points a model, radius {} x {}", pairs.centers, pairs.radius,
                     text_of(radius_unit_words, pairs.unit));
}

bool same_histograms(const LocalPairParameters& a, const LocalPairParameters& b) {
  return a.sense == b.sense && a.centers == b.centers && a.radius == b.radius && a.unit == b.unit;
}

int learn_words(const WordsOptions& options) {
  const std::filesystem::path path = words_path(options.store);
  OutputGuard guard;
  guard.protect(options.store, "the store itself");
  guard.check(path.string(), {FileKind::words}, "retrieve words");
  const auto start = std::chrono::steady_clock::now();
  const StoreReader store(options.store, options.check);
  std::optional<LocalCodes> codes;
  if (!options.replace) codes = read_local_codes(path);
  const bool learns = !codes;
  LocalPairParameters pairs = options.pairs;
  pairs.unit = value_of(radius_unit_words, options.unit);
  if (learns) codes = learn_local_codes(store, pairs);
  if (options.shapes_pairs && !same_histograms(pairs, codes->pairs))
    throw UsageError(fmt::format("`{}` has words of other histograms ({}): --replace learns words of {}",
                                 path.string(), histograms_text(codes->pairs), histograms_text(pairs)));
  const auto learned = std::chrono::steady_clock::now();
  const std::uint64_t made = code_rows(store, *codes);
  const std::chrono::duration<double, std::milli> coding = std::chrono::steady_clock::now() - learned;
  const bool of_this_store = learns || are_words_of(store, *codes);
  write_local_codes(path, *codes);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("words_file", path.string());
                 json.member("checksum", codes->checksum());
                 json.member("words", std::uint64_t{codes->words.words});
                 json.member("values", std::uint64_t{codes->words.values()});
                 json.member("local_points", std::uint64_t{codes->pairs.centers});
                 json.member("radius", codes->pairs.radius);
                 json.member("radius_unit", text_of(radius_unit_words, codes->pairs.unit));
                 json.member("learned_now", learns);
                 json.member("learned_from", std::uint64_t{codes->learnt_from});
                 json.member("words_of_this_store", of_this_store);
                 json.member("models", std::uint64_t{codes->codes.size()});
                 json.member("coded", made);
                 json.member("coding_milliseconds", coding.count());
                 json.member("seconds", seconds.count());
               }));
    return exit_done;
  }
  fmt::print(
      "{}: {} {} words from {} models, checksum {}; {} values for each of {} models, {} coded now, in {:.2f} "
      "s\n{}",
      path.string(), learns ? "learned" : "kept", codes->words.words, codes->learnt_from,
      codes->checksum().substr(0, 8), codes->words.values(), codes->codes.size(), made, seconds.count(),
      of_this_store ? "" : "the store as it is gives other words: --replace learns them\n");
  return exit_done;
}

}  // namespace

JobFunction add_words_command(Command& retrieve) {
  auto options = std::make_shared<WordsOptions>();
  Command command = retrieve.add_subcommand(
      "words", "Learn the words of local pairs from a store, for the descriptor local-pairs");
  command.example("meander retrieve words store.h5",
                  "Write store.h5.words, which `retrieve query` and `retrieve evaluate` then use");
  command.example("meander retrieve words store.h5 --replace",
                  "Learn other words, as after many models joined");
  command.add_option("STORE", options->store, "The store; STORE.words is written beside it").required();
  command
      .add_flag("--replace", options->replace,
                "Learn the words anew where STORE.words has some (default: keep them, and code new models)")
      .common();
  const auto given = [options] { options->shapes_pairs = true; };
  command
      .add_option("--local-points", options->pairs.centers,
                  "Samples of a model that local pairs are counted around, 1 to 4096")
      .show_default()
      .range(1, 4096)
      .on_given(given);
  command
      .add_option("--radius", options->pairs.radius,
                  "How far pairs are counted around a sample, in units of --radius-unit")
      .show_default()
      .range(0.01, 1000.0)
      .on_given(given);
  command
      .add_option("--radius-unit", options->unit,
                  "size: the root mean square distance of the samples from their centroid; spacing: the mean "
                  "distance of a sample to the nearest other")
      .show_default()
      .one_of(all_words(radius_unit_words))
      .on_given(given);
  command.add_flag("--json", options->json, "Print the summary as JSON").common();
  add_trust_option(command, options->check);
  return [options] { return learn_words(*options); };
}

}  // namespace meander
