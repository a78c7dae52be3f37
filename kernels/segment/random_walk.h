// Segmentation of a surface by random walks between its triangles (docs/METHODS.md 9.6).
//
// Lai, Hu, Martin, Rosin 2009, "Rapid and effective segmentation of 3D models using random walks": triangles
// are nodes, neighbors are joined by weighted edges, and a triangle belongs to the seed that a walk from it
// most probably meets first. Here the weights follow a tensor field: steps that cross few spacings are
// likely.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/tensor/tensor_field.h"

namespace meander {

struct RandomWalkParameters {
  double sigma = 1;    // step length at which the weight falls by a factor e, in mean lengths; > 0
  double bending = 0;  // beta >= 0: added to a step by a right-angled turn of e1, in mean lengths
};

// The dual graph of a mesh: the cost of a step across each half-edge. Both half-edges of an edge agree bit
// for bit.
struct TriangleSteps {
  std::vector<double> length;  // 3 T: spacings between the two centroids; 0 at boundaries
  std::vector<double> weight;  // 3 T: > 0, 0 at boundaries; the largest of every component is 1
};

// Measures the steps. Length c: with the two triangles unfolded over their edge and the step w between their
// centroids, sqrt(w^T G w) in the metric of the mean of their log S. Weight: |e| exp(-(c / mean + beta b) /
// sigma), where |e| is the edge's length in the metric and mean the mean of c over the component; so nothing
// depends on how the surface lies in space except through the metric, and a field of S = 1 gives Euclidean
// lengths. b in [0, 1] is sin^2 of the angle between the primary directions on both sides, times the smaller
// 1 - s2 / s1 of both (directions of isotropic tensors are noise). Weights below 1e-8 of the component's
// maximum are raised to that, so that the linear systems keep enough digits. A triangle without area takes
// the tensor of its neighbor. Throws std::invalid_argument for parameters out of range. O(T), parallel.
TriangleSteps triangle_steps(const PreparedMesh& mesh, const TensorField& field,
                             const RandomWalkParameters& parameters = {});

// The probability that a walk from triangle i of the component meets seed l before any other seed: entry i *
// seeds.size() + l, i counted from the component's first triangle; rows sum to 1 up to rounding. Seeds:
// different triangles (indices in the mesh) of this component, at least one, otherwise std::invalid_argument.
// One sparse Cholesky factorization, then one back-substitution for each 16 seeds. The same bits for every
// thread count. Throws timeout / RunCanceled; ItemError(internal) when the system cannot be factorized.
std::vector<double> random_walk_probabilities(const PreparedMesh& mesh, const Component& component,
                                              std::span<const double> weight,
                                              std::span<const std::uint32_t> seeds,
                                              const CancelToken& cancel = {});

// Finds for all triangles of the mesh the seed with the highest probability, as its position in `seeds`; the
// lower one where several are equally probable. Every component needs a seed, otherwise
// std::invalid_argument. Components are independent; one with a single seed costs nothing. Otherwise as
// above, with O(T) memory beside the factor.
std::vector<std::uint32_t> random_walk_labels(const PreparedMesh& mesh, std::span<const double> weight,
                                              std::span<const std::uint32_t> seeds,
                                              const CancelToken& cancel = {});

}  // namespace meander
