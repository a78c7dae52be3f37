// What a run was begun with, kept in STORE.run/ so that only the same run is continued: plan.bin (all of it,
// with a checksum) and run.json (for people; its presence says that the folder was completely set up).
#pragma once

#include <filesystem>
#include <string>

#include "io/store/store.h"

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
