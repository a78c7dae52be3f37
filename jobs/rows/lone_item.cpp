#include "jobs/rows/lone_item.h"

#include <oneapi/tbb/global_control.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <optional>
#include <system_error>

namespace meander {

namespace {

using StageName = std::array<char, 64>;

[[noreturn]] void run_in_child(const PlanItem& item, const GraphParameters& parameters,
                               const std::function<void()>& leave, const StageHook& hook, pid_t parent,
                               StageName& entered) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // the child must not outlive a killed run and hold its lock
  if (getppid() != parent) _exit(0);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
  try {
    leave();
    std::optional<EmbreeDevice> device;
    if (casts_rays(parameters.sample)) device.emplace();
    GraphStages stages = sampling_stages(parameters.sample, device ? &*device : nullptr);
    if (hook) hook(stages);
    run_item_alone(item, parameters, stages, [&](std::string_view stage) {
      const std::size_t length = std::min(stage.size(), entered.size() - 1);
      std::memcpy(entered.data(), stage.data(), length);
      entered[length] = 0;
    });
  } catch (...) {  // not a crash: the item throws again in the run, which reports it
  }
  _exit(0);
}

bool is_crash(int signal) {
  return signal == SIGSEGV || signal == SIGBUS || signal == SIGFPE || signal == SIGILL || signal == SIGABRT;
}

}  // namespace

LoneResult try_item_alone(const PlanItem& item, const GraphParameters& parameters,
                          const std::function<void()>& leave, const StageHook& hook) {
  void* shared = mmap(nullptr, sizeof(StageName), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED)
    throw std::system_error(errno, std::generic_category(), "cannot share memory with a child process");
  auto& entered = *new (shared) StageName{};
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) {
    const int error = errno;
    munmap(shared, sizeof(StageName));
    throw std::system_error(error, std::generic_category(), "cannot start a child process");
  }
  if (child == 0) run_in_child(item, parameters, leave, hook, parent, entered);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  LoneResult result;
  if (WIFSIGNALED(status) && is_crash(WTERMSIG(status))) {
    result.crashed = true;
    result.reason = std::string("a process that did nothing but this item died of ") +
                    strsignal(WTERMSIG(status)) + " (signal " + std::to_string(WTERMSIG(status)) + ") in " +
                    (entered[0] ? entered.data() : "its start");
  }
  munmap(shared, sizeof(StageName));
  return result;
}

}  // namespace meander
