// The process: its signals, its allocator, standard output and standard error.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

namespace meander {

// The first SIGINT, SIGTERM or SIGUSR1 sets the flag that is returned; the second ends the process at once
// with exit_stopped.
std::atomic<bool>& catch_stop_signals();

// Has signals that end the process (SIGINT, SIGTERM, SIGHUP, SIGUSR1) first remove the temporary files that
// it is writing. Signals that are ignored stay ignored.
void remove_temporaries_on_signals();

// Keeps freed arrays of up to 32 MiB (a 128th of a budget below 4 GiB) in the heap, where later models use
// them again, and returns larger ones to the system, so that one giant does not stay in the process for the
// rest of the run. Most page faults of the default limits are saved by this; memory pools for
// stages would save no more.
void set_allocator_limits(std::uint64_t memory_bytes);

// Called once, before anything is printed or opened. From then on a reader that goes away
// (`meander info ... | head`) is not a failure: later output is dropped, and the job runs to its end and its
// exit code. Descriptors 0, 1 and 2 that the parent left closed are opened on /dev/null, so that no file of
// the program gets the number that messages are written to.
void prepare_standard_streams();

// The OUTPUT that means standard output.
inline constexpr const char* standard_output = "-";

// Writes bytes to standard output unchanged. flush_standard_output reports failures.
void print_bytes(std::string_view bytes);

// Writes what standard output still buffers. Returns the reason of a failure (a full disk, say), or "".
std::string flush_standard_output();

}  // namespace meander
