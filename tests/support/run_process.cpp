#include "support/run_process.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <random>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace meander::test {

namespace {

// A file without a name: output of any length without a pipe that could fill up.
class TemporaryFile {
 public:
  TemporaryFile() : file_(std::tmpfile()) {
    if (file_ == nullptr) throw std::runtime_error("no temporary file");
  }
  ~TemporaryFile() { std::fclose(file_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  int descriptor() const { return fileno(file_); }
  void fill(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), file_);
    std::rewind(file_);
    lseek(descriptor(), 0, SEEK_SET);
  }
  std::string content() {
    std::string text;
    lseek(descriptor(), 0, SEEK_SET);
    std::array<char, 65536> buffer;
    for (ssize_t n = 0; (n = read(descriptor(), buffer.data(), buffer.size())) > 0;)
      text.append(buffer.data(), static_cast<std::size_t>(n));
    return text;
  }

 private:
  std::FILE* file_;
};

}  // namespace

ProcessResult run_process(const std::vector<std::string>& arguments, const ProcessOptions& options) {
  TemporaryFile in, out, err;
  in.fill(options.input);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) {
    dup2(in.descriptor(), STDIN_FILENO);
    dup2(out.descriptor(), STDOUT_FILENO);
    dup2(err.descriptor(), STDERR_FILENO);
    for (const auto& [name, value] : options.environment) setenv(name.c_str(), value.c_str(), 1);
    if (options.in_child) options.in_child();
    execv(argv[0], argv.data());
    _exit(127);
  }
  std::mutex mutex;
  std::condition_variable exited;
  bool has_exited = false;
  std::thread killer;
  if (options.signal_after)
    killer = std::thread([&] {
      std::unique_lock lock(mutex);
      if (!exited.wait_for(lock, *options.signal_after, [&] { return has_exited; }))
        kill(child, options.send_signal);
    });
  // The process id is not reused until the child is reaped below, so a late signal reaches no other process.
  siginfo_t info{};
  waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOWAIT);
  if (killer.joinable()) {
    {
      const std::lock_guard lock(mutex);
      has_exited = true;
    }
    exited.notify_one();
    killer.join();
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  ProcessResult result;
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  result.out = out.content();
  result.err = err.content();
  result.peak_kilobytes = usage.ru_maxrss;
  return result;
}

ProcessResult run_killed(const std::vector<std::string>& arguments, ProcessOptions options,
                         const RandomKills& kills, int exit_code, const std::function<void()>& begin_again) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> moment(static_cast<int>(kills.first.count()),
                                            static_cast<int>(kills.last.count()));
  ProcessResult result;
  options.send_signal = SIGKILL;
  for (int starts = 0, killed = 0; starts < 200; ++starts) {
    options.signal_after.reset();
    if (killed < kills.most) options.signal_after = std::chrono::milliseconds(moment(random));
    result = run_process(arguments, options);
    if (result.signal == SIGKILL) {
      ++killed;
    } else if (killed > 0 && result.exit_code == 75 && result.err.find(" holds ") != std::string::npos) {
      // On a busy machine the lock of a killed run was seen held a moment longer than the run.
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    } else {
      if (killed >= kills.least || result.exit_code != exit_code) return result;
      begin_again();
      killed = 0;
    }
  }
  result = {};
  result.signal = SIGKILL;
  return result;
}

}  // namespace meander::test
