#include "kernels/solve/surface_laplacian.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/core/vector3.h"

namespace meander {

IntrinsicSurface intrinsic_component(const PreparedMesh& mesh, const Component& component) {
  IntrinsicSurface surface;
  const std::uint32_t begin = 3 * component.triangle_begin, end = 3 * component.triangle_end;
  surface.vertex_count = component.vertex_end - component.vertex_begin;
  for (std::uint32_t h = begin; h < end; ++h) {
    const std::uint32_t from = mesh.triangles[h], to = mesh.triangles[next_half_edge(h)];
    const std::uint32_t other = mesh.opposite[h];
    surface.triangles.push_back(from - component.vertex_begin);
    surface.opposite.push_back(other == no_index ? no_index : other - begin);
    // The operands are the same on both sides of an edge.
    surface.length.push_back(distance(mesh.position(std::min(from, to)), mesh.position(std::max(from, to))));
  }
  return surface;
}

GraphMatrix surface_laplacian(const IntrinsicSurface& surface, std::span<const double> half_cotangent) {
  GraphMatrix laplacian;
  laplacian.graph.begin.assign(surface.vertex_count + 1, 0);
  laplacian.diagonal.assign(surface.vertex_count, 0);
  auto& begin = laplacian.graph.begin;
  for_each_edge(surface, half_cotangent, [&](std::uint32_t a, std::uint32_t b, double weight) {
    ++begin[a + 1];
    ++begin[b + 1];
    laplacian.diagonal[a] += weight;
    laplacian.diagonal[b] += weight;
  });
  for (std::size_t v = 0; v < surface.vertex_count; ++v) begin[v + 1] += begin[v];
  laplacian.graph.neighbors.resize(begin.back());
  laplacian.values.resize(begin.back());
  std::vector<std::uint32_t> cursor(begin.begin(), begin.end() - 1);
  for_each_edge(surface, half_cotangent, [&](std::uint32_t a, std::uint32_t b, double weight) {
    laplacian.graph.neighbors[cursor[a]] = b;
    laplacian.values[cursor[a]++] = -weight;
    laplacian.graph.neighbors[cursor[b]] = a;
    laplacian.values[cursor[b]++] = -weight;
  });
  return laplacian;
}

void factorize_laplacian(SparseCholesky& factor, const UnknownGraph& graph, std::span<const double> values,
                         std::span<const double> diagonal, std::span<const std::uint32_t> order,
                         const CancelToken& cancel) {
  double mean = 0;
  for (const double d : diagonal) mean += std::abs(d) / static_cast<double>(diagonal.size());
  for (const double raise : {0.0, 1e-12, 1e-9, 1e-6}) {
    std::vector<double> raised(diagonal.begin(), diagonal.end());
    for (double& d : raised) d += raise * (std::abs(d) + mean);
    factor.factorize(graph, values, raised, order, cancel);
    if (factor.succeeded()) return;
  }
  throw ItemError(Status::internal, "the Laplacian of a component could not be factorized");
}

}  // namespace meander
