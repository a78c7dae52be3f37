// The nearest point of a triangle mesh, for points that come without it: samples of other programs, other
// meshes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/rays/embree_locator.h"

namespace meander {

struct SurfacePoint {
  Vector3 point;                    // on the surface
  double distance = 0;              // to it
  std::uint32_t triangle = 0;       // the lowest number where several are equally near
  double weight1 = 0, weight2 = 0;  // barycentric weights of corners 1 and 2, >= 0, sum <= 1
};

// A mesh that can be asked for its nearest point. Embree's point queries (Wald et al. 2014; float boxes,
// rounded outwards, and a query radius with a margin for the rounding of the query point) only choose the
// candidates; the distance to a triangle is computed in double from the positions given. Distances are thus
// those of a search through all triangles in double: error about 1e-15 (size of the mesh + distance +
// distance of the mesh from the origin). Coordinates of any scale and offset. Triangles without area are
// segments or points. Thread-safe; answers are pure, and do not depend on how Embree built its tree.
// Building: about 0.6 us a triangle. A query: 0.4-0.7 us on the surface, more where much of the surface is
// equally far (the center of a sphere: all of it).
class SurfaceLocator {
 public:
  // x, y, z: V positions, triangles: 3 T vertex numbers; copied. Throws std::invalid_argument without
  // triangles, for vertex numbers that are not there, and for corners that are not finite; and what
  // EmbreeDevice documents.
  SurfaceLocator(const EmbreeDevice& device, std::span<const double> x, std::span<const double> y,
                 std::span<const double> z, std::span<const std::uint32_t> triangles);
  ~SurfaceLocator();
  SurfaceLocator(const SurfaceLocator&) = delete;
  SurfaceLocator& operator=(const SurfaceLocator&) = delete;

  // p must be finite.
  SurfacePoint nearest(Vector3 p) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

// n answers; arrays of a store's kind.
struct SurfaceLocations {
  std::vector<std::uint32_t> triangle;  // n
  std::vector<double> barycentric;      // 2 n: weights of corners 1 and 2
  std::vector<double> distance;         // n
};

// points: 3 n coordinates, finite (else std::invalid_argument). Parallel in fixed blocks; neighbors in the
// array should be neighbors in space.
SurfaceLocations locate_points(const SurfaceLocator& surface, std::span<const double> points);

}  // namespace meander
