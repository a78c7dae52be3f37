#include "jobs/run/shard_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/file/folder_lock.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/run_report.h"
#include "jobs/rows/laboratory.h"
#include "jobs/rows/memory_budget.h"
#include "jobs/rows/planned_run.h"
#include "jobs/run/array_plan.h"
#include "jobs/run/reusable_rows.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

// "3/64" of an array of 64.
std::size_t shard_in(const std::string& text, std::size_t shards) {
  const StoreShard shard = parse_shard(text);
  if (shard.count != shards)
    throw UsageError(fmt::format("--shard: the plan has {} shards, not {}", shards, shard.count));
  return static_cast<std::size_t>(shard.number);
}

void copy_file(const fs::path& from, const fs::path& to) {
  const FileDescriptor source = open_file(from, O_RDONLY);
  AtomicFile copy(to, FullDisk::stops_run);
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  for (std::uint64_t at = 0;;) {
    const std::size_t count = read_at(source, buffer, at, from);
    if (count == 0) break;
    copy.append(std::span<const std::byte>(buffer).first(count));
    at += count;
  }
  copy.commit();
}

void remove_scratch_store(const std::string& store) {
  tidy_store(store);
  fs::remove(store);
}

// The common part of all shards of a task.
struct ArrayTask {
  std::string store;
  RunArray array;
  RunOptions options;  // those of the plan, with the budgets of the task
  std::string scratch;
  StageHook stages;
  std::unique_ptr<ReusableRows> reusable = nullptr;  // opened by the first shard that needs it
};

// The memory of the listings of the archives.
std::uint64_t index_bytes(std::span<const PlanItem> items) {
  std::set<const Archive*> archives;
  for (const PlanItem& item : items)
    for (const Archive* a = item.packed.archive.get(); a != nullptr; a = a->outer().get()) archives.insert(a);
  std::uint64_t bytes = 0;
  for (const Archive* archive : archives) bytes += archive->index_bytes();
  return bytes;
}

// A shard in work. The object holds its lock, so that no other process works on it.
class ShardRun {
 public:
  ShardRun(ArrayTask& task, std::size_t number)
      : task_(task),
        number_(number),
        result_(shard_store(task.store, number).string()),
        lock_(lock_folder(shard_folder(task.store, number), "lock", false)) {
    if (is_done()) return;
    RunPlan plan = read_shard_plan(task.store, number);
    const std::vector<PlanItem> items = read_shard_items(shard_folder(task.store, number), plan.header);
    options_ = task.options;
    options_.store = store_in_work(task, number);
    options_.model_bytes = memory_for_models(options_.memory_bytes, plan.header, options_.sample,
                                             options_.threads, index_bytes(items));
    planned_ = planned_store(std::move(plan), items, nullptr, {}, {});
  }
  ShardRun(const ShardRun&) = delete;
  ShardRun& operator=(const ShardRun&) = delete;

  // The last step removes the run beside the result.
  bool is_done() const { return rows() == 0 || (fs::exists(result_) && !fs::exists(result_ + ".run")); }

  // Tries items that may have killed an earlier process; called before this process starts a thread.
  void try_earlier_suspects() {
    if (!is_done() && read_run_plan(options_.store))
      try_suspects(planned_, {options_, task_.stages, {}, nullptr});
  }

  // Whether an earlier process began the shard and did not finish it.
  static bool was_begun(const ArrayTask& task, std::size_t number) {
    return fs::exists(store_in_work(task, number) + ".run");
  }

