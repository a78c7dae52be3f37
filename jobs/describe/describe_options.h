// The options of `meander describe`, and the header of the store that it makes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "jobs/cli/jobs.h"
#include "jobs/cli/settings.h"
#include "jobs/cli/work_options.h"
#include "jobs/inputs/input_options.h"
#include "jobs/rows/descriptor_choice.h"
#include "kernels/describe/describe_samples.h"

namespace meander {

struct DescribeOptions : WorkOptions {
  std::string store, output, descriptors;
  std::vector<std::string> inputs;
  InputOptions collect;  // how the inputs are read
  DescribeParameters describe;
  SettingOptions settings;  // for `describe`
  std::string shard;        // i/n; empty: all rows
  StoreShard rows;          // the same
  bool replace = false, fresh = false;
  StoreCheck check = StoreCheck::every_byte;
};

// Adds the subcommand; its options are written to `options` when the command line is parsed.
Command add_describe_command(Command& program, DescribeOptions& options);

// Resolves the options after parsing. Throws UsageError with every problem.
void resolve_describe_options(DescribeOptions& options);

// Opens the store to be described. Throws UsageError when it is not finished, or when inputs are given for a
// store without meshes; RunError when it is damaged.
std::unique_ptr<StoreReader> open_described_store(const DescribeOptions& options);

// The path of the described store: --output, or that of the store itself.
std::filesystem::path described_output(const DescribeOptions& options);

// Throws UsageError when the output must not be replaced; files_read: the inputs of the command.
void check_described_output(const DescribeOptions& options,
                            std::span<const std::filesystem::path> files_read);

// The header of `store` with the descriptors of this job. Throws UsageError when the store has one of them
// already and it is not to be replaced.
StoreHeader described_header(const StoreReader& store, const DescribeOptions& options);

}  // namespace meander
