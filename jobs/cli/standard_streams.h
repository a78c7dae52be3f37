// Standard output and standard error of the whole program.
#pragma once

#include <string>
#include <string_view>

namespace meander {

// Called once, before anything is printed or opened. A reader that goes away (`meander info ... | head`) is
// no failure from then on: what is printed after that is dropped, and the job goes on to its end and its exit
// code. Descriptors 0, 1 and 2 that the parent left closed are opened on /dev/null, so that no file of the
// program gets the number that messages are written to.
void prepare_standard_streams();

// The OUTPUT that means standard output.
inline constexpr const char* standard_output = "-";

// Bytes as they are. What goes wrong is seen by flush_standard_output.
void print_bytes(std::string_view bytes);

// Writes what is still buffered of standard output. Returns why that failed (a full disk, say), or an empty
// text.
std::string flush_standard_output();

}  // namespace meander
