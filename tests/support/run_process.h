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

}  // namespace meander::test
