#include "jobs/run/array_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/utf8.h"
#include "jobs/cli/usage_error.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

// At the time limit Slurm signals the shell, which passes the signal on; a command in the foreground would be
// orphaned. Exit code 75 means again, every other one is final. A canceled task gets the same signal, but
// Slurm no longer counts it as running, so it is not put back into the queue.
constexpr const char* slurm_script = R"script(#!/bin/bash
#SBATCH --job-name=meander
#SBATCH --array=0-@LAST@
#SBATCH --requeue --open-mode=append
#SBATCH --signal=B:TERM@60
# @SHARDS@ shards, @EACH@ a task.
program=@PROGRAM@
store=@STORE@
trap 'kill -TERM $pid 2>/dev/null' TERM
"$program" run "$store.run" --shards-per-task @EACH@ --progress plain & pid=$!
wait $pid; rc=$?
while [ $rc -gt 128 ] && kill -0 $pid 2>/dev/null; do wait $pid; rc=$?; done
if [ $rc = 75 ] || [ $rc -gt 128 ]; then
  PATH="${PATH:+$PATH:}/usr/local/bin:/usr/bin:/bin"
  [ "${SLURM_RESTART_COUNT:-0}" -lt 3 ] && [ "$(squeue -h -j "$SLURM_JOB_ID" -o %T)" = RUNNING ] &&
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit $rc
)script";

// The paths are passed in variables: in its command line parallel would replace {} and interpret line ends.
constexpr const char* parallel_script = R"script(#!/bin/sh
# One task at a time on each machine; `--sshloginfile hosts.txt` uses several. Run it again to continue.
# It needs GNU parallel, and nothing else. @SHARDS@ shards, @EACH@ a task.
PATH="${PATH:+$PATH:}/usr/local/bin:/usr/bin:/bin" PARALLEL_SHELL=/bin/sh
program=@PROGRAM@
store=@STORE@
export PATH PARALLEL_SHELL program store
task=0
while [ $task -le @LAST@ ]; do echo $task; task=$((task + 1)); done |
  parallel --jobs 1 --retries 3 --env program --env store \
    '"$program" run "$store.run" --task {} --shards-per-task @EACH@ --progress none' &&
  "$program" merge "$store.run"
)script";

constexpr const char* kubernetes_script =
    R"script(# The image has the program, and the volume the data, under the paths that they have here.
# @SHARDS@ shards, @EACH@ a task.
apiVersion: batch/v1
kind: Job
metadata:
  name: meander
spec:
  completions: @TASKS@
  parallelism: 16
  completionMode: Indexed
  backoffLimit: 100
  template:
    spec:
      restartPolicy: OnFailure
      terminationGracePeriodSeconds: 60
      containers:
        - name: meander
          image: meander
          command: [@PROGRAM@, "run", @RUN@, "--shards-per-task", "@EACH@", "--progress", "plain"]
          volumeMounts:
            - {name: data, mountPath: /data}
      volumes:
        - name: data
          persistentVolumeClaim: {claimName: data}
)script";

struct Scheduler {
  const char* name;
  const char* script;
  std::string (*word)(const std::string&);
};

constexpr std::array<Scheduler, 3> schedulers = {{{"slurm", slurm_script, shell_word},
                                                  {"parallel", parallel_script, shell_word},
                                                  {"kubernetes", kubernetes_script, kubernetes_word}}};

// Fills all values in by one pass, since a path may contain the name of a value.
std::string filled(std::string_view text,
                   const std::vector<std::pair<std::string_view, std::string>>& values) {
  std::string result;
  while (!text.empty()) {
    const auto value = std::find_if(values.begin(), values.end(),
                                    [&](const auto& named) { return text.starts_with(named.first); });
    if (value == values.end()) {
      result += text.front();
      text.remove_prefix(1);
    } else {
      result += value->second;
      text.remove_prefix(value->first.size());
    }
  }
  return result;
}

}  // namespace

std::vector<std::string> script_schedulers() {
  std::vector<std::string> names;
  for (const Scheduler& scheduler : schedulers) names.emplace_back(scheduler.name);
  return names;
}

std::string array_script(const std::string& scheduler, const ArrayScript& run) {
  const std::uint64_t tasks = (run.shards + run.shards_per_task - 1) / run.shards_per_task;
  for (const Scheduler& one : schedulers)
    if (one.name == scheduler)
      return filled(one.script, {{"@PROGRAM@", one.word(run.program.string())},
                                 {"@STORE@", one.word(run.store.string())},
                                 {"@RUN@", one.word(run.store.string() + ".run")},
                                 {"@SHARDS@", std::to_string(run.shards)},
                                 {"@EACH@", std::to_string(run.shards_per_task)},
                                 {"@TASKS@", std::to_string(tasks)},
                                 {"@LAST@", std::to_string(tasks - 1)}});
  throw UsageError(fmt::format("--emit: there is no script for `{}`", scheduler));
}

fs::path running_program() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  if (error || !fs::is_regular_file(path, error))
    throw UsageError(fmt::format("--emit: the path of this program is not known: {}",
                                 error ? error.message() : path.string()));
  return path;
}

std::string shell_word(const std::string& text) {
  const auto is_plain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           std::string_view("/._-+@%:,").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), is_plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string kubernetes_word(const std::string& text) {
  std::string word = "\"";
  for (std::string_view rest(text); !rest.empty();) {
    const std::size_t bytes = utf8_sequence_length(rest);
    if (bytes == 0)
      throw UsageError(fmt::format("--emit kubernetes: `{}` is not UTF-8 and cannot be named there", text));
    const std::string_view one = rest.substr(0, bytes);
    rest.remove_prefix(bytes);
    // YAML does not keep control characters, and the characters that it counts as line ends, as they are.
    const unsigned char first = static_cast<unsigned char>(one.front());
    if (bytes == 1 && (first < 0x20 || first == 0x7F))
      word += fmt::format("\\u{:04X}", first);
    else if (bytes == 2 && first == 0xC2 && static_cast<unsigned char>(one[1]) < 0xA0)
      word += fmt::format("\\u{:04X}", static_cast<unsigned char>(one[1]));
    else if (one == "\xE2\x80\xA8" || one == "\xE2\x80\xA9")
      word += one == "\xE2\x80\xA8" ? "\\u2028" : "\\u2029";
    else if (one == "\"" || one == "\\")
      word += "\\" + std::string(one);
    else
      word += one == "$" ? "$$" : std::string(one);
  }
  return word + "\"";
}

}  // namespace meander
