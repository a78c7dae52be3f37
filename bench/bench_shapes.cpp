#include "bench/bench_shapes.h"

#include <array>
#include <cstdio>
#include <string>

#include "support/test_meshes.h"

namespace meander::bench {

namespace {

template <class Build>
const Model& kept(std::array<Model, shape_count>& states, std::int64_t number, const Build& build) {
  Model& state = states.at(static_cast<std::size_t>(number));
  if (state.file.polygon_count() == 0) state = build();
  return state;
}

}  // namespace

const PolygonMesh& shape(std::int64_t number) {
  static const std::array<PolygonMesh, shape_count> shapes = {test::icosphere(4), test::icosphere(6),
                                                              test::torus(200, 50)};
  return shapes.at(static_cast<std::size_t>(number));
}

const char* shape_name(std::int64_t number) {
  static constexpr std::array<const char*, shape_count> names = {"sphere 5k", "sphere 82k", "torus 20k"};
  return names.at(static_cast<std::size_t>(number));
}

RandomKey bench_key() { return make_random_key(1, {}); }

SampleParameters method_parameters(const char* method, std::uint32_t samples) {
  SampleParameters parameters = parameters_for(method);
  parameters.samples = samples;
  return parameters;
}

SampleParameters bench_parameters(std::uint32_t samples) { return method_parameters("conformal", samples); }

const Model& prepared_shape(std::int64_t number) {
  static std::array<Model, shape_count> states;
  return kept(states, number, [&] {
    Model state;
    state.file = shape(number);
    state.key = bench_key();
    charting_stages(method_parameters("direct", 2048)).front().run(state);
    return state;
  });
}

const Model& cut_shape(std::int64_t number) {
  static std::array<Model, shape_count> states;
  return kept(states, number, [&] {
    Model state = prepared_shape(number);
    charting_stages(bench_parameters()).at(2).run(state);
    return state;
  });
}

const Model& flat_shape(std::int64_t number) {
  static std::array<Model, shape_count> states;
  return kept(states, number, [&] {
    Model state = cut_shape(number);
    charting_stages(bench_parameters()).at(3).run(state);
    return state;
  });
}

void count_items(benchmark::State& state, const char* unit, double items) {
  state.counters[std::string("per_") + unit] =
      benchmark::Counter(items, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void check_sum(benchmark::State& state, const char* label, std::span<const std::byte> bytes) {
  std::uint32_t hash = 2166136261u;  // FNV-1a (Fowler, Noll, Vo)
  for (const std::byte byte : bytes) hash = (hash ^ static_cast<std::uint32_t>(byte)) * 16777619u;
  char text[16];
  std::snprintf(text, sizeof text, "%08x", hash);
  state.SetLabel(std::string(label) + (*label == '\0' ? "" : ", ") + text);
}

}  // namespace meander::bench