  // False when it was stopped.
  bool run(bool json) {
    if (is_done()) {
      tidy_store(result_);
      if (!task_.scratch.empty()) remove_scratch_store(store_in_work(task_, number_));
      say(json, read_shard_report(task_.store, number_).value_or(report_of(rows(), 0)), true);
      return true;
    }
    const auto start = std::chrono::steady_clock::now();
    PlannedRunParameters parameters{options_, task_.stages, {}, nullptr};
    if (!options_.reuse.empty()) {
      if (!task_.reusable)
        task_.reusable = std::make_unique<ReusableRows>(options_.reuse, options_.check, planned_.plan.header);
      parameters.reuse = [this](const auto& content, MeshFormat format) {
        return task_.reusable->find(content, format);
      };
    }
    ShardReport report;
    const auto write_report = [&](StoreCheck check) {
      report = report_of(rows(), summarize(StoreReader(options_.store, check), false).failed());
      report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      report.threads = options_.threads;
      report.ended_unix_time = std::time(nullptr);
      std::array<char, 256> host{};
      if (::gethostname(host.data(), host.size() - 1) == 0) report.host = host.data();
      report.build = build_text();
      write_shard_report(task_.store, number_, report);
    };
    parameters.finished = [&] { write_report(StoreCheck::none); };
    RunOutcome outcome;
    // A finished store in the scratch folder only has to be copied.
    if (is_made())
      write_report(StoreCheck::every_byte);
    else if (!make_planned_store(planned_, parameters, outcome))
      return false;
    if (options_.store != result_) {
      copy_file(options_.store, result_);
      remove_scratch_store(options_.store);
    }
    say(json, report, false);
    return true;
  }

 private:
  bool is_made() const { return fs::exists(options_.store) && !fs::exists(options_.store + ".run"); }

  std::uint64_t rows() const { return task_.array.shards[number_].rows(); }

  static ShardReport report_of(std::uint64_t rows, std::uint64_t failed) {
    ShardReport report;
    report.rows = rows;
    report.failed = failed;
    return report;
  }

  // The store in which the rows are gathered; in a scratch folder it has a name that no other array uses.
  static std::string store_in_work(const ArrayTask& task, std::size_t number) {
    const fs::path result = shard_store(task.store, number);
    if (task.scratch.empty()) return result.string();
    const std::string path = fs::weakly_canonical(result).string();
    const auto digest = sha256(std::as_bytes(std::span(path)));
    const std::string name = hex_text(std::span(digest).first(8));
    return (fs::path(task.scratch) / fmt::format("meander-{}-shard-{:06}.h5", name, number)).string();
  }

  void say(bool json, const ShardReport& report, bool before) const {
    if (json) {
      fmt::print(
          "{{\"shard\":{},\"shards\":{},\"rows\":{},\"failed\":{},\"seconds\":{:.3f},\"done_before\":{}}}\n",
          number_, task_.array.shards.size(), rows(), report.failed, report.seconds, before);
      return;
    }
    fmt::print("shard {} of {}: {}, {} failed{}\n", number_, task_.array.shards.size(),
               counted(rows(), "model"), report.failed,
               before ? ", done before" : fmt::format(", {:.2f} s", report.seconds));
  }

  ArrayTask& task_;
  const std::size_t number_;
  const std::string result_;
  FileDescriptor lock_;
  RunOptions options_;
  PlannedStore planned_;
};

// Refuses all options that the plan has decided.
void refuse_other_options(const Command& command, const std::string& run_folder) {
  constexpr std::array<std::string_view, 11> allowed = {
      "INPUT",     "--shard",  "--task",     "--shard-offset", "--shards-per-task", "--scratch",
      "--threads", "--memory", "--progress", "--json",         "--max-failures"};
  if (command.given("--allow-failures"))
    throw UsageError("--allow-failures: a shard ends with 0 although models failed; leave it out");
  for (const std::string& name : command.all_given())
    if (std::find(allowed.begin(), allowed.end(), name) == allowed.end())
      throw UsageError(fmt::format("{} is decided by the plan of `{}`: leave it out", name, run_folder));
}

TaskNumber task_of(const ShardOptions& which, std::size_t shards) {
  if (which.task.empty()) {
    const TaskNumber task = task_of_environment();
    if (task.variable.empty())
      throw UsageError(
          fmt::format("one of the {} shards must be named: give --shard i/{}, or start an array of tasks",
                      shards, shards));
    return task;
  }
  const auto number = number_in(which.task);
  if (!number) throw UsageError(fmt::format("--task: `{}` is not a number", which.task));
  return {*number, "--task"};
}

