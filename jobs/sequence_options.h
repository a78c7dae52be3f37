// The option that shapes the sequence `spaced`, shared by `run` and `surface`.
#pragma once

#include <string>
#include <vector>

#include "jobs/command_line.h"
#include "kernels/sample/place_samples.h"

namespace meander {

inline constexpr const char* sequence_help =
    "The sample set: 1-D sets along the order, or spaced, whose places in their strata keep samples apart";

// --spacing; `given` says whether it was.
void add_spacing_option(Command& command, SpacingKind& spacing, bool& given);
// Adds what is wrong with it to the problems.
void check_spacing_option(SequenceKind sequence, bool given, std::vector<std::string>& problems);

}  // namespace meander
