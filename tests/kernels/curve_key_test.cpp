#include "kernels/curve/curve_key.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/curve/curve_frames.h"
#include "kernels/curve_reference.h"
#include "support/catch.h"

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

TEST_CASE("hilbert_key_3d: equals Skilling's loops on random cells and at the corners") {
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

namespace {

// Points in the cube, on its faces and beyond, in rows of five floats.
constexpr std::size_t stride = 5;
std::vector<float> strided_points(std::size_t count) {
  const RandomKey key = make_random_key(5, {});
  std::vector<float> points(stride * count);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const double w = 2.4 * random_pair(key, Stream::test_shapes, i).first - 1.2;
    points[i] = i % 17 == 0 ? 0.0f : i % 19 == 0 ? 1.0f : static_cast<float>(w);
  }
  return points;
}

}  // namespace

TEST_CASE("hilbert_keys_3d: equal the keys computed one at a time") {
  for (const std::size_t count : {0u, 1u, 3u, 15u, 16u, 17u, 3001u}) {
    const std::vector<float> points = strided_points(count);
    std::vector<std::uint64_t> keys(count);
    hilbert_keys_3d({points.data(), stride}, keys);
    for (std::size_t i = 0; i < count; ++i) {
      const float* p = &points[stride * i];
      REQUIRE(keys[i] == hilbert_key_3d({double(p[0]), double(p[1]), double(p[2])}));
    }
  }
}

TEST_CASE("coarse_hilbert_keys_3d: the leading bits of the keys of cell centers") {
  for (const std::size_t count : {1u, 7u, 16u, 2999u}) {
    const std::vector<float> points = strided_points(count);
    std::vector<std::uint64_t> keys(count);
    coarse_hilbert_keys_3d({points.data(), stride}, keys);
    for (std::size_t i = 0; i < count; ++i) {
      const auto middle = [&](std::size_t k) {
        const float cell = std::floor((points[stride * i + k] + 1.0f) * 2048.0f);
        return (std::min(std::max(double(cell), 0.0), 4095.0) + 0.5) / 2048 - 1;
      };
      REQUIRE(keys[i] == hilbert_key_3d({middle(0), middle(1), middle(2)}) >> (63 - coarse_key_bits));
    }
  }
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
