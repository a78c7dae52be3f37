// Where stored points lie: stored coordinates of a row, coordinates of its file, working units of its mesh.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/data/samples.h"
#include "kernels/mesh/prepared_mesh.h"
#include "kernels/sample/place_samples.h"

namespace meander {

// Point i of a row (points: N x 3, stored) in coordinates of the file: loc + scale * point.
inline Vector3 file_point(const ItemReport& report, std::span<const float> points, std::size_t i) {
  return {report.loc[0] + report.scale * double{points[3 * i]},
          report.loc[1] + report.scale * double{points[3 * i + 1]},
          report.loc[2] + report.scale * double{points[3 * i + 2]}};
}

// All points of a row in coordinates of the file, 3 N numbers. O(N).
std::vector<double> file_points(const ItemReport& report, std::span<const float> points);

// File coordinates in working units, and back.
inline Vector3 to_working(const PreparedMesh& mesh, Vector3 file) {
  return {(file.x - mesh.center.x) / mesh.unit, (file.y - mesh.center.y) / mesh.unit,
          (file.z - mesh.center.z) / mesh.unit};
}
inline Vector3 to_file(const PreparedMesh& mesh, Vector3 working) {
  return {mesh.center.x + mesh.unit * working.x, mesh.center.y + mesh.unit * working.y,
          mesh.center.z + mesh.unit * working.z};
}

// All points of a row in working units of the mesh they were sampled from, 3 N numbers. O(N).
std::vector<double> working_points(const ItemReport& report, std::span<const float> points,
                                   const PreparedMesh& mesh);
// The same of points in coordinates of the file, 3 N numbers.
std::vector<double> working_points(std::span<const double> file_points, const PreparedMesh& mesh);

// Stored coordinates of points in working units (3 N numbers), without negative zeros. O(N).
std::vector<float> stored_points(std::span<const double> working, const PreparedMesh& mesh,
                                 const OutputFrame& frame);

}  // namespace meander
