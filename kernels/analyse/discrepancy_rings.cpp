#include "kernels/analyse/discrepancy_rings.h"

#include <cmath>
#include <numeric>
#include <stdexcept>

#include "kernels/core/random.h"

namespace meander {

VertexTriangles triangles_around_vertices(std::span<const std::uint32_t> triangles,
                                          std::uint32_t vertex_count) {
  VertexTriangles around;
  around.begin.assign(std::size_t{vertex_count} + 1, 0);
  for (const std::uint32_t v : triangles) {
    if (v >= vertex_count) throw std::invalid_argument("a triangle names a vertex that is not there");
    ++around.begin[v + 1];
  }
  std::partial_sum(around.begin.begin(), around.begin.end(), around.begin.begin());
  around.triangles.resize(triangles.size());
  std::vector<std::uint32_t> next(around.begin.begin(), around.begin.end() - 1);
  for (std::size_t corner = 0; corner < triangles.size(); ++corner)
    around.triangles[next[triangles[corner]]++] = static_cast<std::uint32_t>(corner / 3);
  return around;
}

std::vector<std::uint32_t> ring_seeds(std::span<const std::uint32_t> triangles, std::uint32_t count,
                                      std::uint64_t seed) {
  std::vector<std::uint32_t> seeds;
  if (triangles.empty()) return seeds;
  const RandomKey key = make_random_key(seed, {});
  for (std::uint32_t i = 0; i < count; ++i) {
    const double u = random_pair(key, Stream::test_shapes, i).first;
    seeds.push_back(triangles[static_cast<std::size_t>(u * static_cast<double>(triangles.size()))]);
  }
  return seeds;
}

ShapeDiscrepancy ring_discrepancy(std::span<const std::uint32_t> triangles, const VertexTriangles& around,
                                  std::span<const double> measure, std::span<const std::uint32_t> counts,
                                  std::span<const std::uint32_t> seeds) {
  const std::size_t count = triangles.size() / 3;
  if (measure.size() != count || counts.size() != count)
    throw std::invalid_argument("ring_discrepancy needs a measure and a count of every triangle");
  const std::size_t vertices = around.begin.empty() ? 0 : around.begin.size() - 1;
  for (const std::uint32_t seed : seeds)
    if (seed >= vertices) throw std::invalid_argument("a seed is no vertex");
  const double whole = blocked_sum(measure);
  std::uint64_t samples = 0;
  for (const std::uint32_t c : counts) samples += c;
  if (samples == 0 || !(whole > 0))
    throw std::invalid_argument("ring_discrepancy needs samples and a measure");

  ShapeParameters parameters;
  parameters.shapes = static_cast<std::uint32_t>(seeds.size());
  parameters.stable_rise = 0;
  return max_over_shapes(parameters, [&](std::uint32_t number, double) {
    std::vector<std::uint8_t> vertex_seen(vertices, 0), triangle_seen(count, 0);
    std::vector<std::uint32_t> front = {seeds[number]}, next;
    vertex_seen[front[0]] = 1;
    double inside = 0, most = 0;
    std::uint64_t found = 0;
    while (!front.empty()) {
      next.clear();
      for (const std::uint32_t v : front)
        for (std::uint32_t k = around.begin[v]; k < around.begin[v + 1]; ++k) {
          const std::uint32_t t = around.triangles[k];
          if (triangle_seen[t] != 0) continue;
          triangle_seen[t] = 1;
          inside += measure[t];
          found += counts[t];
          for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t w = triangles[3 * std::size_t{t} + corner];
            if (vertex_seen[w] == 0) next.push_back(w);
            vertex_seen[w] = 1;
          }
        }
      most = std::max(most,
                      std::abs(static_cast<double>(found) / static_cast<double>(samples) - inside / whole));
      front.swap(next);
    }
    return most;
  });
}

}  // namespace meander
