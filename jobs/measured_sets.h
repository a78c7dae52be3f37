// What `meander measure` judges: point sets of stores and files, and the surfaces they lie on.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/vector3.h"
#include "kernels/mesh/prepared_mesh.h"

namespace meander {

// n points in file coordinates.
struct MeasuredSet {
  std::string name;             // the file, or STORE:ITEM
  std::string item;             // id of the row, the file's stem for point files
  std::vector<double> x, y, z;  // n each
  std::vector<float> normals;   // 3 n, or empty
  std::vector<float> density;   // n values from a store; empty: uniform
  bool progressive = false;     // every prefix is a set of its own
  std::size_t count() const { return x.size(); }
};

// Stores (.h5: all ok rows; FILE.h5::ITEM one of them) and point files. Throws UsageError, RunError,
// ItemError.
std::vector<MeasuredSet> load_point_sets(const std::vector<std::string>& arguments);

// The surface that a set lies on.
struct MeasuredSurface {
  enum class Kind { plane, sphere, mesh };
  Kind kind = Kind::mesh;
  PreparedMesh mesh;    // of kind mesh; in working coordinates
  double area() const;  // in file units squared
};

// Surfaces by the argument of --surface: `plane` (the unit square), `sphere` (the unit sphere), a mesh file,
// or a folder that holds the items of a store under their ids. Meshes are read once.
class MeasuredSurfaces {
 public:
  explicit MeasuredSurfaces(std::string argument) : argument_(std::move(argument)) {}
  const MeasuredSurface& of(const MeasuredSet& set);

 private:
  std::string argument_, loaded_;
  std::unique_ptr<MeasuredSurface> surface_;
};

// 3 n working coordinates of the mesh.
std::vector<double> working_points(const MeasuredSet& set, const PreparedMesh& mesh);

// A mesh file, read and prepared. Throws ItemError.
PreparedMesh load_mesh(const std::string& path);

}  // namespace meander
