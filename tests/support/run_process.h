// Running a program as a user does: arguments, output, exit code, signals.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace meander::test {

struct ProcessResult {
  int exit_code = -1;  // -1 when a signal ended it
  int signal = 0;      // the signal that ended it, or 0
  std::string out, err;
  long peak_kilobytes = 0;  // ru_maxrss
};

struct ProcessOptions {
  std::vector<std::pair<std::string, std::string>> environment;  // added to that of the test
  std::optional<std::chrono::milliseconds> signal_after;  // send `send_signal` this long after the start
  int send_signal = 9;
  std::string input;               // standard input
  std::function<void()> in_child;  // between fork and exec, for limits
};

// arguments[0] is the program. Waits until it ends.
ProcessResult run_process(const std::vector<std::string>& arguments, const ProcessOptions& options = {});

// Kills at random moments, `first` to `last` after each start.
struct RandomKills {
  int least, most;
  std::chrono::milliseconds first, last;
};

// Starts a command that continues its work again and again: killed until it ends by itself, and let be after
// `most` kills. Where it ends with `exit_code` before `least` kills, it was faster than they are on this
// machine; then begin_again() removes what it made. The result is that of the last start: a kill when 200
// starts were not enough.
ProcessResult run_killed(const std::vector<std::string>& arguments, ProcessOptions options,
                         const RandomKills& kills, int exit_code, const std::function<void()>& begin_again);

}  // namespace meander::test
