// The terminal that a stream may be.
#pragma once

namespace meander {

// Columns to write within: those of the terminal behind the stream (a file descriptor) or the variable
// COLUMNS, the smaller where there are both, and 80 where there is neither. 20 to 120: longer lines are hard
// to read.
int terminal_width(int stream);

}  // namespace meander
