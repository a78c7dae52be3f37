// Inputs and counters that the kernel benches share.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <span>

#include "kernels/model/model.h"

namespace meander::bench {

// The shapes by number, so that they can be an argument of a bench: 0 and 1 spheres of 5,120 and 81,920
// triangles, 2 a torus (genus 1) of 20,000.
inline constexpr std::int64_t shape_count = 3;
const PolygonMesh& shape(std::int64_t number);
const char* shape_name(std::int64_t number);

// The shape after the stages up to the one named, with the default parameters and `samples` samples; built
// once. Do not change what comes back: copy it.
const Model& prepared_shape(std::int64_t number);
const Model& cut_shape(std::int64_t number);
const Model& flat_shape(std::int64_t number);
// The random key of every bench.
RandomKey bench_key();
SampleParameters bench_parameters(std::uint32_t samples = 2048);
SampleParameters method_parameters(const char* method, std::uint32_t samples);

// Time per item, shown as seconds (n: nano); `items` of one iteration.
void count_items(benchmark::State& state, const char* unit, double items);
// A digest of the result, so that a change of speed can be told from a change of the result. `label` begins
// the label of the line.
void check_sum(benchmark::State& state, const char* label, std::span<const std::byte> bytes);
template <class T>
void check_sum(benchmark::State& state, const char* label, const std::vector<T>& values) {
  check_sum(state, label, std::as_bytes(std::span<const T>(values)));
}

// Registers the bench for every shape.
inline void every_shape(::benchmark::internal::Benchmark* bench) {
  for (std::int64_t number = 0; number < shape_count; ++number) bench->Arg(number);
  bench->Unit(::benchmark::kMillisecond);
}

}  // namespace meander::bench
