// A matrix of shares with named rows and columns as a picture: confusion of classes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/plot/colour.h"
#include "kernels/render/rgb_image.h"

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

// The same as pixels, with text in the font of the system (text_painter.h). Cells are 36 pixels for up to 44
// rows or columns, and less for more, so that the matrix stays below 1,600 pixels (1 pixel a cell at most
// 4,096 of them). Numbers need cells of 20 pixels, names cells of 8. Throws std::invalid_argument as
// svg_matrix, and for more than 4,096 rows or columns.
RgbImage matrix_image(const NamedMatrix& matrix);

// The colour of a share in [0, 1], from white to a dark blue, linear in sRGB: a small share still leaves a
// mark. And that of a number on it.
Rgb share_colour(double share);
Rgb share_text_colour(double share);

}  // namespace meander
