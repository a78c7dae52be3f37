// The entry point of libFuzzer for one target, MEANDER_FUZZ_TARGET. An exception that leaves it ends the
// process, which is how a finding is reported.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  meander::fuzz::MEANDER_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
