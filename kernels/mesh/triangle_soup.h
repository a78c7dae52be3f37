// The triangles of a file before their neighbors are known.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/core/cancel.h"
#include "kernels/core/exact_division.h"
#include "kernels/core/large_vector.h"
#include "kernels/core/vector3.h"
#include "kernels/mesh/polygon_mesh.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// T triangles on their way to a PreparedMesh.
struct TriangleSoup {
  std::vector<std::uint32_t> triangles;    // 3 T file vertices, welded to the first at their position
  std::vector<std::uint32_t> corner_slot;  // 3 T
  std::vector<std::uint32_t> polygon;      // T

  void resize(std::size_t count) {
    resize_large(triangles, 3 * count);
    resize_large(corner_slot, 3 * count);
    resize_large(polygon, count);
  }
  // Moves triangles to an earlier position.
  void move(std::size_t from, std::size_t to, std::size_t count) {
    if (from == to || count == 0) return;
    std::copy_n(&triangles[3 * from], 3 * count, &triangles[3 * to]);
    std::copy_n(&corner_slot[3 * from], 3 * count, &corner_slot[3 * to]);
    std::copy_n(&polygon[from], count, &polygon[to]);
  }
};

// Working coordinates of file vertices (PreparedMesh). A view of the mesh.
class WorkingPositions {
 public:
  WorkingPositions(const PolygonMesh& mesh, const PreparedMesh& frame)
      : x_(mesh.x.data()),
        y_(mesh.y.data()),
        z_(mesh.z.data()),
        center_(frame.center),
        in_units_(frame.unit) {}
  Vector3 operator()(std::uint32_t vertex) const {
    return {in_units_(x_[vertex] - center_.x), in_units_(y_[vertex] - center_.y),
            in_units_(z_[vertex] - center_.z)};
  }

 private:
  const double *x_, *y_, *z_;
  Vector3 center_;
  ExactDivision in_units_;
};

// Makes the triangles of all usable polygons: of three different vertices, in range and finite. Sets the
// frame of the working coordinates, the box and the number of vertices that no usable polygon names, and
// counts in the repairs of `out` the faces that cannot be used. The box is that of the polygons with an area:
// vertices outside of it, named only by polygons without area, are left out. `weld`: vertices at one position
// are one. Throws ItemError: empty, non_finite, index_out_of_range or zero_area when nothing is left;
// too_large for more triangles than 32-bit half-edges can number. O(corners), parallel; the same for every
// thread count.
TriangleSoup read_soup(const PolygonMesh& mesh, bool weld, PreparedMesh& out, const CancelToken& cancel);

// The areas of the triangles, in working units squared. O(T), parallel.
std::vector<double> soup_areas(const PolygonMesh& mesh, const PreparedMesh& frame, const TriangleSoup& soup);

// Throws the ItemError that says why a mesh with these repairs has no triangle.
[[noreturn]] void fail_without_faces(const PolygonMesh& mesh, const RepairCounts& repairs);

}  // namespace meander
