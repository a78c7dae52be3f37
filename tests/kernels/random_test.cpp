#include "kernels/core/random.h"

#include <set>

#include "kernels/core/radix_sort.h"
#include "support/catch.h"

using namespace meander;

TEST_CASE("philox4x32: matches the published test vectors of Random123") {
  CHECK(philox4x32({0, 0, 0, 0}, {0, 0}) == PhiloxBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}) ==
        PhiloxBlock{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        PhiloxBlock{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("unit_double: stays in the half-open unit interval at both ends") {
  CHECK(unit_double(0, 0) == 0.0);
  CHECK(unit_double(0xFFFFFFFF, 0xFFFFFFFF) < 1.0);
}

TEST_CASE("make_random_key: depends on seed and content, and nothing else") {
  const std::uint8_t one[] = {1, 2, 3}, other[] = {1, 2, 4};
  CHECK(make_random_key(1, one) == make_random_key(1, one));
  CHECK_FALSE(make_random_key(1, one) == make_random_key(2, one));
  CHECK_FALSE(make_random_key(1, one) == make_random_key(1, other));
}

TEST_CASE("random_pair: streams and counters do not repeat each other") {
  std::set<double> seen;
  const RandomKey key = make_random_key(7, {});
  for (const Stream stream : {Stream::sequence, Stream::element_key, Stream::element_point})
    for (std::uint64_t index = 0; index < 100; ++index)
      for (std::uint32_t counter = 0; counter < 3; ++counter)
        seen.insert(random_pair(key, stream, index, counter).first);
  CHECK(seen.size() == 900);
}

TEST_CASE("radix_sort: sorts and keeps the order of equal keys") {
  const RandomKey key = make_random_key(3, {});
  for (const std::uint64_t mask : {~std::uint64_t{0}, std::uint64_t{0xF00F}, std::uint64_t{0}}) {
    std::vector<KeyIndex> items, scratch;
    for (std::uint32_t i = 0; i < 5000; ++i) {
      const PhiloxBlock w = random_words(key, Stream::sequence, i);
      items.push_back({(static_cast<std::uint64_t>(w[0]) << 32 | w[1]) & mask, i});
    }
    radix_sort(items, scratch);
    for (std::size_t i = 1; i < items.size(); ++i) {
      REQUIRE(items[i - 1].key <= items[i].key);
      if (items[i - 1].key == items[i].key) REQUIRE(items[i - 1].index < items[i].index);
    }
  }
}
