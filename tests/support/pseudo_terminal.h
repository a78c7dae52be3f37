// A terminal for a program under test: what it writes there, and how wide it is.
#pragma once

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/run_process.h"

namespace meander::test {

// Runs the program with a terminal of so many columns as `stream` (1 or 2). What it writes there is returned
// instead of out or err, with "\r\n" for line breaks.
inline ProcessResult run_in_terminal(const std::vector<std::string>& arguments, int columns, int stream,
                                     ProcessOptions options = {}) {
  const int keeper = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (keeper < 0 || ::grantpt(keeper) != 0 || ::unlockpt(keeper) != 0)
    throw std::runtime_error("no pseudo-terminal");
  winsize size{};
  size.ws_row = 24;
  size.ws_col = static_cast<unsigned short>(columns);
  ::ioctl(keeper, TIOCSWINSZ, &size);
  // Held open meanwhile, so that the reader meets the end only after the program's.
  const int terminal = ::open(::ptsname(keeper), O_RDWR | O_NOCTTY);
  if (terminal < 0) throw std::runtime_error("no pseudo-terminal");
  options.in_child = [=, before = options.in_child] {
    ::dup2(terminal, stream);
    ::close(terminal);
    ::close(keeper);
    ::unsetenv("COLUMNS");
    ::setenv("TERM", "xterm", 1);
    if (before) before();
  };
  std::string written;
  std::thread reader([&] {
    std::array<char, 4096> buffer;
    for (ssize_t n = 0; (n = ::read(keeper, buffer.data(), buffer.size())) > 0;)
      written.append(buffer.data(), static_cast<std::size_t>(n));
  });
  ProcessResult result = run_process(arguments, options);
  ::close(terminal);
  reader.join();
  ::close(keeper);
  (stream == STDOUT_FILENO ? result.out : result.err) = written;
  return result;
}

}  // namespace meander::test
