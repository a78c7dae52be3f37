// How the rows of a store were made, as parameters that make another row alike.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "kernels/model/sample_parameters.h"

namespace meander {

// What `meander run` does with these options ("--method", "conformal", ...). Throws UsageError.
SampleParameters parameters_of_run(const std::vector<std::string>& words);

struct StoredParameters {
  SampleParameters sample;                   // without descriptors
  std::vector<DescribeParameters> describe;  // one descriptor each, in the order of what is wanted
};

// Recovers the settings that a store of meshes and some of its descriptors were made with, and checks them by
// recording them again. Throws UsageError, naming `path`, where this program cannot repeat them (a store of
// parametric surfaces, of tensors from a file, of another version
// whose parameters differ) or does not know a descriptor.
StoredParameters stored_parameters(const StoreReader& store, const std::string& path,
                                   std::span<const DescriptorSchema> wanted);

}  // namespace meander
