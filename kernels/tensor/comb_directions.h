// One consistent primary direction per triangle of a chart (docs/METHODS.md 9.7).
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/cut/cut_to_disk.h"
#include "kernels/flatten/chart_report.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

// The edge vectors of every triangle in its own plane: x along its half-edge 0, y to the left. This is
// triangle_frame() for triangles that count; other triangles, which have no frame, have x along their longest
// edge.
struct UnfoldedTriangles {
  std::vector<double> x, y;  // 3 T, by half-edge
};
UnfoldedTriangles unfold_triangles(const ChartGeometry& geometry);  // O(T)

struct CombParameters {
  double isotropic_ratio = 1.05;        // s1 / s2 below which a triangle has no direction of its own; >= 1
  std::uint32_t smoothing_sweeps = 20;  // over inherited directions; 0..1000
};

// e1 of chart triangle t, unit, in the frame of the triangle; e2 is e1 rotated by +90 degrees.
struct CombedDirections {
  std::vector<double> x, y;              // T
  std::vector<double> first, second;     // T: spacings s1 >= s2 > 0 of the mean log S of the triangle
  std::vector<std::uint8_t> inherited;   // T: 1 where the direction is that of the neighbors
  std::uint32_t inconsistent_edges = 0;  // inner edges across which e1 turns by more than 90 degrees
  // Inner chart vertices, ascending, around which the sign of e1 cannot be combed (a singularity of index
  // k + 1/2).
  std::vector<std::uint32_t> odd_vertices;
};

// Chooses signs of e1 by a breadth-first search over the chart's triangles, with e1 carried over the unfolded
// edge between two of them. Triangles that are isotropic or without area come last: they take the mean
// direction of their neighbors, smoothed (slivers take their spacings too). On a disk the combing is
// consistent exactly when no vertex is odd; otherwise the inconsistent edges form lines from the odd vertices
// to the boundary or to each other. The first anisotropic triangle keeps the sign that tensor_axes() gives
// it. O(T (1 + sweeps)). Deterministic; throws timeout / RunCanceled.
CombedDirections comb_directions(const CutChart& chart, const ChartGeometry& geometry,
                                 const UnfoldedTriangles& unfolded, const TensorField& field,
                                 const CombParameters& parameters = {}, const CancelToken& cancel = {});
// The same with geometry and layout made inside.
CombedDirections comb_directions(const PreparedMesh& mesh, const CutChart& chart, const TensorField& field,
                                 const CombParameters& parameters = {}, const CancelToken& cancel = {});

}  // namespace meander
