// Geodesic distances on a mesh by the heat method, many sources at once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// n points of a PreparedMesh: working triangle and the barycentric weights of its corners 1 and 2 (2 n).
struct PointsOnMesh {
  std::span<const std::uint32_t> triangle;
  std::span<const double> barycentric;

  std::size_t count() const { return triangle.size(); }
};

// Storage for PointsOnMesh.
struct PointsOnMeshArrays {
  std::vector<std::uint32_t> triangle;
  std::vector<double> barycentric;

  operator PointsOnMesh() const { return {triangle, barycentric}; }
};

// Working vertices as points, each in the first triangle that has it as a corner. O(T + n). Throws
// std::invalid_argument for a vertex that does not exist or has no triangle.
PointsOnMeshArrays vertices_as_points(const PreparedMesh& mesh, std::span<const std::uint32_t> vertices);

// Throws std::invalid_argument when sizes do not fit, a triangle does not exist or a weight lies outside
// [-1e-6, 1 + 1e-6]. O(n).
void check_points_on_mesh(const PreparedMesh& mesh, PointsOnMesh points);

// Sources that are solved for together, and the bytes that they take: three vectors of a number for each
// source and vertex.
inline constexpr std::size_t geodesic_batch = 16;
constexpr std::size_t geodesic_batch_bytes(std::size_t vertices) {
  return 3 * geodesic_batch * sizeof(double) * vertices;
}
// The number of batches at work at once, whatever the number of threads: as many as fit 128 MiB, and two at
// least.
constexpr std::size_t geodesic_lanes(std::size_t vertices) {
  constexpr std::size_t scratch = std::size_t{128} << 20;
  return std::max<std::size_t>(2, scratch / (geodesic_batch_bytes(vertices) + 1));
}

struct HeatGeodesicsParameters {
  double time_factor = 1;  // t = time_factor h^2, h = mean edge length; 0.1..100
};

// Heat method (Crane, Weischedel and Wardetzky 2013, "Geodesics in heat"): (M + t L) u = source, unit field
// X = -grad u / |grad u|, L phi = -div X, on every component's intrinsic Delaunay triangulation (mollified;
// Sharp and Crane 2020), M the lumped areas, L the positive cotangent Laplacian.
//
// - Factors are made once for each component: M + t L and L (grounded at one vertex: exact, since the
//   right-hand side sums to 0), with one elimination order. A component with boundary has a third, M + t L
//   with u = 0 on the boundary, and u is the mean of both solutions (the paper's boundary condition).
// - t = h^2, except where paths along edges from a vertex get longer than 300 h: there t = (extent / 300)^2,
//   so that u stays within the range of double. Larger time factors reduce the influence of the triangulation
//   on the level sets (4: a quarter of the error on fine spheres) but smooth more where shortest paths meet
//   (half as much again on a torus) and at boundaries.
// - A source is spread over the corners of its triangle by its weights. phi is shifted so that the vertices
//   beside the source have, on average, their distance from it (the heat rounds off the tip of phi itself);
//   corners of the source's triangle, and points in it, get their straight distance: the source has 0.
// - At points phi is interpolated linearly in the point's own triangle. No distance is below the straight one
//   in space.
// - Distances are infinity between components, and straight within a component without area.
//
// Accuracy, in percent of the largest distance. Spheres of 642, 10,242 and 40,962 vertices: mean error 0.14,
// 0.17 and 0.2 (0.35, 0.23 and 0.24 from edge midpoints, the worst sources), largest 1, 0.7 and 0.6: the
// influence of the triangulation, which does not vanish with t = h^2. Tori (radii 1, 0.4) of 960, 3,840 and
// 15,360 vertices: mean 2.2, 1.3 and 0.8, largest 8, 5 and 3.4. Bunny (34,835 vertices, three sources): mean
// 0.6, largest 2.5; fandisk (6,475): 0.5 and 3.3. The mesh must be finer than the features to be measured.
// Distances are in file units and not exactly symmetric.
//
// Cost: factors O(V^1.5) time and O(V log V) memory; bench/geodesic_bench.cpp measures sources in batches of
// 16. Deterministic for every thread count and every batching: a source's distances do not depend on the
// others.
class HeatGeodesics {
 public:
  // Factorizes (in parallel) the components that have one of the working triangles in `sources`, or all when
  // it is empty; sources may lie on these alone. The mesh must outlive the object. Throws
  // std::invalid_argument for a parameter out of range, ItemError(internal) when a component cannot be
  // factorized, timeout / RunCanceled.
  explicit HeatGeodesics(const PreparedMesh& mesh, const HeatGeodesicsParameters& parameters = {},
                         const CancelToken& cancel = {}, std::span<const std::uint32_t> sources = {});
  ~HeatGeodesics();
  HeatGeodesics(HeatGeodesics&&) noexcept;
  HeatGeodesics& operator=(HeatGeodesics&&) noexcept;

  // S x W: distance[s W + w] from source s to working vertex w. Batches of geodesic_batch sources of one
  // component, geodesic_lanes of them in parallel. Throws std::invalid_argument as check_points_on_mesh, when
  // the span does not fit, and for a source on a component without a factor; timeout / RunCanceled.
  void to_vertices(PointsOnMesh sources, std::span<double> distance, const CancelToken& cancel = {}) const;

  // S x N: distance[s N + n] from source s to target n. Throws as to_vertices.
  void to_points(PointsOnMesh sources, PointsOnMesh targets, std::span<double> distance,
                 const CancelToken& cancel = {}) const;

  // The number of entries of all factors, 8 bytes each.
  std::size_t factor_entries() const;

 private:
  struct Part;
  template <class Write>
  void for_each_batch(PointsOnMesh sources, const CancelToken& cancel, const Write& write) const;

  const PreparedMesh* mesh_;
  std::vector<std::unique_ptr<Part>> parts_;  // one per component
  std::vector<std::uint8_t> factorized_;      // per component: has sources
  std::vector<std::uint32_t> component_;      // T: component of each triangle
};

}  // namespace meander
