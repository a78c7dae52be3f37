// The exit codes of the program, which --help lists too.
#pragma once

namespace meander {

enum ExitStatus : int {
  exit_done = 0,         // everything was done
  exit_internal = 1,     // a bug in Meander
  exit_usage = 2,        // wrong options, or the job cannot start
  exit_some_failed = 3,  // finished, but some items failed
  exit_stopped = 75,     // stopped early; the same command continues (EX_TEMPFAIL)
};

}  // namespace meander
