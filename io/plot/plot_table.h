// The values behind a plot as a table.
#pragma once

#include "io/plot/svg_plot.h"
#include "io/table/table.h"

namespace meander {

// What a plot shows, also the values that its picture skips: columns "series", then those named by the labels
// of the axes ("x" and "y" where they have none) and, when any series has error bars, "error". Throws
// std::invalid_argument when x, y or error of a series differ in length.
Table plot_table(const Plot& plot);

}  // namespace meander
