// Connected components of adjacent triangles: numbering, order and topology.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// Finds the component of every triangle, breadth-first over the edges; numbers ascend with the first
// triangle. Large meshes are searched in ranges of triangles, one a thread, which are then joined. Returns
// the number of components. O(T). Throws timeout / RunCanceled from `cancel`.
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

// Sorts components along the 3-D Hilbert curve of their centroids, ties in the old order. Returns the new
// place of every old number. O(n).
std::vector<std::uint32_t> places_along_curve(std::span<const CentroidSum> components);

// Fills vertex ranges, boundary loops, genus and area of mesh.components, whose triangle ranges are set.
// Vertices must be numbered in the order in which triangles name them (number_fans). Throws
// ItemError(internal) when a component is not an oriented surface. O(T).
void describe_components(PreparedMesh& mesh);

}  // namespace meander
