// Integrands at the points of a sample set, with their exact means over the surface: what `integral`
// measures.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "kernels/mesh/prepared_mesh.h"

namespace meander {

struct SampledIntegrand {
  std::string name;
  std::vector<double> values;  // at the points
  double mean = 0;             // over the surface, exact
};

// The standard integrands (integration_error.h) of uniform sets in the unit square. x, y: n each.
std::vector<SampledIntegrand> plane_integrands(std::span<const double> x, std::span<const double> y);

// On a mesh a quadratic polynomial (its integral over a triangle is the area times the mean at the edges'
// midpoints) and the indicator of a half-space through the center of the box (its area clipped exactly).
// points: 3 n working coordinates. O(T + n).
std::vector<SampledIntegrand> mesh_integrands(const PreparedMesh& mesh, std::span<const double> points);

}  // namespace meander
