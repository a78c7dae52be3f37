// A small collection of generated files, good and bad, as a user's folder would be.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "kernels/core/status.h"

namespace meander::test {

// Writes about 40 files in class folders below `folder` (created) in all formats: closed, open, tori, soups,
// thin plates, a Moebius strip, and broken ones. Returns the expected status by item id.
std::map<std::string, Status> write_collection(const std::filesystem::path& folder);

}  // namespace meander::test
