// A fill-reducing elimination order for a mesh Laplacian.
#pragma once

#include <cstdint>
#include <vector>

namespace meander {

// The neighbors of unknown i are neighbors[begin[i]] .. neighbors[begin[i + 1] - 1]: symmetric, repeats are
// allowed, i itself is not among them. n = begin.size() - 1.
struct UnknownGraph {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> neighbors;

  std::size_t count() const { return begin.size() - 1; }
};

// The matrix with A(i, neighbors[e]) = values[e], repeats added, and A(i, i) = diagonal[i].
struct GraphMatrix {
  UnknownGraph graph;
  std::vector<double> values, diagonal;
};

// Approximate minimum degree (Amestoy, Davis and Duff 1996): order[k] = the unknown eliminated k-th.
// Geometric nested dissection is no faster here and produces twice the fill on strongly curved surfaces.
std::vector<std::uint32_t> elimination_order(const UnknownGraph& graph);

}  // namespace meander
