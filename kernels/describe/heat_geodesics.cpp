#include "kernels/describe/heat_geodesics.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/radix_heap.h"
#include "kernels/solve/elimination_order.h"
#include "kernels/solve/intrinsic_delaunay.h"
#include "kernels/solve/intrinsic_disk.h"
#include "kernels/solve/sparse_cholesky.h"
#include "kernels/solve/surface_laplacian.h"

namespace meander {

namespace {

constexpr std::size_t batch_size = geodesic_batch;
constexpr double furthest = 600;  // in sqrt(t): exp(-600) is still a normal double

// A bound on the distance of any two vertices by edges: twice the extent from vertex 0 (Dijkstra 1959).
double extent_bound(const GraphMatrix& laplacian, const IntrinsicSurface& surface) {
  std::vector<double> length(laplacian.values.size());
  std::vector<std::uint32_t> cursor(laplacian.graph.begin.begin(), laplacian.graph.begin.end() - 1);
  for (std::uint32_t h = 0; h < surface.opposite.size(); ++h) {  // the order of surface_laplacian()
    const std::uint32_t other = surface.opposite[h];
    if (other != no_index && other < h) continue;
    const std::uint32_t a = surface.triangles[h], b = surface.triangles[next_half_edge(h)];
    if (a != b) length[cursor[a]++] = length[cursor[b]++] = surface.length[h];
  }
  std::vector<double> reached(surface.vertex_count, std::numeric_limits<double>::infinity());
  RadixHeap queue;
  reached[0] = 0;
  queue.push(0, 0);
  double extent = 0;
  while (!queue.empty()) {
    const auto [d, v] = queue.pop();
    if (d > reached[v]) continue;
    extent = d;
    for (std::uint32_t e = laplacian.graph.begin[v]; e < laplacian.graph.begin[v + 1]; ++e) {
      const std::uint32_t to = laplacian.graph.neighbors[e];
      if (d + length[e] >= reached[to]) continue;
      reached[to] = d + length[e];
      queue.push(reached[to], to);
    }
  }
  return 2 * extent;
}

Vector3 position_in(const PreparedMesh& mesh, std::uint32_t triangle, const std::array<double, 3>& weight) {
  Vector3 p;
  for (std::uint32_t k = 0; k < 3; ++k) p = p + weight[k] * mesh.position(mesh.triangles[3 * triangle + k]);
  return p;
}

std::array<double, 3> weights_of(PointsOnMesh points, std::size_t i) {
  const double b = points.barycentric[2 * i], c = points.barycentric[2 * i + 1];
  return {1 - b - c, b, c};
}

// Mean of phi - distance over vertices beside the source at p: the corners of its triangle, each with less
// weight the nearer p is to it, and the three apexes across its edges, unfolded into its plane. phi at the
// source itself would not do: the heat has rounded that tip off by about h / 3.
template <class Phi>
double source_shift(const PreparedMesh& mesh, std::uint32_t triangle, const std::array<double, 3>& weight,
                    const Phi& phi) {
  const Vector3 p = position_in(mesh, triangle, weight);
  double sum = 0, total = 0;
  const auto add = [&](std::uint32_t vertex, double distance, double share) {
    sum += share * (phi(vertex) - distance);
    total += share;
  };
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t h = 3 * triangle + k, from = mesh.triangles[h];
    const Vector3 start = mesh.position(from);
    add(from, distance(p, start), std::max(1 - weight[k], 0.0));
    const std::uint32_t other = mesh.opposite[h];
    if (other == no_index) continue;
    const std::uint32_t apex = mesh.triangles[previous_half_edge(other)];
    const Vector3 edge = mesh.position(mesh.triangles[next_half_edge(h)]) - start;
    const double length = norm(edge);
    if (!(length > 0)) continue;
    // The coordinates along the edge and away from it, with p on one side and the apex on the other.
    const Vector3 to_p = p - start, to_apex = mesh.position(apex) - start;
    const double along = dot(to_apex - to_p, edge) / length;
    const double away = (norm(cross(to_p, edge)) + norm(cross(to_apex, edge))) / length;
    add(apex, std::sqrt(along * along + away * away), 1.0);
  }
  return sum / total;
}

// Vertex values of one source: its column of a batch of `stride`, with the shift that puts the source at 0.
struct SourceField {
  const PreparedMesh& mesh;
  const Component& component;
  const double* column;  // null: a component without area
  std::size_t stride;
  std::uint32_t triangle;  // of the source
  Vector3 source;          // working units
  double shift = 0;

