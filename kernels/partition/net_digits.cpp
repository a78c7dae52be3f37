#include "kernels/partition/net_digits.h"

namespace meander {

DigitalShift digital_shift(RandomKey key, std::uint32_t number) {
  DigitalShift shift;
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const PhiloxBlock words = random_words(key, Stream::digital_shift, 3 * number + axis);
    shift.bits[axis] = std::uint64_t{words[0]} << 32 | words[1];
  }
  return shift;
}

}  // namespace meander
