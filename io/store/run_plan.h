// What a run was begun with, kept in STORE.run/ so that only the same run is continued: plan.bin (all of it,
// with a checksum) and run.json (for people; its presence says that the folder was completely set up).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "io/store/store.h"

namespace meander {

// What a run is begun for. The numbers are part of the format of plans.
enum class RunPurpose : std::uint8_t { sample, replace, update, describe, merge, surfaces };

// What the run of a STORE.run/ was begun with. Only the same plan is continued.
struct RunPlan {
  StoreHeader header;
  RunPurpose purpose = RunPurpose::sample;
  std::string root = {};   // what the ids of lists are relative to; remembered for the next process
  std::string retry = {};  // of an update: the words of --retry, with commas between them
};

// The purpose of a plan, completing "it was begun to ...".
std::string purpose_text(const RunPlan& plan);

// The plan of STORE.run/; empty when there is no run that was completely set up. Throws RunError(unusable)
// when the plan is damaged or of another version of the program.
std::optional<RunPlan> read_run_plan(const std::filesystem::path& store);

}  // namespace meander

namespace meander::store {

// Writes plan.bin and then run.json, each whole or not at all.
void write_plan(const std::filesystem::path& run_folder, const RunPlan& plan);
bool plan_exists(const std::filesystem::path& run_folder);
// Throws RunError(unusable) when the plan is damaged, or was written by another version.
RunPlan read_plan(const std::filesystem::path& run_folder);
// The same of a shard of an array; also as the version before journals of 4096 rows wrote it.
RunPlan read_plan_of_shard(const std::filesystem::path& folder);
// Throws RunError(unusable) when the plan is damaged or differs; the message names the first difference.
void require_same_plan(const std::filesystem::path& run_folder, const RunPlan& plan);
// One sentence on the first difference, empty when there is none.
std::string first_difference(const RunPlan& begun, const RunPlan& now);

}  // namespace meander::store
