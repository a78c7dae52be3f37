// Instruction sets of loops that come in several versions, chosen at run time. Every version gives the same
// bytes.
#pragma once

#include <cstdint>
#include <string_view>

// Stands before a function and names the instructions that the compiler may use in it. It is empty on other
// architectures, where is_available() returns false.
#if defined(__x86_64__)
#define MEANDER_TARGET(instructions) __attribute__((target(instructions)))
#else
#define MEANDER_TARGET(instructions)
#endif
// For what the loops of all versions share: it is compiled into each of them, with its instructions.
#define MEANDER_INLINE __attribute__((always_inline)) inline

namespace meander {

#if defined(__x86_64__)
inline constexpr bool is_x86 = true;
#else
inline constexpr bool is_x86 = false;
#endif

// `scalar` is the baseline of the architecture.
enum class InstructionSet : std::uint8_t { automatic, scalar, avx2, avx512 };
std::string_view name_of(InstructionSet set);
// Whether the processor has these instructions.
bool is_available(InstructionSet set);
// Whether a loop with versions for the baseline and for AVX2 takes the latter.
bool takes_avx2(InstructionSet set);
// Never returns automatic.
InstructionSet best_instruction_set();

}  // namespace meander
