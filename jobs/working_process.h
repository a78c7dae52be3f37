// What jobs that work for a long time ask of their process.
#pragma once

#include <atomic>
#include <cstdint>

namespace meander {

// SIGINT, SIGTERM and SIGUSR1 set the flag that is returned; the second of them ends the process at once with
// exit_stopped.
std::atomic<bool>& catch_stop_signals();

// Arrays of models up to 8 MiB come from the heap and are recycled; larger ones go back to the system when
// freed, so that one giant does not stay in the process for the rest of the run. Less where the budget of the
// process is small.
void set_allocator_limits(std::uint64_t memory_bytes);

}  // namespace meander
