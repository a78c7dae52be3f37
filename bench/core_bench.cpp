// Random numbers, sorting, sums.
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/core/parallel.h"
#include "kernels/core/radix_sort.h"
#include "kernels/core/random.h"

namespace meander::bench {

namespace {

constexpr std::size_t count = 1 << 16;

void philox(benchmark::State& state) {
  std::vector<double> numbers(2 * count);
  for ([[maybe_unused]] auto _ : state) {
    for (std::size_t i = 0; i < count; ++i) {
      const UnitPair pair = random_pair(bench_key(), Stream::sequence, i);
      numbers[2 * i] = pair.first;
      numbers[2 * i + 1] = pair.second;
    }
    benchmark::DoNotOptimize(numbers.data());
  }
  count_items(state, "pair", count);
  check_sum(state, "", numbers);
}
BENCHMARK(philox);

void radix_sort_keys(benchmark::State& state) {
  std::vector<KeyIndex> keys(count), sorted, scratch;
  for (std::uint32_t i = 0; i < count; ++i) {
    const PhiloxBlock words = random_words(bench_key(), Stream::sequence, i);
    keys[i] = {std::uint64_t{words[0]} << 32 | words[1], i};
  }
  for ([[maybe_unused]] auto _ : state) {
    sorted = keys;
    radix_sort(sorted, scratch);
    benchmark::DoNotOptimize(sorted.data());
  }
  std::vector<std::uint32_t> order;
  for (const KeyIndex& item : sorted) order.push_back(item.index);
  count_items(state, "key", count);
  check_sum(state, "", order);
}
BENCHMARK(radix_sort_keys);

void sum_in_blocks(benchmark::State& state) {
  std::vector<double> values(16 * count), sum(1);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 1.0 / static_cast<double>(i + 1);
  for ([[maybe_unused]] auto _ : state) {
    sum[0] = blocked_sum(values);
    benchmark::DoNotOptimize(sum.data());
  }
  count_items(state, "value", static_cast<double>(values.size()));
  check_sum(state, "", sum);
}
BENCHMARK(sum_in_blocks);

}  // namespace

}  // namespace meander::bench
