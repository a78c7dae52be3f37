// Machine instructions of loops that come in several versions, chosen at run time. The result of such a loop
// is the same bytes with each of them.
#pragma once

#include <cstdint>
#include <string_view>

namespace meander {

enum class InstructionSet : std::uint8_t { automatic, scalar, avx2, avx512 };  // scalar: the baseline
std::string_view name_of(InstructionSet set);
bool is_available(InstructionSet set);  // on the processor that this runs on
InstructionSet best_instruction_set();  // never automatic

}  // namespace meander