  bool is_corner(std::uint32_t vertex) const {
    const std::uint32_t* corner = mesh.triangles.data() + 3 * std::size_t{triangle};
    return vertex == corner[0] || vertex == corner[1] || vertex == corner[2];
  }
  // In working units. The straight distance bounds every path from below.
  double at_vertex(std::uint32_t vertex) const {
    const double straight = distance(source, mesh.position(vertex));
    if (column == nullptr || is_corner(vertex)) return straight;
    return std::max(straight, column[stride * (vertex - component.vertex_begin)] - shift);
  }
  double at_point(std::uint32_t target, const std::array<double, 3>& weight) const {
    const double straight = distance(source, position_in(mesh, target, weight));
    if (target == triangle || column == nullptr) return straight;
    double d = 0;
    for (std::uint32_t k = 0; k < 3; ++k) d += weight[k] * at_vertex(mesh.triangles[3 * target + k]);
    return std::max(straight, d);
  }
};

}  // namespace

PointsOnMeshArrays vertices_as_points(const PreparedMesh& mesh, std::span<const std::uint32_t> vertices) {
  std::vector<std::uint32_t> corner(mesh.vertex_count(), no_index);
  for (auto h = static_cast<std::uint32_t>(mesh.triangles.size()); h-- > 0;) corner[mesh.triangles[h]] = h;
  PointsOnMeshArrays points;
  for (const std::uint32_t v : vertices) {
    if (v >= corner.size() || corner[v] == no_index)
      throw std::invalid_argument("vertices_as_points: a vertex that is not there");
    points.triangle.push_back(corner[v] / 3);
    points.barycentric.push_back(corner[v] % 3 == 1 ? 1 : 0);
    points.barycentric.push_back(corner[v] % 3 == 2 ? 1 : 0);
  }
  return points;
}

void check_points_on_mesh(const PreparedMesh& mesh, PointsOnMesh points) {
  if (points.barycentric.size() != 2 * points.count())
    throw std::invalid_argument("geodesics: two barycentric weights a point are needed");
  for (std::size_t i = 0; i < points.count(); ++i) {
    if (points.triangle[i] >= mesh.triangle_count())
      throw std::invalid_argument("geodesics: a point lies in a triangle that is not there");
    for (const double w : weights_of(points, i))
      if (!(w >= -1e-6 && w <= 1 + 1e-6))
        throw std::invalid_argument("geodesics: barycentric weights must lie in [0, 1]");
  }
}

struct HeatGeodesics::Part {
  IntrinsicSurface surface;
  std::vector<double> half_cotangent;  // per half-edge
  std::vector<double> area;            // per triangle
  std::vector<std::uint8_t> on_boundary;
  SparseCholesky heat, heat_held, poisson;  // heat_held: u = 0 on the boundary
  bool has_boundary = false;

  Part(const PreparedMesh& mesh, const Component& component, double time_factor, const CancelToken& cancel)
      : surface(intrinsic_component(mesh, component)) {
    mollify(surface.length);
    make_intrinsic_delaunay(surface, cancel);
    half_cotangent = corner_geometry(surface.length).half_cotangent;
    on_boundary.assign(surface.vertex_count, 0);
    std::vector<double> mass(surface.vertex_count, 0);
    double mean_length = 0;
    for (std::uint32_t t = 0; t < surface.triangle_count(); ++t) {
      const double* l = surface.length.data() + 3 * t;
      const double longest = std::max({l[0], l[1], l[2]});
      area.push_back(std::max(area_from_lengths(l[0], l[1], l[2]), 0.25e-12 * longest * longest));
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        mass[surface.triangles[h]] += area.back() / 3;
        mean_length += surface.length[h];
        if (surface.opposite[h] != no_index) continue;
        has_boundary = true;
        on_boundary[surface.triangles[h]] = on_boundary[surface.triangles[next_half_edge(h)]] = 1;
      }
    }
    mean_length /= static_cast<double>(surface.length.size());
    GraphMatrix laplacian = surface_laplacian(surface, half_cotangent);
    const double reach = extent_bound(laplacian, surface) / furthest;
    const double time = std::max(time_factor * mean_length * mean_length, reach * reach);
    const std::vector<std::uint32_t> order = elimination_order(laplacian.graph);
    cancel.check();

