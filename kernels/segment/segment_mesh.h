// Splitting a mesh into segments that are components of their own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/segment/random_walk.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

struct SegmentParameters {
  std::uint32_t count = 8;           // segments of the whole mesh, >= 1; at least one a component
  std::uint32_t min_triangles = 20;  // smaller segments join a neighbor
  RandomWalkParameters walk;
};

// A mesh whose components are segments of another mesh, with the maps back to it.
struct SegmentedMesh {
  PreparedMesh mesh;
  std::vector<std::uint32_t> source_triangle;   // T: corner k of a triangle is corner k of its source
  std::vector<std::uint32_t> source_vertex;     // W
  std::vector<std::uint32_t> source_component;  // by component of `mesh`
};

// Makes segments suitable as charts. Each connected part becomes a segment of its own; then, the smallest
// first (ties: the one that begins first), parts of fewer than min_triangles triangles join the neighbor with
// the longest common boundary, measured by `length` (3 T, say metric_edge_lengths; ties: the one that begins
// first). Parts that are a whole component stay. The new labels 0, 1, ... ascend with the first triangle of
// each segment; returns their number. Throws std::invalid_argument for arrays of the wrong size. O(T log T).
std::uint32_t tidy_segments(const PreparedMesh& mesh, std::span<const double> length,
                            std::uint32_t min_triangles, std::vector<std::uint32_t>& label);

// Makes each connected part of equal label a component. Triangles keep their order within one; components
// follow the 3-D Hilbert curve like those of prepare_mesh; vertices are duplicated along segment boundaries,
// one per fan; adjacency, boundary loops, genus and area are those of the segments. Everything else,
// total_area included, is that of `mesh`. One label for every component gives the same mesh. O(T).
SegmentedMesh split_into_segments(const PreparedMesh& mesh, std::span<const std::uint32_t> label);

// Runs seeds, random walk, tidy_segments and split_into_segments.
SegmentedMesh segment_mesh(const PreparedMesh& mesh, const TensorField& field,
                           const SegmentParameters& parameters = {}, const CancelToken& cancel = {});

// Splits one component by a random walk from its two farthest seeds: labels 0 and 1 for its triangles, in
// order; both sides are connected. The walk's own boundary (probability 1/2) holds unless one side would get
// less than a quarter of the triangles: then that side grows from its seed, the most probable triangle first,
// to a quarter, so that repeated bisection ends. Label 0 is that of the first triangle. A single triangle
// gets 0. O(T log T) and one factorization.
std::vector<std::uint32_t> bisect_component(const PreparedMesh& mesh, const Component& component,
                                            const TriangleSteps& steps, const CancelToken& cancel = {});

// The mesh with the given components (indices, ascending) bisected.
SegmentedMesh bisect_components(const PreparedMesh& mesh, std::span<const std::uint32_t> components,
                                const TriangleSteps& steps, const CancelToken& cancel = {});

// The field on the segmented mesh: triangles keep their frames, so values are only reordered.
TensorField carry_field(const SegmentedMesh& segmented, const TensorField& field);
// The same for values per half-edge, such as the lengths or weights of TriangleSteps, also of half-edges that
// became boundaries.
std::vector<double> carry_half_edge_values(const SegmentedMesh& segmented, std::span<const double> values);

}  // namespace meander
