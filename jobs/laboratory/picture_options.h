// Options of all pictures of models.
#pragma once

#include <string>

#include "jobs/cli/command_line.h"
#include "kernels/core/vector3.h"

namespace meander {

// --up and --view of the commands that draw models.
void add_view_options(Command& command, std::string& up, std::string& view);
// --color of the commands that draw samples: a word of coloring_named.
void add_color_option(Command& command, std::string& color);
// --memory and --threads of the commands that draw models.
void add_drawing_options(Command& command, std::string& memory, int& threads);

// The vector of "x,y,z", three numbers that are not all 0, scaled so that the largest is 1. Throws
// UsageError, which names `option`.
Vector3 parse_direction(const std::string& option, const std::string& text);

// The unit vector of the axis "x", "y" or "z".
Vector3 axis_of(const std::string& name);

// The direction towards the eye: that of the text, or else in front, to the right and above of a model whose
// axis `up` points up. Throws UsageError if it lies along that axis.
Vector3 view_of(const std::string& text, const std::string& up);

}  // namespace meander
