// meander run samples files into one store.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "io/store/run_plan.h"
#include "io/store/schema.h"
#include "jobs/cli/allow_failures.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/input_options.h"
#include "jobs/inputs/inputs.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/attribute_types.h"
#include "jobs/rows/descriptor_choice.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/memory_budget.h"
#include "jobs/rows/planned_run.h"
#include "jobs/rows/run_header.h"
#include "jobs/rows/run_options.h"
#include "jobs/rows/run_summary.h"
#include "jobs/rows/store_update.h"
#include "jobs/run/array_plan.h"
#include "jobs/run/reusable_rows.h"
#include "jobs/run/shard_run.h"
#include "pipeline/memory_estimate.h"

namespace meander {

namespace {

// One run: unfinished work is finished first, then the finished store is compared with the inputs and brought
// up to date.
class RunJob {
 public:
  RunJob(RunOptions& options, const Laboratory* laboratory, const StageHook& hook)
      : options_(options), laboratory_(laboratory), hook_(hook) {}

  int run() {
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              static_cast<std::size_t>(options_.threads));
    std::optional<RunPlan> unfinished;
    if (!options_.fresh) {
      if (read_run_array(options_.store))
        throw UsageError(
            fmt::format("`{0}.run` is divided among many processes: continue with `meander run {0}.run`, "
                        "`meander status {0}.run` and `meander merge {0}.run`, or discard it with --fresh",
                        options_.store));
      unfinished = read_run_plan(options_.store);
      options_.collect.remembered_root = earlier_root(unfinished);
    }
    inputs_ = collect_run_inputs(options_);
    if (retry_.vanished && !inputs_.notes.unread.empty())
      throw UsageError(
          "--retry vanished: items in unread folders may still exist; make the folders readable first");
    if (options_.dry_run && options_.json)
      throw UsageError("--dry-run prints a plan and --json a summary of a run: give one of them");
    check_run_outputs(options_, inputs_);
    choose_kinds(unfinished);
    header_ = run_header(options_, inputs_, laboratory_);
    options_.model_bytes = memory_for_models(options_.memory_bytes, header_, options_.sample,
                                             options_.threads, inputs_.index_bytes);
    if (options_.dry_run) return print_plan(unfinished);
    if (unfinished) look_at_unfinished_run(*unfinished);
    if (!options_.reuse.empty())
      reusable_ = std::make_unique<ReusableRows>(options_.reuse, options_.check, header_);
    if (options_.fresh)
      discard_run(options_.store);
    else if (std::filesystem::exists(options_.store) && (!unfinished || retry_of(*unfinished)))
      require_same_parameters(StoreReader(options_.store, take_check()));
    const bool updates = unfinished && retry_of(*unfinished);
    if (!updates && (unfinished || options_.fresh || !std::filesystem::exists(options_.store))) {
      if (!sample_anew(unfinished)) return exit_stopped;
    }
    return bring_up_to_date(updates ? unfinished : std::nullopt);
  }

 private:
  // The root that the ids of existing rows are relative to. Earlier versions wrote none into the plan of an
  // update, where the root is that of the store.
  std::string earlier_root(const std::optional<RunPlan>& unfinished) const {
    if (unfinished && (!unfinished->root.empty() || !retry_of(*unfinished))) return unfinished->root;
    return remembered_root(options_.store);
  }

  // Chooses the kinds of columns. An existing store keeps its own, whatever its models are now.
  void choose_kinds(const std::optional<RunPlan>& unfinished) {
    if (!has_open_kinds(options_.sample.attributes)) return;
    std::optional<StoreColumns> known;
    if (unfinished)
      known = *unfinished->header.columns;
    else if (!options_.fresh && std::filesystem::exists(options_.store))
      known = StoreReader(options_.store, take_check()).columns();
    choose_attribute_kinds(options_, known ? &*known : nullptr, inputs_.items);
  }

