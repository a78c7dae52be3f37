// A matrix of shares with named rows and columns as a standalone SVG picture: confusion of classes.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace meander {

struct NamedMatrix {
  std::string title{}, row_label{}, column_label{};  // each may be empty
  std::vector<std::string> rows{}, columns{};
  std::vector<double> values{};  // rows x columns, row by row; drawn from white (0) to dark (1)
};

// Cells get their value in percent when they are large enough for it and it is at least half a percent; long
// names are cut. Values outside [0, 1] are clamped, those that are not finite left white. Same promises about
// the text as svg_plot. O(cells). Throws std::invalid_argument when values do not fit the names.
std::string svg_matrix(const NamedMatrix& matrix);

}  // namespace meander
