// Samples many meshes with one sampler and several threads. A mesh that cannot be sampled, or takes too long,
// has a status and does not stop the others.
#include <meander/sampler.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

// A pyramid over a polygon. Every seventh is flattened to a line, and every eleventh names a vertex that is
// not there.
meander::SampledModel sample_pyramid(const meander::Sampler& sampler, std::uint32_t number) {
  const std::uint32_t count = 3 + number, apex = number % 11 == 10 ? 999 : 0;
  const double width = number % 7 == 6 ? 0 : 1;
  std::vector<double> positions = {0, 0, width};
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 2 * std::acos(-1.0) * i / count;
    positions.insert(positions.end(), {width * std::cos(angle), std::sin(angle), 0});
    corners.insert(corners.end(), {apex, 1 + i, 1 + (i + 1) % count});
  }
  meander::CancelToken limit;
  limit.deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const std::string name = "pyramid " + std::to_string(number);  // different random numbers for each
  return sampler.sample({positions, corners},
                        {reinterpret_cast<const std::uint8_t*>(name.data()), name.size()}, limit);
}

int main() {
  constexpr std::uint32_t meshes = 40;
  const meander::Sampler sampler({{"samples", 500}});
  std::vector<meander::SampledModel> models(meshes);
  std::atomic<std::uint32_t> next = 0;
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t)
    threads.emplace_back([&] {
      for (std::uint32_t i = next++; i < meshes; i = next++) models[i] = sample_pyramid(sampler, i);
    });
  for (std::thread& thread : threads) thread.join();

  std::size_t points = 0;
  for (std::uint32_t i = 0; i < meshes; ++i) {
    const meander::SampleReport& report = models[i].report;
    points += models[i].samples.count();
    if (report.status != meander::Status::ok)
      std::printf("%u: %s: %s\n", i, std::string(name_of(report.status)).c_str(), report.reason.c_str());
  }
  std::printf("%zu points\n", points);
}