    const std::size_t count = surface.vertex_count;
    std::vector<double> values(laplacian.values.size()), diagonal(count);
    for (std::size_t e = 0; e < values.size(); ++e) values[e] = time * laplacian.values[e];
    for (std::size_t v = 0; v < count; ++v) diagonal[v] = mass[v] + time * laplacian.diagonal[v];
    factorize_laplacian(heat, laplacian.graph, values, diagonal, order, cancel);
    if (has_boundary) {
      for (std::size_t v = 0; v < count; ++v)
        for (std::uint32_t e = laplacian.graph.begin[v]; e < laplacian.graph.begin[v + 1]; ++e)
          if (on_boundary[v] || on_boundary[laplacian.graph.neighbors[e]]) values[e] = 0;
      factorize_laplacian(heat_held, laplacian.graph, values, diagonal, order, cancel);
    }
    // The right-hand side of phi sums to 0, so this pins vertex 0 to 0 and changes nothing else.
    laplacian.diagonal[0] += std::max(laplacian.diagonal[0], 1.0);
    factorize_laplacian(poisson, laplacian.graph, laplacian.values, laplacian.diagonal, order, cancel);
  }

  // Computes -div(-grad u / |grad u|) from u, V x Count each. No embedding is needed: |grad u|^2 = E / area
  // with the Dirichlet energy E of the triangle, and the divergence is the triangle's Laplacian of u over
  // |grad u|.
  template <int Count>
  std::vector<double> normalized_divergence(std::span<const double> u) const {
    using Values = Eigen::Array<double, Count, 1>;
    std::vector<double> right(u.size(), 0);
    for (std::size_t t = 0; t < area.size(); ++t) {
      const std::uint32_t* corner = surface.triangles.data() + 3 * t;
      const double* w = half_cotangent.data() + 3 * t;
      const auto at = [&](int k) {
        return Eigen::Map<const Values>(u.data() + std::size_t{Count} * corner[k]);
      };
      Values d0 = at(1) - at(0), d1 = at(2) - at(1), d2 = at(0) - at(2);
      // The values are scaled first, because squares of u would underflow.
      const Values largest = d0.abs().max(d1.abs()).max(d2.abs());
      const Values scale = (largest > 1e-300).select(largest.max(1e-300).inverse(), Values::Zero());
      d0 *= scale;
      d1 *= scale;
      d2 *= scale;
      const Values energy = w[0] * d0 * d0 + w[1] * d1 * d1 + w[2] * d2 * d2;
      const Values factor = (area[t] / energy.max(1e-200)).sqrt();
      const Values f0 = (w[0] * factor) * d0, f1 = (w[1] * factor) * d1, f2 = (w[2] * factor) * d2;
      const auto add = [&](int k, const Values& value) {
        Eigen::Map<Values>(right.data() + std::size_t{Count} * corner[k]) += value;
      };
      add(0, f0 - f2);
      add(1, f1 - f0);
      add(2, f2 - f1);
    }
    return right;
  }

  // Computes phi up to a constant from `sources`, V x Count weights.
  template <int Count>
  std::vector<double> solve(std::vector<double> sources, const CancelToken& cancel) const {
    if (has_boundary) {
      std::vector<double> held = sources;
      for (std::size_t v = 0; v < surface.vertex_count; ++v)
        if (on_boundary[v]) std::fill_n(held.begin() + static_cast<std::ptrdiff_t>(Count * v), Count, 0.0);
      heat_held.solve_many(held, Count);
      heat.solve_many(sources, Count);
      for (std::size_t i = 0; i < sources.size(); ++i) sources[i] += held[i];
    } else {
      heat.solve_many(sources, Count);
    }
    cancel.check();
    std::vector<double> phi = normalized_divergence<Count>(sources);
    poisson.solve_many(phi, Count);
    return phi;
  }
};

HeatGeodesics::HeatGeodesics(const PreparedMesh& mesh, const HeatGeodesicsParameters& parameters,
                             const CancelToken& cancel, std::span<const std::uint32_t> sources)
    : mesh_(&mesh),
      parts_(mesh.components.size()),
      factorized_(mesh.components.size(), sources.empty()),
      component_(mesh.triangle_count()) {
  if (!(parameters.time_factor >= 0.1 && parameters.time_factor <= 100))
    throw std::invalid_argument("heat geodesics: the time factor must lie in 0.1..100");
  for (std::uint32_t c = 0; c < mesh.components.size(); ++c)
    for (std::uint32_t t = mesh.components[c].triangle_begin; t < mesh.components[c].triangle_end; ++t)
      component_[t] = c;
  for (const std::uint32_t t : sources) factorized_[component_.at(t)] = 1;
  parallel_tasks(parts_.size(), [&](std::size_t c) {
    if (!factorized_[c] || !(mesh.components[c].area > 0)) return;
    parts_[c] = std::make_unique<Part>(mesh, mesh.components[c], parameters.time_factor, cancel);
  });
}

