// Where samples lie: an element, and a point of its triangle.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/random.h"
#include "kernels/density/pieces.h"
#include "kernels/partition/element_cells.h"
#include "kernels/partition/element_source.h"
#include "kernels/partition/surface_regions.h"

namespace meander {

// A piece of a triangle, and the sample's weights of corners 1 and 2 of the triangle. Before the sample is
// placed, b1 and b2 are the weights of the piece's curve vertex; or of a point in the piece, by the corners
// of the piece; or b1 is `nowhere`.
struct SampleSite {
  std::uint32_t triangle, path;
  float b1, b2;
  static constexpr float nowhere = -1;  // b1 of a piece without a point
};

// The sites of N samples by curve rank.
struct SampleSites {
  std::vector<SampleSite> site;  // N
  std::vector<double> mass;      // N: that of the element, where samples are placed at curve vertices
  bool drawn = false;            // b1 and b2 of all sites are final, but for points drawn again
  SampleSites() = default;
  SampleSites(std::size_t count, bool vertices) : site(count), mass(vertices ? count : 0) {}
  std::size_t count() const { return site.size(); }
  void set(std::size_t rank, std::uint32_t triangle, std::uint32_t path) {
    site[rank] = {triangle, path, SampleSite::nowhere, 0};
  }
  void set_point(std::size_t rank, const std::array<double, 2>& weights) {
    site[rank].b1 = static_cast<float>(weights[0]);
    site[rank].b2 = static_cast<float>(weights[1]);
  }
  void set_vertex(std::size_t rank, const float* weights, double own_mass) {
    site[rank].b1 = weights[0];
    site[rank].b2 = weights[1];
    mass[rank] = own_mass;
  }
  // From rank `first` on, those of a part.
  void set_all(std::size_t first, const SampleSites& part) {
    const auto at = static_cast<std::ptrdiff_t>(first);
    std::copy(part.site.begin(), part.site.end(), site.begin() + at);
    if (!part.mass.empty()) std::copy(part.mass.begin(), part.mass.end(), mass.begin() + at);
  }
};

// The element that holds each of the ascending positions in [0, 1): never one without mass. `vertices`:
// curve vertices too. O(N + N log(E / N)); in cells expected O(N P) for P entries a cell.
SampleSites elements_at(const CurveElements& elements, std::span<const double> position, bool vertices,
                        const CancelToken& cancel);
SampleSites elements_at(const ElementCells& cells, std::span<const double> position, bool vertices,
                        const CancelToken& cancel);
// Makes and forgets the elements or cells of one region after the other, several at a time by several
// threads. In a wide piece, the site is the part that holds the position. Under a uniform density, samples
// that do not lie at curve vertices are also drawn.
SampleSites elements_at(const SurfaceRegions& regions, const ElementSource& source,
                        std::span<const double> position, bool vertices);

// The same where the samples of cells form a net (cell_net.h): one element a cell, or its point. Those of
// regions are drawn as above.
SampleSites elements_in_net(const ElementCells& cells, RandomKey key, bool vertices,
                            const CancelToken& cancel);
SampleSites elements_in_net(const SurfaceRegions& regions, const ElementSource& source, bool vertices);

// The point that is drawn for the sample of this rank, by the number of draws before: uniform over its piece.
inline std::array<double, 2> drawn_point(const Piece& piece, std::uint32_t rank, RandomKey key,
                                         std::uint32_t counter = 0) {
  const UnitPair uniform = random_pair(key, Stream::element_point, rank, counter);
  return uniform_point(piece, uniform.first, uniform.second);
}
// The point that a site has in its piece.
inline std::array<double, 2> point_in(const Piece& piece, const SampleSite& site) {
  const double first = site.b1, second = site.b2;
  return {piece.b1[0] + first * (piece.b1[1] - piece.b1[0]) + second * (piece.b1[2] - piece.b1[0]),
          piece.b2[0] + first * (piece.b2[1] - piece.b2[0]) + second * (piece.b2[2] - piece.b2[0])};
}

}  // namespace meander
