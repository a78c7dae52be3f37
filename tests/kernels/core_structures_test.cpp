// The containers of kernels/core.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/radix_heap.h"
#include "kernels/core/random.h"

using namespace meander;

TEST_CASE("radix heap: takes keys out in ascending order while keys are added") {
  RadixHeap heap;
  heap.push(0, 0);
  double last = 0;
  std::uint32_t taken = 0, added = 1;
  while (!heap.empty()) {
    const RadixHeap::Entry entry = heap.pop();
    REQUIRE(entry.key >= last);
    last = entry.key;
    ++taken;
    for (int i = 0; i < 3 && added < 3000; ++i, ++added) {
      const PhiloxBlock words = philox4x32({added, 1, 2, 3}, {4, 5});
      // Equal keys, tiny steps and large steps.
      const double step =
          words[1] % 4 == 0 ? 0.0 : std::ldexp(unit_double(words[2], words[3]), -int(words[1] % 60));
      heap.push(last + step, added);
    }
  }
  CHECK(taken == added);
}

TEST_CASE("disjoint sets: agree with labels that are written anew at every join, and the least represents") {
  constexpr std::uint32_t count = 300;
  DisjointSets sets(count);
  std::vector<std::uint32_t> label(count);
  for (std::uint32_t i = 0; i < count; ++i) label[i] = i;
  for (std::uint32_t step = 0; step < count; ++step) {
    const PhiloxBlock words = philox4x32({step, 0, 0, 0}, {1, 2});
    const std::uint32_t a = words[0] % count, b = words[1] % count;
    const std::uint32_t kept = std::min(label[a], label[b]), gone = std::max(label[a], label[b]);
    CHECK(sets.join(a, b) == (kept != gone));
    for (std::uint32_t& l : label)
      if (l == gone) l = kept;
    bool agree = true;
    for (std::uint32_t i = 0; i < count; ++i)
      agree = agree && sets.find(i) == label[i] && sets.is_representative(i) == (label[i] == i);
    REQUIRE(agree);
  }
}