HeatGeodesics::~HeatGeodesics() = default;
HeatGeodesics::HeatGeodesics(HeatGeodesics&&) noexcept = default;
HeatGeodesics& HeatGeodesics::operator=(HeatGeodesics&&) noexcept = default;

std::size_t HeatGeodesics::factor_entries() const {
  std::size_t entries = 0;
  for (const auto& part : parts_)
    if (part)
      entries +=
          part->heat.factor_entries() + part->heat_held.factor_entries() + part->poisson.factor_entries();
  return entries;
}

template <class Write>
void HeatGeodesics::for_each_batch(PointsOnMesh sources, const CancelToken& cancel,
                                   const Write& write) const {
  check_points_on_mesh(*mesh_, sources);
  // Sources are grouped by component and cut into batches.
  std::vector<std::vector<std::uint32_t>> wanted(parts_.size());
  for (std::uint32_t s = 0; s < sources.count(); ++s) {
    const std::uint32_t c = component_[sources.triangle[s]];
    if (!factorized_[c])
      throw std::invalid_argument("heat geodesics: a source on a component that was left out");
    wanted[c].push_back(s);
  }
  struct Batch {
    std::uint32_t component;
    std::span<const std::uint32_t> sources;
  };
  std::vector<Batch> batches;
  for (std::uint32_t c = 0; c < wanted.size(); ++c)
    for (std::size_t begin = 0; begin < wanted[c].size(); begin += batch_size)
      batches.push_back(
          {c, std::span(wanted[c]).subspan(begin, std::min(batch_size, wanted[c].size() - begin))});

  parallel_lanes(batches.size(), geodesic_lanes(mesh_->vertex_count()), [&](std::size_t number) {
    cancel.check();
    const Batch& batch = batches[number];
    const Component& component = mesh_->components[batch.component];
    const Part* part = parts_[batch.component].get();
    std::size_t count = 1;
    while (count < batch.sources.size()) count *= 2;
    std::vector<double> phi;
    if (part != nullptr) {
      std::vector<double> start(count * part->surface.vertex_count, 0);
      for (std::size_t i = 0; i < batch.sources.size(); ++i) {
        const std::uint32_t s = batch.sources[i];
        const auto weight = weights_of(sources, s);
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t v = mesh_->triangles[3 * sources.triangle[s] + k] - component.vertex_begin;
          start[count * v + i] += std::max(weight[k], 0.0);
        }
      }
      at_width(count, [&]<int Count>() { phi = part->solve<Count>(std::move(start), cancel); });
    }
    for (std::size_t i = 0; i < batch.sources.size(); ++i) {
      const std::uint32_t s = batch.sources[i], triangle = sources.triangle[s];
      const auto weight = weights_of(sources, s);
      SourceField field{*mesh_, component, part != nullptr ? phi.data() + i : nullptr,
                        count,  triangle,  position_in(*mesh_, triangle, weight)};
      if (part != nullptr)
        field.shift = source_shift(*mesh_, triangle, weight, [&](std::uint32_t v) {
          return phi[count * (v - component.vertex_begin) + i];
        });
      write(s, batch.component, field);
    }
  });
}

void HeatGeodesics::to_vertices(PointsOnMesh sources, std::span<double> distance,
                                const CancelToken& cancel) const {
  const std::size_t width = mesh_->vertex_count();
  if (distance.size() != sources.count() * width)
    throw std::invalid_argument("heat geodesics: one distance per source and vertex is needed");
  std::fill(distance.begin(), distance.end(), std::numeric_limits<double>::infinity());
  for_each_batch(sources, cancel, [&](std::uint32_t s, std::uint32_t c, const SourceField& field) {
    double* row = distance.data() + s * width;
    for (std::uint32_t v = mesh_->components[c].vertex_begin; v < mesh_->components[c].vertex_end; ++v)
      row[v] = mesh_->unit * field.at_vertex(v);
  });
}

void HeatGeodesics::to_points(PointsOnMesh sources, PointsOnMesh targets, std::span<double> distance,
                              const CancelToken& cancel) const {
  if (distance.size() != sources.count() * targets.count())
    throw std::invalid_argument("heat geodesics: one distance per source and target is needed");
  check_points_on_mesh(*mesh_, targets);
  for_each_batch(sources, cancel, [&](std::uint32_t s, std::uint32_t c, const SourceField& field) {
    double* row = distance.data() + s * targets.count();
    for (std::size_t n = 0; n < targets.count(); ++n)
      row[n] = component_[targets.triangle[n]] == c
                   ? mesh_->unit * field.at_point(targets.triangle[n], weights_of(targets, n))
                   : std::numeric_limits<double>::infinity();
  });
}

}  // namespace meander
