// The arrays that TangentSamples looks at.
#pragma once

#include <vector>

#include "kernels/analyse/tangent_samples.h"
#include "kernels/core/vector3.h"

namespace meander::test {

struct TangentArrays {
  std::vector<double> points, normals, axes, s1, s2;
  TangentSamples view() const { return {points, normals, axes, s1, s2}; }
  void add(Vector3 p, Vector3 n, Vector3 e1, double along, double across) {
    points.insert(points.end(), {p.x, p.y, p.z});
    normals.insert(normals.end(), {n.x, n.y, n.z});
    axes.insert(axes.end(), {e1.x, e1.y, e1.z});
    s1.push_back(along);
    s2.push_back(across);
  }
};

}  // namespace meander::test
