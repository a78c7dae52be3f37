// The command line of `meander describe`, and the header of the store that it makes.
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
#include "jobs/inputs/input_options.h"
#include "jobs/rows/descriptor_choice.h"
#include "kernels/describe/describe_samples.h"

namespace meander {

struct DescribeOptions {
  std::string store, output, descriptors, memory = "4G", timeout = "120s", progress = "auto";
  std::vector<std::string> inputs;
  InputOptions collect;  // how the inputs are read
  DescribeParameters describe;
  int threads = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t model_bytes = 0;  // of memory_bytes
  double timeout_seconds = 0;
  SettingOptions settings;  // of `describe`
  std::string shard;        // i/n; empty: all rows
  StoreShard rows;          // the same
  bool replace = false, fresh = false, allow_oversize = false, json = false;
  StoreCheck check = StoreCheck::every_byte;
};

// Adds the subcommand; its options are written to `options` when the command line is parsed.
void add_describe_command(Command& program, DescribeOptions& options);

// Parses what the options say in words. Throws UsageError with all that is wrong.
void resolve_describe_options(DescribeOptions& options);

// Opens the store to be described. Throws UsageError where it is not finished, or has no meshes and inputs
// are given; RunError where it is damaged.
std::unique_ptr<StoreReader> open_described_store(const DescribeOptions& options);

// Where the described store goes: --output, or the place of the store itself.
std::filesystem::path described_output(const DescribeOptions& options);

// Throws UsageError when the output must not be replaced; files_read: the inputs of the command.
void check_described_output(const DescribeOptions& options,
                            std::span<const std::filesystem::path> files_read);

// The header of `store` with the descriptors of this job added. Throws UsageError where one is there already
// and is not to be replaced.
StoreHeader described_header(const StoreReader& store, const DescribeOptions& options);

}  // namespace meander