std::vector<std::size_t> shards_of_task(const ShardOptions& which, const RunArray& array) {
  const std::size_t shards = array.shards.size();
  if (!which.shard.empty()) {
    if (which.offset != 0 || which.shards_a_task != 0 || !which.task.empty())
      throw UsageError("--shard names one shard: leave --task, --shard-offset and --shards-per-task out");
    return {shard_in(which.shard, shards)};
  }
  const TaskNumber task = task_of(which, shards);
  const std::uint64_t each = which.shards_a_task == 0 ? array.shards_per_task : which.shards_a_task;
  // Numbers of schedulers are far below; products of larger ones could overflow.
  constexpr std::uint64_t beyond_all = std::uint64_t{1} << 32;
  const std::int64_t group = static_cast<std::int64_t>(std::min(task.number, beyond_all)) + which.offset;
  const std::int64_t first = group * static_cast<std::int64_t>(each);
  if (first < 0 || first >= static_cast<std::int64_t>(shards))
    throw UsageError(fmt::format("{} is {}, but the {} shards are numbered from 0: there is no shard {}",
                                 task.variable, task.number, shards, first));
  std::vector<std::size_t> numbers;
  for (std::size_t s = static_cast<std::size_t>(first); s < std::min<std::size_t>(first + each, shards); ++s)
    numbers.push_back(s);
  fmt::print(stderr, "meander: {} is {}: shard{} {}{} of {}\n", task.variable, task.number,
             numbers.size() > 1 ? "s" : "", first,
             numbers.size() > 1 ? fmt::format(" to {}", numbers.back()) : "", shards);
  return numbers;
}

}  // namespace

TaskNumber task_of_environment() {
  constexpr std::array<const char*, 9> variables = {"SLURM_ARRAY_TASK_ID",
                                                    "PBS_ARRAY_INDEX",
                                                    "PBS_ARRAYID",
                                                    "SGE_TASK_ID",
                                                    "LSB_JOBINDEX",
                                                    "JOB_COMPLETION_INDEX",
                                                    "AWS_BATCH_JOB_ARRAY_INDEX",
                                                    "SLURM_PROCID",
                                                    "OMPI_COMM_WORLD_RANK"};
  for (const char* name : variables) {
    const char* const text = std::getenv(name);
    if (text == nullptr) continue;
    // Outside of an array, SGE has "undefined" here, and LSF 0, while its arrays begin at 1.
    const auto number = number_in(text);
    if (!number || (std::string_view(name) == "LSB_JOBINDEX" && *number == 0)) continue;
    return {*number, name};
  }
  return {};
}

int run_shards(const RunOptions& given, const ShardOptions& which, const Command& command,
               const Laboratory* laboratory, const StageHook& hook) {
  const std::string store = store_of_array(given.inputs.front());
  refuse_other_options(command, given.inputs.front());
  RunOptions budgets = given;
  resolve_work_options(budgets);
  ArrayTask task;
  task.store = store;
  task.array = *read_run_array(store);
  task.scratch = which.scratch;
  const std::vector<std::size_t> numbers = shards_of_task(which, task.array);
  task.options = planned_options(task.array, read_shard_plan(store, numbers.front()).header, laboratory);
  task.options.fresh = task.options.json = false;
  task.options.threads = budgets.threads;
  task.options.memory_bytes = budgets.memory_bytes;
  task.options.progress = budgets.progress;
  task.options.max_failures = budgets.max_failures;
  task.stages = [&](GraphStages& stages) {
    if (task.options.certify) laboratory->add_certificate_stage(stages);
    if (hook) hook(stages);
  };
  // One shard is open at a time: a task may have more shards than a process may have open files.
  for (const std::size_t number : numbers)
    if (ShardRun::was_begun(task, number)) ShardRun(task, number).try_earlier_suspects();
  for (const std::size_t number : numbers)
    if (!ShardRun(task, number).run(given.json)) return exit_stopped;
  return exit_done;
}

}  // namespace meander
