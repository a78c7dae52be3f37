// The options of `meander run`: defaults, ranges and help in one place.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "jobs/cli/settings.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/work_options.h"
#include "jobs/inputs/inputs.h"
#include "kernels/model/sample_parameters.h"
#include "pipeline/sampling_graph.h"

namespace meander {

class Laboratory;

// What a run does again on a finished store.
struct RetryOptions {
  std::vector<Status> statuses;  // rows with these statuses
  bool changed = false;          // rows whose input has other bytes now
  bool vanished = false;         // rows whose input is gone: they leave the store
};

// Adds one word of --retry: the status of a failed item, `changed` or `vanished`. False for any other word.
bool add_retry_word(const std::string& word, RetryOptions& retry);
// All words, each once, separated by commas; empty when there is nothing to do again.
std::string words_of(const RetryOptions& retry);

struct RunOptions : WorkOptions {
  std::vector<std::string> inputs;
  std::string store;
  SampleParameters sample;
  bool certify = false;     // measure the samples of every model; needs the laboratory
  ColumnSet left_out = {};  // sample columns that are not stored
  Compression compression = Compression::standard;
  InputOptions collect;  // how the inputs are read
  std::uint64_t max_failures = ~std::uint64_t{0};
  RetryOptions retry;
  std::string reuse;
  StoreCheck check = StoreCheck::every_byte;  // of a finished store and of reuse
  bool fresh = false, dry_run = false, statistics = false;
  std::string parameters_json;  // all effective parameters that decide the rows, one line of JSON
};

// The columns of the store of these options, once they are resolved.
StoreColumns columns_of(const RunOptions& options);

// All parameters that decide the rows, as a store records them.
std::string recorded_parameters(const RunOptions& options);

// What the command line gave and resolve turns into RunOptions.
struct RunOptionTexts {
  SettingOptions settings;
  std::vector<std::string> retry;
  std::vector<std::string> stored;  // --store
  std::string folder;  // that a relative path of --tensor file:PATH begins in; empty: the working folder
};

// The options of add_budget_options (jobs/cli/work_options.h), and --max-failures.
void add_limit_options(Command running, RunOptions& options);

// The inputs, the store, and everything that decides its rows.
void add_store_options(Command& command, RunOptions& options, RunOptionTexts& texts);
// --reuse, --trust and --fresh.
void add_older_store_options(Command running, RunOptions& options);

// Which shard of an array `run STORE.run` works on (shard_run.h).
struct ShardOptions {
  std::string shard;                // "i/n"; empty: that of a task
  std::string task;                 // its number; empty: the variables of the environment say which it is
  int offset = 0;                   // added to the number of the task
  std::uint64_t shards_a_task = 0;  // task t works on the shards t K .. t K + K - 1; 0: as many as planned
  std::string scratch;              // the folder of the work that is not finished; empty: STORE.run
};

// --shard-offset and --shards-per-task.
void add_task_options(Command& array, int& offset, std::uint64_t& shards_a_task);

// Adds the subcommand with its options.
Command add_run_command(Command& program, RunOptions& options, RunOptionTexts& texts, ShardOptions& shard);
// Chooses the kinds of attributes that were named without one (see choose_kinds).
void choose_attribute_kinds(RunOptions& options, const StoreColumns* known, std::span<const PlanItem> items);
// Throws UsageError with every problem at once; also when an option needs the laboratory and there is none.
void resolve_run_options(RunOptions& options, const RunOptionTexts& texts, const Laboratory* laboratory);

}  // namespace meander
