// The part of STORE.run.json, which a run writes beside its store (run_summary.h), that later commands read.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

namespace meander {

// The compiler, architecture and libraries of this program, in one line.
std::string build_text();

struct RunReport {
  std::string root;  // of the ids of lists; empty: not known
  std::optional<std::chrono::system_clock::time_point> inputs_read_since;
  std::optional<double> describe_milliseconds;  // per model, for all descriptors together
  std::set<std::string> builds;                 // of the programs that made the rows, see build_text
};

// The report of a store. A report that is missing, damaged or not written by Meander is empty, and members of
// another type are ignored: nothing in it is worth an error.
RunReport read_run_report(const std::filesystem::path& store);

}  // namespace meander
