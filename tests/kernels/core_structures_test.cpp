// The containers of kernels/core.
#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/core/disjoint_sets.h"
#include "kernels/core/large_vector.h"
#include "kernels/core/radix_heap.h"
#include "kernels/core/radix_sort.h"
#include "kernels/core/random.h"
#include "kernels/core/ranked_bits.h"
#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

TEST_CASE("radix heap: removes keys in ascending order while keys are added") {
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

TEST_CASE("radix_sort_words: stable by the upper bits, with any number of threads") {
  for (const std::size_t count : {0u, 1u, 1000u, 5000u, 300000u})
    for (const int low_bit : {0, 15, 28, 60, 63}) {
      CAPTURE(count, low_bit);
      std::vector<std::uint64_t> words(count);
      for (std::uint32_t i = 0; i < count; ++i) {
        const PhiloxBlock random = philox4x32({i, 1, 2, 3}, {8, 9});
        // Some digits are the same in all of them, and many words are equal in their upper bits.
        words[i] = std::uint64_t{random[0] % 5000} << 40 | random[1];
      }
      std::vector<std::uint64_t> expected = words;
      std::stable_sort(expected.begin(), expected.end(),
                       [low_bit](std::uint64_t a, std::uint64_t b) { return a >> low_bit < b >> low_bit; });
      for (const std::size_t threads : {1u, 2u, 8u}) {
        std::vector<std::uint64_t> sorted = words, scratch;
        test::on_threads(threads, [&] {
          radix_sort_words(sorted, scratch, low_bit);
          return 0;
        });
        REQUIRE(sorted == expected);
      }
    }
}

TEST_CASE("radix_sort_words: words that two digits leave unsorted are sorted by all digits") {
  for (const std::size_t distinct : {1u, 3u, 4000u}) {  // by their upper bits
    std::vector<std::uint64_t> words(4000);
    for (std::uint32_t i = 0; i < words.size(); ++i)
      words[i] = std::uint64_t{i % distinct} << 40 | philox4x32({i, 1, 2, 3}, {8, 9})[0];
    std::vector<std::uint64_t> expected = words, nearly = words, scratch;
    std::sort(expected.begin(), expected.end());
    if (distinct == 1) CHECK_FALSE(radix::sort_nearly_sorted(nearly, 0, 2 * nearly.size()));
    radix_sort_words(words, scratch, 0);
    CHECK(words == expected);
  }
}

TEST_CASE("fetch_pages: large vectors behave like vectors") {
  constexpr std::size_t many = 3'000'001;  // 24 MB
  std::vector<double> vector = {1, 2};
  resize_large(vector, many);
  CHECK(vector.size() == many);
  CHECK((vector[0] == 1 && vector[1] == 2 && vector[2] == 0 && vector.back() == 0));
  const std::vector<double> next(many, 5);
  vector.resize(3);
  append_large(vector, next);
  CHECK(vector.size() == many + 3);
  CHECK((vector[2] == 0 && vector[3] == 5 && vector.back() == 5));
  assign_large(vector, 2 * many, 7.0);
  CHECK(std::count(vector.begin(), vector.end(), 7.0) == 2 * many);
  fetch_pages(nullptr, 0);
  const auto array = make_large<std::uint64_t>(many);
  std::fill_n(array.get(), many, 9u);
  CHECK(array[many - 1] == 9);
}

TEST_CASE("ranked bits: lookup equals a search in the list, also for absent numbers") {
  for (const std::uint32_t count : {1u, 63u, 64u, 65u, 1000u}) {
    for (const std::uint32_t every : {1u, 2u, 7u, 64u, 2000u}) {
      std::vector<std::uint32_t> numbers;
      for (std::uint32_t i = every / 2; i < count; i += every) numbers.push_back(i);
      REQUIRE(ascend_below(numbers, count));
      const RankedBits bits(numbers, count);
      std::size_t next = 0;
      for (std::uint32_t i = 0; i < count; ++i) {
        const bool is_in = next < numbers.size() && numbers[next] == i;
        CHECK(bits.rank_of(i) == (is_in ? next : RankedBits::none));
        next += is_in;
      }
      CHECK(next == numbers.size());
    }
  }
  CHECK(ascend_below({}, 0));
  const std::vector<std::uint32_t> twice = {1, 1}, back = {2, 1}, past = {1, 3};
  CHECK_FALSE(ascend_below(twice, 3));
  CHECK_FALSE(ascend_below(back, 3));
  CHECK_FALSE(ascend_below(past, 3));
}

TEST_CASE("disjoint sets: agree with relabeling at every join, and the least member represents") {
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
