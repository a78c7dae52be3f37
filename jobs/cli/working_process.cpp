#include "jobs/cli/working_process.h"

#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "io/file/atomic_file.h"
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
  const int largest = static_cast<int>(std::clamp<std::uint64_t>(memory_bytes / 128, 1 << 18, 32 << 20));
  mallopt(M_MMAP_THRESHOLD, largest);
  mallopt(M_TRIM_THRESHOLD, 4 * largest);
  mallopt(M_ARENA_MAX, 4);
}

namespace {

struct GuardedStream {
  int number;
  bool closed = false;  // its reader is gone
};

ssize_t write_some(void* cookie, const char* data, std::size_t size) {
  auto& to = *static_cast<GuardedStream*>(cookie);
  std::size_t done = 0;
  while (done < size && !to.closed) {
    const ssize_t wrote = ::write(to.number, data + done, size - done);
    if (wrote >= 0) {
      done += static_cast<std::size_t>(wrote);
    } else if (errno == EPIPE) {
      to.closed = true;
    } else if (errno != EINTR) {
      return static_cast<ssize_t>(done);
    }
  }
  return static_cast<ssize_t>(size);
}

// A stream to the same descriptor that ignores a closed pipe; `fallback` when there is no memory for it.
std::FILE* forgiving(GuardedStream& to, std::FILE* fallback, int buffering) {
  const cookie_io_functions_t functions{nullptr, write_some, nullptr, nullptr};
  std::FILE* const stream = ::fopencookie(&to, "w", functions);
  if (stream == nullptr) return fallback;
  std::setvbuf(stream, nullptr, buffering, BUFSIZ);
  return stream;
}

}  // namespace

void prepare_standard_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  // open() takes the lowest free number: 0, 1, 2 in turn.
  for (const int number : {0, 1, 2})
    if (::fcntl(number, F_GETFD) < 0 && errno == EBADF && ::open("/dev/null", O_RDWR) < 0) break;
  static GuardedStream out{STDOUT_FILENO}, error{STDERR_FILENO};
  stdout = forgiving(out, stdout, ::isatty(STDOUT_FILENO) != 0 ? _IOLBF : _IOFBF);
  stderr = forgiving(error, stderr, _IONBF);
}

void print_bytes(std::string_view bytes) {
  // A short count sets the error of the stream.
  static_cast<void>(std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size());
}

std::string flush_standard_output() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return {};
  return std::string("cannot write standard output: ") + std::strerror(errno);
}

}  // namespace meander
