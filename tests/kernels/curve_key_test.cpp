#include "kernels/curve/curve_key.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "kernels/core/random.h"
#include "kernels/curve/curve_frames.h"
#include "kernels/curve_reference.h"

using namespace meander;
using namespace meander::test;

namespace {

// One level a step, by the frame table.
std::uint64_t plane_key(std::uint32_t x, std::uint32_t y) {
  const FrameTable& table = frame_table(CurveKind::hilbert);
  std::uint64_t key = 0;
  std::size_t frame = 0;
  for (int level = 31; level >= 0; --level) {
    const std::uint8_t digit = table.digit_of_cell[frame][(x >> level & 1) + 2 * (y >> level & 1)];
    key = key << 2 | digit;
    frame = table.child_frame[frame][digit];
  }
  return key;
}

}  // namespace

TEST_CASE("hilbert_key_3d: equals Skilling's loops on random cells and on the corners") {
  const RandomKey key = make_random_key(3, {});
  const auto check = [](std::array<std::uint32_t, 3> cell) {
    const auto middle = [](std::uint32_t c) { return (c + 0.5) * 0x1p-20 - 1; };
    CHECK(hilbert_key_3d({middle(cell[0]), middle(cell[1]), middle(cell[2])}) == skilling_key(cell));
  };
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const PhiloxBlock words = random_words(key, Stream::test_shapes, i);
    check({words[0] >> 11, words[1] >> 11, words[2] >> 11});
  }
  for (std::uint32_t corner = 0; corner < 8; ++corner)
    check({(corner & 1) != 0 ? 0x1FFFFFu : 0u, (corner & 2) != 0 ? 0x1FFFFFu : 0u,
           (corner & 4) != 0 ? 0x1FFFFFu : 0u});
}

TEST_CASE("curve_key: Hilbert equals the frame table level by level") {
  const RandomKey key = make_random_key(4, {});
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const PhiloxBlock words = random_words(key, Stream::test_shapes, i);
    CHECK(curve_key(CurveKind::hilbert, words[0] * 0x1p-32, words[1] * 0x1p-32) ==
          plane_key(words[0], words[1]));
  }
  for (const std::uint32_t x : {0u, 0xFFFFFFFFu})
    for (const std::uint32_t y : {0u, 0xFFFFFFFFu})
      CHECK(curve_key(CurveKind::hilbert, x * 0x1p-32, y * 0x1p-32) == plane_key(x, y));
}
