// The whole program with failures put into its stages, for tests that need a real process to die or to stop.
// MEANDER_TEST_FAULT is one of
//   segv:ID | abort:ID | kill:ID   dies of that signal in place_samples of the item whose id contains ID
//   stop:ID                        asks its own process to stop there (SIGTERM) and waits until it does
//   hold:PATH                      every item waits in place_samples until the file PATH exists
//   slow:MILLISECONDS              every item takes that long on top (so that kills hit items in flight)
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "jobs/rows/laboratory.h"

namespace {

using meander::GraphItem;

void die_of(int signal) {
  std::signal(signal, SIG_DFL);  // a sanitizer's handler would turn the signal into an exit code
  std::raise(signal);
}

// Until done() or for two minutes: a test that failed leaves no process behind that waits for ever.
void wait_until(const std::function<bool()>& done) {
  for (int i = 0; i < 60000 && !done(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

// However long the signal takes to arrive, the item is dropped: check() throws once the run is canceled.
void stop_process(const GraphItem& item) {
  ::kill(::getpid(), SIGTERM);
  wait_until([&] {
    item.model.cancel.check();
    return false;
  });
}

// What happens to an item before place_samples.
std::function<void(const GraphItem&)> fault_of(const std::string& kind, const std::string& argument) {
  if (kind == "slow")
    return [time = std::chrono::milliseconds(std::stoi(argument))](const GraphItem&) {
      std::this_thread::sleep_for(time);
    };
  if (kind == "hold")
    return [argument](const GraphItem&) { wait_until([&] { return std::filesystem::exists(argument); }); };
  return [kind, argument](const GraphItem& item) {
    if (item.plan->id.find(argument) == std::string::npos) return;
    if (kind == "segv") die_of(SIGSEGV);
    if (kind == "abort") die_of(SIGABRT);
    if (kind == "kill") std::raise(SIGKILL);
    if (kind == "stop") stop_process(item);
  };
}

void add_fault(meander::GraphStages& stages) {
  const char* text = std::getenv("MEANDER_TEST_FAULT");
  if (text == nullptr) return;
  const std::string fault = text;
  const auto happen = fault_of(fault.substr(0, fault.find(':')), fault.substr(fault.find(':') + 1));
  for (meander::GraphStage& stage : stages) {
    if (stage.name != "place_samples") continue;
    stage.body = [body = stage.body, happen](GraphItem& item) {
      happen(item);
      body(item);
    };
  }
}

}  // namespace

int main(int argc, char** argv) {
  return meander::run_program(argc, argv, meander::program_laboratory(), add_fault);
}
