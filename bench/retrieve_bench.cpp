// Distances between descriptors, and exact search in a base of 100,000 of them.
#include <algorithm>
#include <string>
#include <vector>

#include "bench/bench_shapes.h"
#include "kernels/retrieve/descriptor_distance.h"
#include "kernels/retrieve/nearest_rows.h"

namespace meander::bench {

namespace {

constexpr std::uint32_t bins = 64;
constexpr const char* kind_names[] = {"l1", "l2", "emd", "chi2", "cosine"};

DescriptorBase random_base(std::size_t rows, DistanceKind kind, InstructionSet instructions) {
  std::vector<float> values(rows * bins);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<float>(random_pair(bench_key(), Stream::point_set, i).first / bins);
  const DescriptorBlock block{values, bins};
  return make_descriptor_base({&block, 1}, kind, instructions);
}

// All pairs, one thread or more. Arguments: kind, instructions.
void all_distances(benchmark::State& state) {
  constexpr std::size_t rows = 4096;
  const auto instructions = static_cast<InstructionSet>(state.range(1));
  if (!is_available(instructions)) {
    state.SkipWithError("not on this processor");
    return;
  }
  const DescriptorBase base = random_base(rows, static_cast<DistanceKind>(state.range(0)), instructions);
  std::vector<float> last(rows);
  for ([[maybe_unused]] auto _ : state)
    visit_distances(base, [&](std::size_t, std::span<const float> distances) {
      std::copy(distances.end() - rows, distances.end(), last.begin());
    });
  count_items(state, "pair", static_cast<double>(rows) * rows);
  check_sum(state,
            (std::string(kind_names[state.range(0)]) + " " + std::string(name_of(instructions))).c_str(),
            last);
}
BENCHMARK(all_distances)
    ->ArgsProduct({{0, 1, 2, 3, 4}, {1, 2, 3}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The 10 nearest of 100,000 rows to one row, by l1.
void exact_search(benchmark::State& state) {
  static const DescriptorBase base = random_base(100000, DistanceKind::l1, InstructionSet::automatic);
  std::vector<NearRow> found;
  for ([[maybe_unused]] auto _ : state) found = nearest_rows(base, 77, 10);
  count_items(state, "query", 1);
  check_sum(state, name_of(base.instructions).data(), found);
}
BENCHMARK(exact_search)->Unit(benchmark::kMillisecond)->UseRealTime();

// The 10 nearest to each of 8,192 rows, by l1; items are rows.
void nearest_of_all(benchmark::State& state) {
  static const DescriptorBase base = random_base(8192, DistanceKind::l1, InstructionSet::automatic);
  std::vector<NearRow> found;
  for ([[maybe_unused]] auto _ : state) found = nearest_rows_of_all(base, 10);
  count_items(state, "query", static_cast<double>(base.rows));
  check_sum(state, name_of(base.instructions).data(), found);
}
BENCHMARK(nearest_of_all)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

}  // namespace meander::bench
