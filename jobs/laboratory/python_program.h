// The Python programs of the laboratory: figures, and the plots of other commands.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meander {

// Replaces this process by `python3 -m meander.figures` with these arguments. Throws UsageError if there is
// no Python 3, or no package `meander` beside the program.
[[noreturn]] void become_figures_program(const std::vector<std::string>& arguments);

// The bytes of a plot, SVG or PNG, that matplotlib draws from a JSON object (see figures/plots.py). Throws
// UsageError, which names the missing package, without Python 3 or matplotlib; std::runtime_error if the plot
// cannot be drawn.
std::string draw_plot(std::string_view json);

}  // namespace meander
