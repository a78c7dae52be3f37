// Machine instructions of loops that come in several versions, chosen at run time. The result of such a loop
// is the same bytes with each of them.
#pragma once

#include <cstdint>
#include <string_view>

// In front of a function: what the compiler may use in it. On other architectures nothing, where
// is_available() says that nobody is to call it.
#if defined(__x86_64__)
#define MEANDER_TARGET(instructions) __attribute__((target(instructions)))
#else
#define MEANDER_TARGET(instructions)
#endif

namespace meander {

#if defined(__x86_64__)
inline constexpr bool is_x86 = true;
#else
inline constexpr bool is_x86 = false;
#endif

enum class InstructionSet : std::uint8_t { automatic, scalar, avx2, avx512 };  // scalar: the baseline
std::string_view name_of(InstructionSet set);
bool is_available(InstructionSet set);  // on the processor that this runs on
InstructionSet best_instruction_set();  // never automatic

}  // namespace meander
