// A mesh whose vertices are the samples of a surface (docs/REMESH.md).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/remesh/attach_samples.h"
#include "kernels/remesh/fit_samples.h"
#include "kernels/remesh/surface_lines.h"

namespace meander {

struct RemeshParameters {
  LineParameters lines;
  bool fit = false;            // flips and heights that bring the mesh nearer to the surface
  bool part_crossings = true;  // look for triangles that cross, count them and take them apart
  AttachParameters attaching;  // of fit: samples beside lines move onto them
  FitParameters fitting;
};

// N samples of a prepared mesh.
struct RemeshSamples {
  std::span<const std::uint32_t> triangle;  // N
  std::span<const float> weights;           // 2 N: barycentric weights of corners 1 and 2
  std::span<const double> position;         // 3 N, working units: where the vertices are
  std::span<const std::uint32_t> rank;      // N: an order in which neighbors are near
};

// What became of a surface.
struct RemeshReport {
  std::uint32_t components = 0, boundary_loops = 0;  // of the new mesh
  std::uint64_t vertices = 0, faces = 0;             // of the new mesh
  std::int64_t euler = 0;                            // vertices - edges + faces: that of the surface, without
                                                     // the components that were dropped
  std::uint32_t line_vertices = 0;                   // vertices on boundaries and creases that are no samples
  std::uint32_t kept_vertices = 0;       // other vertices of the surface: the topology needs them,
                                         // or without them triangles cross
  std::uint32_t dropped_components = 0;  // of the surface: they have no sample
  double dropped_share = 0;              // of the area: that of those components
  std::uint32_t coincident_samples = 0;  // at places of the surface where others are
  std::uint32_t coarse_lines = 0;        // components whose lines have longer edges than asked:
                                         // they would need more vertices than all the rest
  std::uint64_t crossings = 0;           // pairs of triangles without a common vertex that cross
  std::uint64_t input_crossings = 0;     // further ones, where triangles of the surface cross
  std::uint32_t partial_search = 0;      // 1: nearly all triangles are near each other, and the search for
                                         // crossings ended at its bound; those found count as of the input
  double largest_shift = 0;              // of a sample by fitting, over the mean edge around it
};

// The numbers of the report by the names that tables and Python give them.
struct RemeshCount {
  const char* name;
  std::variant<std::uint32_t RemeshReport::*, std::uint64_t RemeshReport::*, std::int64_t RemeshReport::*>
      member;

  std::int64_t of(const RemeshReport& report) const {
    return std::visit([&](auto at) { return static_cast<std::int64_t>(report.*at); }, member);
  }
  void set(RemeshReport& report, std::int64_t value) const {
    std::visit(
        [&](auto at) { report.*at = static_cast<std::remove_reference_t<decltype(report.*at)>>(value); },
        member);
  }
};
inline constexpr auto remesh_counts = std::to_array<RemeshCount>({
    {"vertices", &RemeshReport::vertices},
    {"line_vertices", &RemeshReport::line_vertices},
    {"kept_vertices", &RemeshReport::kept_vertices},
    {"faces", &RemeshReport::faces},
    {"components", &RemeshReport::components},
    {"boundary_loops", &RemeshReport::boundary_loops},
    {"euler", &RemeshReport::euler},
    {"dropped_components", &RemeshReport::dropped_components},
    {"coincident_samples", &RemeshReport::coincident_samples},
    {"coarse_lines", &RemeshReport::coarse_lines},
    {"crossings", &RemeshReport::crossings},
    {"input_crossings", &RemeshReport::input_crossings},
    {"partial_search", &RemeshReport::partial_search},
});

// Where a vertex of an edge stands: between two vertices of the surface or of the new mesh.
struct BetweenVertices {
  std::uint32_t vertex = 0;  // of the new mesh
  std::uint32_t first = 0, second = 0;
  bool first_of_surface = false, second_of_surface = false;  // else of the new mesh, and less than `vertex`
  double share = 0;                                          // of the second; the first has the rest
};

struct RemeshedSurface {
  std::vector<double> x, y, z;  // V: the N samples in their order, then the other vertices; working units
  std::vector<std::uint32_t> triangles;  // 3 F, oriented as the surface
  std::vector<std::uint32_t> origin;     // V - N: the vertex of the surface, no_index on an edge of a line
  std::vector<BetweenVertices> between;  // the vertices whose origin is no_index, ascending
  RemeshReport report;
};

// Inserts the samples into the triangles they lie on and removes the vertices of the surface, component by
// component. The result has the topology of the surface: as many components (without those that have no
// sample), boundary loops and handles; it is a 2-manifold with boundary, and no two of its edges join the
// same vertices. Boundaries and creases are lines of their own vertices, no farther
// apart than lines.spacing.
//   masses: T (MeshMeasure): where samples are denser lines have more vertices; empty: uniform
// Parallel over components, deterministic for every number of threads. About 2 us a vertex of the surface and
// 1 us a sample, more with fit; 100 bytes a triangle and 200 a sample. Throws std::invalid_argument for
// arrays that do not fit, std::logic_error where the topology came out wrong, and what `cancel` throws.
RemeshedSurface remesh_surface(const PreparedMesh& surface, const RemeshSamples& samples,
                               std::span<const double> masses, const RemeshParameters& parameters = {},
                               const CancelToken& cancel = {});

}  // namespace meander
