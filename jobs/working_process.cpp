#include "jobs/working_process.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "jobs/exit_status.h"

namespace meander {

namespace {

// The one thing a signal handler may touch.
std::atomic<bool> stop_requested{false};

extern "C" void on_stop_signal(int) {
  if (stop_requested.exchange(true)) _exit(exit_stopped);
}

}  // namespace

std::atomic<bool>& catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) sigaction(signal, &action, nullptr);
  return stop_requested;
}

void set_allocator_limits(std::uint64_t memory_bytes) {
  const int largest = static_cast<int>(std::clamp<std::uint64_t>(memory_bytes / 128, 1 << 18, 8 << 20));
  mallopt(M_MMAP_THRESHOLD, largest);
  mallopt(M_TRIM_THRESHOLD, 4 * largest);
  mallopt(M_ARENA_MAX, 4);
}

}  // namespace meander
