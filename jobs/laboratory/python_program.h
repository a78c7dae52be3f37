// The Python programs of the laboratory: figures, and the plots of other commands.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meander {

// Replaces this process by `python3 -m meander.figures` with these arguments. Throws UsageError where there
// is no Python 3, or no package `meander` beside the program.
[[noreturn]] void become_figures_program(const std::vector<std::string>& arguments);

// The bytes of a plot, as SVG or PNG, that matplotlib draws of a JSON object: see figures/plots.py for what
// it says. Throws UsageError where Python 3 or matplotlib is missing, and says which package has it;
// std::runtime_error where the plot cannot be drawn.
std::string draw_plot(std::string_view json);

}  // namespace meander
