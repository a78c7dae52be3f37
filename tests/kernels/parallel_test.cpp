// Loops whose result does not depend on the number of threads, alone, nested and with exceptions.
#include "kernels/core/parallel.h"

#include <oneapi/tbb/global_control.h>

#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <stdexcept>

using namespace meander;
using oneapi::tbb::global_control;

namespace {

constexpr std::size_t count = 5 * parallel_threshold + 123;

// Calls check() with pools of 1, 2 and 8 threads.
template <class Check>
void with_threads(const Check& check) {
  for (const std::size_t threads : {1, 2, 8}) {
    const global_control control(global_control::max_allowed_parallelism, threads);
    oneapi::tbb::task_arena arena(static_cast<int>(threads));
    INFO(threads << " threads");
    arena.execute(check);
  }
}

}  // namespace

TEST_CASE("parallel_blocks: every element once, in blocks that do not depend on the threads") {
  with_threads([] {
    std::vector<std::uint32_t> visits(count, 0), block_of(count, 0);
    parallel_blocks(count, 1000, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        ++visits[i];
        block_of[i] = static_cast<std::uint32_t>(begin);
      }
    });
    bool right = true;
    for (std::size_t i = 0; i < count; ++i) right = right && visits[i] == 1 && block_of[i] == i / 1000 * 1000;
    CHECK(right);
  });
}

TEST_CASE("blocked_sum: the same bits for any number of threads") {
  std::mt19937_64 random(1);
  std::vector<double> values(count);
  for (double& value : values) value = static_cast<double>(random()) * 1e-9;
  const double expected = blocked_sum(values);
  with_threads([&] { CHECK(blocked_sum(values) == expected); });
}

TEST_CASE("parallel_tasks with loops inside: each task sees what was written before, the caller sees all") {
  with_threads([] {
    constexpr std::size_t tasks = 20;
    std::vector<std::vector<double>> input(tasks), squares(tasks);
    for (std::size_t t = 0; t < tasks; ++t) input[t].assign(parallel_threshold + t, static_cast<double>(t));
    std::vector<double> sums(tasks);
    parallel_tasks(tasks, [&](std::size_t t) {
      squares[t].resize(input[t].size());
      parallel_blocks(input[t].size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) squares[t][i] = input[t][i] * input[t][i];
      });
      sums[t] = blocked_sum(squares[t]);
    });
    for (std::size_t t = 0; t < tasks; ++t)
      CHECK(sums[t] == static_cast<double>(t * t * (parallel_threshold + t)));
  });
}

TEST_CASE("parallel loops: an exception of the body reaches the caller, from a nested loop too") {
  with_threads([] {
    std::vector<std::uint8_t> done(40, 0);
    const auto fail = [&] {
      parallel_tasks(done.size(), [&](std::size_t t) {
        parallel_blocks(2 * parallel_threshold, 512, [&](std::size_t begin, std::size_t) {
          if (t == 7 && begin == 512) throw std::runtime_error("the seventh");
        });
        done[t] = 1;
      });
    };
    CHECK_THROWS_WITH(fail(), "the seventh");
    CHECK(done[7] == 0);
  });
}
