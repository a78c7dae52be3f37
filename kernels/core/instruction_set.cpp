#include "kernels/core/instruction_set.h"

#include <array>
#include <cstddef>

namespace meander {

std::string_view name_of(InstructionSet set) {
  constexpr std::array<std::string_view, 4> names = {"automatic", "scalar", "avx2", "avx512"};
  return names[static_cast<std::size_t>(set)];
}

bool is_available(InstructionSet set) {
#if defined(__x86_64__)
  switch (set) {
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx512f") != 0;
    case InstructionSet::avx2:
      return __builtin_cpu_supports("avx2") != 0;
    default:
      return true;
  }
#else
  return set == InstructionSet::scalar || set == InstructionSet::automatic;
#endif
}

bool takes_avx2(InstructionSet set) {
  static const bool available = is_available(InstructionSet::avx2);
  return set != InstructionSet::scalar && available;
}

InstructionSet best_instruction_set() {
  if (is_available(InstructionSet::avx512)) return InstructionSet::avx512;
  return is_available(InstructionSet::avx2) ? InstructionSet::avx2 : InstructionSet::scalar;
}

}  // namespace meander