  // Prints what would be done with an existing store.
  void print_update(const std::optional<RunPlan>& unfinished) {
    if (unfinished) {
      require_own_run(*unfinished);
      if (const std::string otherwise = store::first_difference(*unfinished, continued(*unfinished));
          !otherwise.empty())
        throw UsageError(
            fmt::format("`{}.run` was begun otherwise: {} (--fresh begins anew)", options_.store, otherwise));
      fmt::print("an unfinished run of {} would be continued: finished rows are kept\n",
                 counted(unfinished->header.ids.size(), "model"));
      if (!retry_of(*unfinished)) return;  // the run replaces the store, or there is none yet
    }
    if (options_.fresh || !std::filesystem::exists(options_.store)) return;
    const StoreReader store(options_.store, take_check());
    require_same_parameters(store);
    const StoreComparison compared =
        compare_with_inputs(store, inputs_.items, header_, inputs_read_since(options_.store));
    std::uint64_t again = 0;
    const PlannedStore planned = planned_store(plan_of_update(store, compared, options_.retry), inputs_.items,
                                               &store, compared, options_.retry);
    for (const std::optional<std::uint64_t>& row : planned.kept) again += !row.has_value();
    again -= compared.added.size();
    fmt::print("the store has {} of these models: {} would be sampled",
               inputs_.items.size() - compared.added.size(), compared.added.size());
    if (again > 0) fmt::print(", and {} again (--retry)", again);
    fmt::print("\n");
    if (!compared.changed.empty())
      fmt::print(
          "{} changed since they were sampled: {}\n", compared.changed.size(),
          options_.retry.changed ? "they would be sampled again" : "--retry changed samples them again");
    if (!compared.vanished.empty())
      fmt::print("{} of the store are no longer in the input: {}\n", compared.vanished.size(),
                 options_.retry.vanished ? "their rows would be removed" : "their rows would be kept");
  }

  int print_plan(const std::optional<RunPlan>& unfinished) {
    const ItemEstimate estimate = estimate_items(inputs_.items, options_.sample, options_.threads, 0);
    warn_of_unopened(estimate, inputs_.items.size());
    std::uint64_t largest = 0, over = 0;
    for (const PlanItem& item : inputs_.items) {
      largest = std::max(largest, item.reserved_bytes);
      over += item.reserved_bytes > options_.model_bytes;
    }
    fmt::print("{}, {:.1f} MB of input, {} each, about {:.1f} MB of points and their attributes\n",
               counted(inputs_.items.size(), "model"), static_cast<double>(estimate.bytes) * 1e-6,
               counted(header_.samples, "point"),
               static_cast<double>(inputs_.items.size()) * 1e-6 *
                   static_cast<double>(store::row_bytes(header_.columns, header_.samples)));
    fmt::print(
        "largest model needs about {} MiB of the {} MiB that --memory leaves for models; {} would be "
        "too_large\n",
        largest >> 20, options_.model_bytes >> 20, over);
    print_update(unfinished);
    print_notes(inputs_.notes);
    for (const PlanItem& item : inputs_.items)
      fmt::print("{}\t{}\t{} MiB\n", item.id, item.known_format ? "" : "unsupported_format",
                 (item.reserved_bytes + (1 << 20) - 1) >> 20);
    return exit_done;
  }

  // Checks that unfinished work is that of this command, and tries the items that may have killed its
  // process, before anything starts a thread.
  void look_at_unfinished_run(const RunPlan& unfinished) const {
    require_own_run(unfinished);
    try_suspects(planned_store(continued(unfinished), inputs_.items, nullptr, {}, {}),
                 {options_, hook_, {}, nullptr});
  }

  // Throws UsageError when another command began the run, or the inputs were others.
  void require_own_run(const RunPlan& unfinished) const {
    if (!retry_of(unfinished) && unfinished.purpose != RunPurpose::sample &&
        unfinished.purpose != RunPurpose::replace)
      throw UsageError(fmt::format("`{}.run` was begun to {}: repeat the command that began it",
                                   options_.store, purpose_text(unfinished)));
    if (!unfinished.header.ids.empty() && !has_input_of(unfinished))
      throw UsageError(
          fmt::format("`{}.run` was begun with other inputs: its items look like `{}`, those of this command "
                      "like `{}` (give the same INPUT, or --fresh)",
                      options_.store, unfinished.header.ids.front(), inputs_.items.front().id));
    if (!unfinished.root.empty() && unfinished.root != inputs_.root && !has_new_input_of(unfinished))
      throw UsageError(
          fmt::format("`{}.run` was begun with ids relative to `{}`, and none of its new items is in this "
                      "input, whose ids are relative to `{}` (give the same --root and INPUT, or --fresh)",
                      options_.store, unfinished.root, inputs_.root.string()));
  }

