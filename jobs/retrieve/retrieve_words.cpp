// meander retrieve words learns what local pairs of a store have in common, and codes its models.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>

#include "io/json_writer.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/output_guard.h"
#include "jobs/inputs/store_items.h"
#include "jobs/retrieve/retrieve_commands.h"
#include "jobs/rows/local_codes.h"

namespace meander {

namespace {

struct WordsOptions {
  std::string store;
  bool replace = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
};

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
  if (learns) codes = learn_local_codes(store);
  const std::uint64_t made = code_rows(store, *codes);
  write_local_codes(path, *codes);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (options.json) {
    fmt::print("{}\n", json_object([&](JsonWriter& json) {
                 json.member("words_file", path.string());
                 json.member("checksum", codes->checksum());
                 json.member("words", std::uint64_t{codes->words.words});
                 json.member("values", std::uint64_t{codes->words.values()});
                 json.member("learned_now", learns);
                 json.member("learned_from", std::uint64_t{codes->learnt_from});
                 json.member("models", std::uint64_t{codes->codes.size()});
                 json.member("coded", made);
                 json.member("seconds", seconds.count());
               }));
    return exit_done;
  }
  fmt::print(
      "{}: {} {} words from {} models, checksum {}; {} values for each of {} models, {} coded now, in {:.2f} "
      "s\n",
      path.string(), learns ? "learned" : "kept", codes->words.words, codes->learnt_from,
      codes->checksum().substr(0, 8), codes->words.values(), codes->codes.size(), made, seconds.count());
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
  command.add_flag("--json", options->json, "Print the summary as JSON").common();
  add_trust_option(command, options->check);
  return [options] { return learn_words(*options); };
}

}  // namespace meander
