// Connected components of adjacent triangles: numbering, order and topology.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Breadth-first over the edges: component number of every triangle; numbers ascend with the first triangle.
// Large meshes by ranges of triangles that are joined, one a thread. Returns how many there are. O(T).
std::uint32_t find_components(std::span<const std::uint32_t> opposite, std::vector<std::uint32_t>& component,
                              const CancelToken& cancel = {});

// Sums that give the area centroid of a component, or the mean centroid of triangles without area.
struct CentroidSum {
  Vector3 moment, middle;
  double weight = 0;
  std::uint32_t members = 0;

  void add(double area, Vector3 centroid) {
    moment = moment + area * centroid;
    middle = middle + centroid;
    weight += area;
    ++members;
  }
  Vector3 centroid() const { return weight > 0 ? (1 / weight) * moment : (1.0 / members) * middle; }
};

// Components along the 3-D Hilbert curve of their centroids, ties in the old order: the new place of every
// old number.
std::vector<std::uint32_t> places_along_curve(std::span<const CentroidSum> components);

// Fills vertex ranges, boundary loops, genus and area of mesh.components, whose triangle ranges are set;
// vertices must be numbered in the order in which triangles name them (number_fans). Throws
// ItemError(internal) when a component is not an oriented surface. O(T).
void describe_components(PreparedMesh& mesh);

}  // namespace meander
