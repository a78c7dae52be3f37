#include "jobs/cli/working_process.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "io/file/pending_files.h"
#include "jobs/cli/exit_status.h"

namespace meander {

namespace {

// The one thing a signal handler may touch.
std::atomic<bool> stop_requested{false};

extern "C" void on_stop_signal(int) {
  if (!stop_requested.exchange(true)) return;
  remove_pending_files();
  _exit(exit_stopped);
}

// The default action follows.
extern "C" void on_last_signal(int signal) {
  remove_pending_files();
  raise(signal);
}

}  // namespace

std::atomic<bool>& catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) sigaction(signal, &action, nullptr);
  return stop_requested;
}

void remove_temporaries_on_signals() {
  struct sigaction action {
  }, present{};
  action.sa_handler = on_last_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1})
    if (sigaction(signal, nullptr, &present) == 0 && present.sa_handler == SIG_DFL)
      sigaction(signal, &action, nullptr);
}

void set_allocator_limits(std::uint64_t memory_bytes) {
  const int largest = static_cast<int>(std::clamp<std::uint64_t>(memory_bytes / 128, 1 << 18, 8 << 20));
  mallopt(M_MMAP_THRESHOLD, largest);
  mallopt(M_TRIM_THRESHOLD, 4 * largest);
  mallopt(M_ARENA_MAX, 4);
}

}  // namespace meander