  // Whether the input has an item that was to join the store. With another root, the rows of the store may
  // have inputs here by chance or by an earlier root, while the new rows have none.
  bool has_new_input_of(const RunPlan& unfinished) const {
    if (!retry_of(unfinished)) return true;
    const StoreReader store(options_.store, StoreCheck::none);
    RunPlan added;
    for (const std::string& id : unfinished.header.ids)
      if (!store.find(id)) added.header.ids.push_back(id);
    return added.header.ids.empty() || has_input_of(added);
  }

  // Whether the input has an item of the run. Rows whose input is gone become `unreadable`, so that a run
  // ends though files vanish meanwhile; a command without any of them is another one. Both lists ascend.
  bool has_input_of(const RunPlan& unfinished) const {
    auto item = inputs_.items.begin();
    for (const std::string& id : unfinished.header.ids) {
      while (item != inputs_.items.end() && item->id < id) ++item;
      if (item != inputs_.items.end() && item->id == id) return true;
    }
    return false;
  }

  // A process checks the bytes of its store once.
  StoreCheck take_check() { return std::exchange(check_, StoreCheck::none); }

  void require_same_parameters(const StoreReader& store) const {
    if (const std::string otherwise = parameter_mismatch(store, header_); !otherwise.empty())
      throw UsageError(
          fmt::format("`{}` was made with other parameters: {} (--fresh replaces it, or choose another name)",
                      options_.store, otherwise));
    if (!store.label_names().empty() && header_.label_names.empty())
      throw UsageError(
          fmt::format("`{}` has labels, but this command gives none: repeat the option that gave them, or "
                      "replace the store with --fresh",
                      options_.store));
  }

  // The plan that was begun: its items, with the present command's parameters.
  RunPlan continued(const RunPlan& begun) const {
    RunPlan plan{header_, begun.purpose, begun.root, begun.retry};
    plan.header.ids = begun.header.ids;
    plan.header.labels = begun.header.labels;
    plan.header.splits = begun.header.splits;
    plan.header.label_names = begun.header.label_names;
    return plan;
  }

  // Plans an update. It keeps the root, so that a run that is continued from another list finds the same ids.
  RunPlan plan_of_update(const StoreReader& store, const StoreComparison& compared,
                         const RetryOptions& retry) const {
    RunPlan plan = plan_update(store, header_, compared, retry);
    plan.root = inputs_.root.string();
    return plan;
  }

  bool make_store(const PlannedStore& planned, const StoreReader* older) {
    PlannedRunParameters parameters{options_, hook_, {}, older, [&] { write_reports(planned); }};
    if (reusable_)
      parameters.reuse = [this](const auto& content, MeshFormat format) {
        return reusable_->find(content, format);
      };
    if (!make_planned_store(planned, parameters, outcome_)) return false;
    made_ = true;
    check_ = StoreCheck::none;  // this process has just written it
    return true;
  }

  void write_reports(const PlannedStore& planned) {
    made_store_ = std::make_unique<StoreReader>(options_.store, StoreCheck::none);
    outcome_.summary = summarize(*made_store_, true);
    outcome_.root = inputs_.root;
    outcome_.inputs_read_since_unix_ns = std::chrono::nanoseconds(known_since_->time_since_epoch()).count();
    write_run_report(options_, outcome_);
    write_failed_list(options_, outcome_.summary, [&](std::uint64_t row) { return planned.items[row].path; });
  }

  // Makes a new store, or the rest of an unfinished one. False when it was stopped.
  bool sample_anew(const std::optional<RunPlan>& unfinished) {
    const bool replaces = std::filesystem::exists(options_.store);
    if (unfinished) inputs_since_ = std::min(inputs_since_, run_begun(options_.store));
    const RunPlan plan = unfinished ? continued(*unfinished)
                                    : RunPlan{header_, replaces ? RunPurpose::replace : RunPurpose::sample,
                                              inputs_.root.string()};
    known_since_ = inputs_since_;
    if (!unfinished) retry_ = {};  // rows made by this process are not retried
    return make_store(planned_store(plan, inputs_.items, nullptr, {}, {}), nullptr);
  }

