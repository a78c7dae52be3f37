// The whole program with failures put into its stages, for tests that need a real process to die.
//   MEANDER_TEST_FAULT=segv:ID | abort:ID    dies in place_samples of the item whose id contains ID
//   MEANDER_TEST_FAULT=slow:MILLISECONDS     every item takes that long on top (so that kills hit items in
//   flight)
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>

#include "jobs/laboratory.h"

namespace {

void add_fault(meander::GraphStages& stages) {
  const char* text = std::getenv("MEANDER_TEST_FAULT");
  if (text == nullptr) return;
  const std::string fault = text, kind = fault.substr(0, fault.find(':')),
                    argument = fault.substr(fault.find(':') + 1);
  for (meander::GraphStage& stage : stages) {
    if (stage.name != "place_samples") continue;
    stage.body = [body = stage.body, kind, argument](meander::GraphItem& item) {
      if (kind == "slow") std::this_thread::sleep_for(std::chrono::milliseconds(std::stoi(argument)));
      const bool hit = kind != "slow" && item.plan->id.find(argument) != std::string::npos;
      if (hit && kind == "segv") {
        std::signal(SIGSEGV, SIG_DFL);  // a sanitizer's handler would turn the signal into an exit code
        std::raise(SIGSEGV);
      }
      if (hit && kind == "abort") {
        std::signal(SIGABRT, SIG_DFL);
        std::abort();
      }
      body(item);
    };
  }
}

}  // namespace

int main(int argc, char** argv) {
  return meander::run_program(argc, argv, meander::program_laboratory(), add_fault);
}
