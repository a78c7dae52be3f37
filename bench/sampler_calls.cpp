// The loop in C++ that bench/python_calls.py is compared with: the same mesh, the same parameters, one
// thread.
//
// sampler_calls ROWS COLUMNS SAMPLES CALLS       prints the fastest of three rounds in processor seconds
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "kernels/public/sampler.h"

using namespace meander;

namespace {

struct Arrays {
  std::vector<double> positions;
  std::vector<std::uint32_t> faces;
};

Arrays torus(std::uint32_t rows, std::uint32_t columns) {
  constexpr double two_pi = 6.283185307179586;
  Arrays mesh;
  for (std::uint32_t i = 0; i < rows; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const double a = two_pi * i / rows, b = two_pi * j / columns, r = 1 + 0.5 * std::cos(b);
      mesh.positions.insert(mesh.positions.end(), {r * std::cos(a), r * std::sin(a), 0.5 * std::sin(b)});
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % rows * columns + j % columns; };
  for (std::uint32_t i = 0; i < rows; ++i)
    for (std::uint32_t j = 0; j < columns; ++j)
      mesh.faces.insert(mesh.faces.end(),
                        {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
  return mesh;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "sampler_calls ROWS COLUMNS SAMPLES CALLS\n");
    return 2;
  }
  const auto number = [&](int i) { return static_cast<std::uint32_t>(std::strtoul(argv[i], nullptr, 10)); };
  const Arrays mesh = torus(number(1), number(2));
  const std::uint32_t calls = number(4);
  const Sampler sampler({{"samples", number(3)}});
  double best = HUGE_VAL;
  oneapi::tbb::task_arena(1).execute([&] {
    for (int round = 0; round < 3; ++round) {
      const std::clock_t start = std::clock();
      for (std::uint32_t call = 0; call < calls; ++call) {
        const std::array<std::uint8_t, 32> content = {static_cast<std::uint8_t>(call),
                                                      static_cast<std::uint8_t>(call >> 8)};
        if (sampler.sample({mesh.positions, mesh.faces}, content).report.status != Status::ok) std::abort();
      }
      best = std::min(best, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
  });
  std::printf("%.6f\n", best);
  return 0;
}