  // Compares the finished store with the inputs and samples new items, and those of --retry, until none is
  // left; then reports what the store holds. The loop ends, because only its first round retries rows, and
  // the list of inputs does not change.
  int bring_up_to_date(std::optional<RunPlan> unfinished) {
    for (;;) {
      const std::unique_ptr<StoreReader> opened =
          made_store_ ? std::move(made_store_) : std::make_unique<StoreReader>(options_.store, take_check());
      const StoreReader& store = *opened;
      require_same_parameters(store);
      const auto since = known_since_.value_or(inputs_read_since(options_.store));
      const StoreComparison compared = compare_with_inputs(store, inputs_.items, header_, since);
      const bool has_more_to_do =
          unfinished || !compared.added.empty() || compared.relabeled || !words_of(retry_).empty();
      if (!has_more_to_do) return report(store, compared);
      const RetryOptions retry = unfinished ? *retry_of(*unfinished) : retry_;
      const PlannedStore planned =
          planned_store(unfinished ? continued(*unfinished) : plan_of_update(store, compared, retry),
                        inputs_.items, &store, compared, retry);
      if (!unfinished && is_up_to_date(planned, store, compared)) return report(store, compared);
      if (unfinished) inputs_since_ = std::min(inputs_since_, run_begun(options_.store));
      if (!unfinished || words_of(retry) == words_of(retry_)) retry_ = {};
      unfinished.reset();
      outcome_.added += compared.added.size();
      // Changed rows that are kept must be noticed again the next time.
      known_since_ = compared.changed.empty() || retry.changed ? inputs_since_ : since;
      outcome_.builds.merge(read_run_report(options_.store).builds);  // of the rows that are kept
      if (!make_store(planned, &store)) return exit_stopped;
    }
  }

  static bool is_up_to_date(const PlannedStore& planned, const StoreReader& store,
                            const StoreComparison& compared) {
    return planned.kept.size() == store.rows() && !compared.relabeled &&
           std::all_of(planned.kept.begin(), planned.kept.end(),
                       [](const auto& row) { return row.has_value(); });
  }

  int report(const StoreReader& store, const StoreComparison& compared) {
    if (!made_) {
      outcome_.summary = summarize(store, false);
      tidy_store(options_.store);
    }
    outcome_.inputs = inputs_.notes;
    outcome_.near = [this](const std::string& name) { return near_attributes(name, inputs_.items); };
    for (const std::uint64_t row : compared.changed) outcome_.changed.push_back(store.id(row));
    for (const std::uint64_t row : compared.vanished) outcome_.vanished.push_back(store.id(row));
    print_summary(outcome_, options_);
    return outcome_.exit_code();
  }

  using TimePoint = std::chrono::system_clock::time_point;

  RunOptions& options_;
  const Laboratory* laboratory_;
  const StageHook& hook_;
  // Two seconds earlier, since the times of file systems are coarser than the system clock.
  TimePoint inputs_since_ = std::chrono::system_clock::now() - std::chrono::seconds(2);
  std::optional<TimePoint> known_since_;  // once this process has made the store
  RetryOptions retry_ = options_.retry;   // what is still to be tried again
  StoreCheck check_ = options_.check;
  bool made_ = false;
  // The store that was just made, until it is compared with the inputs.
  std::unique_ptr<StoreReader> made_store_;
  Inputs inputs_;
  StoreHeader header_;
  RunOutcome outcome_;
  std::unique_ptr<ReusableRows> reusable_;
};

}  // namespace

JobFunction add_run_job(Command& program, const Laboratory* laboratory, StageHook hook) {
  auto options = std::make_shared<RunOptions>();
  auto texts = std::make_shared<RunOptionTexts>();
  auto shard = std::make_shared<ShardOptions>();
  const Command command = add_run_command(program, *options, *texts, *shard);
  const auto sample = [options, texts, shard, command, laboratory, hook = std::move(hook)] {
    if (options->store.empty() && options->inputs.size() == 1 &&
        !store_of_array(options->inputs.front()).empty())
      return run_shards(*options, *shard, command, laboratory, hook);
    for (const char* name : {"--shard", "--task", "--shard-offset", "--shards-per-task", "--scratch"})
      if (command.given(name))
        throw UsageError(fmt::format("{} applies to `meander run STORE.run`, after `meander plan`", name));
    if (options->store.empty()) throw UsageError("--output is required");
    resolve_run_options(*options, *texts, laboratory);
    options->sample.rows_only = !options->certify;
    const StageHook whole = [&](GraphStages& stages) {
      if (options->certify) laboratory->add_certificate_stage(stages);
      if (hook) hook(stages);
    };
    return RunJob(*options, laboratory, whole).run();
  };
  return with_failures_option(command.under("Report"), sample);
}

}  // namespace meander
