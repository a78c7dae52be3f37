// What STORE.run.json, which a run writes beside its store (run_summary.h), tells a later command.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

namespace meander {

// Compiler, architecture and libraries of this program, in one line.
std::string build_text();

struct RunReport {
  std::string root;  // of the ids of lists; empty: not known
  std::optional<std::chrono::system_clock::time_point> inputs_read_since;
  std::optional<double> describe_milliseconds;  // of work on one model, for all descriptors together
  std::set<std::string> builds;                 // what made the rows: see build_text
};

// Nothing here is worth an error: a report that is missing, damaged or not written by Meander says nothing,
// and a member of another type as little.
RunReport read_run_report(const std::filesystem::path& store);

}  // namespace meander
