// Bytes that the process holds, counted at malloc and mmap, by any library (Embree and TBB too).
#pragma once

#include <cstdint>

namespace meander::test {

// Whether this build counts: not under sanitizers, which have a malloc of their own.
bool counts_allocations();

// Bytes held now, and the most since reset_peak. Only programs that link allocation_counter.cpp count.
std::int64_t allocated_bytes();
std::int64_t peak_allocated_bytes();
void reset_peak();

}  // namespace meander::test
