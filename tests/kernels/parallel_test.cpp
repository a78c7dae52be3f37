// Loops whose result does not depend on the number of threads, alone, nested and with exceptions.
#include "kernels/core/parallel.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_group.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <random>
#include <stdexcept>
#include <thread>

#include "support/catch.h"
#include "support/threads.h"

using namespace meander;

namespace {

constexpr std::size_t count = 5 * parallel_threshold + 123;

// Calls check() with pools of 1, 2 and 8 threads.
template <class Check>
void with_threads(const Check& check) {
  for (const std::size_t threads : {1, 2, 8}) {
    INFO(threads << " threads");
    test::on_threads(threads, check);
  }
}

}  // namespace

TEST_CASE("on_threads: the requested number of threads meet, on a machine with fewer cores too") {
  std::atomic<int> arrived{0};
  test::on_threads(4, [&] {
    parallel_tasks(4, [&](std::size_t) {
      ++arrived;
      for (int i = 0; i < 30000 && arrived < 4; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (arrived < 4) throw std::runtime_error("alone");
    });
  });
  CHECK(arrived == 4);
}

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

TEST_CASE("parallel loops: complete even if the surrounding work is canceled") {
  with_threads([] {
    std::atomic<std::size_t> elements{0}, tasks{0}, bodies{0};
    oneapi::tbb::task_group_context around;
    const auto body = [&] {
      ++bodies;
      around.cancel_group_execution();
      parallel_blocks(count, 1000, [&](std::size_t begin, std::size_t end) { elements += end - begin; });
      parallel_tasks(64, [&](std::size_t) { ++tasks; });
    };
    {
      // TBB orders what is written here before its tasks, and those before its end.
      const TsanLoop loop;
      oneapi::tbb::parallel_for(
          0, 16,
          [&](int) MEANDER_CALLED_BY_TBB {
            const TsanLoop::Task task(loop);
            body();
          },
          around);
    }
    CHECK(bodies > 0);
    CHECK(elements == bodies * count);
    CHECK(tasks == bodies * 64);
  });
}

TEST_CASE("blocked_sum: the same bits for any number of threads") {
  std::mt19937_64 random(1);
  std::vector<double> values(count);
  for (double& value : values) value = static_cast<double>(random()) * 1e-9;
  const double expected = blocked_sum(values);
  with_threads([&] { CHECK(blocked_sum(values) == expected); });
}

TEST_CASE("parallel_tasks: nested loops see what was written before, the caller sees everything") {
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
