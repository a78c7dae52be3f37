// What jobs that work for a long time ask of their process.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

namespace meander {

// SIGINT, SIGTERM and SIGUSR1 set the flag that is returned; the second of them ends the process at once with
// exit_stopped.
std::atomic<bool>& catch_stop_signals();

// From here on a signal that ends the process (SIGINT, SIGTERM, SIGHUP, SIGUSR1) removes the temporary files
// that it is writing first. Signals that are ignored stay so.
void remove_temporaries_on_signals();

// Arrays of models up to 8 MiB come from the heap and are recycled; larger ones go back to the system when
// freed, so that one giant does not stay in the process for the rest of the run. Less where the budget of the
// process is small. Stages need no memory pools besides: on the 111 meshes of a shape collection this saves
// 85 % (direct) and 64 % (conformal) of the page faults of the default limits, 8 % and 0 % of the CPU time;
// a heap that keeps everything saves no more.
void set_allocator_limits(std::uint64_t memory_bytes);

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
