// Point sets of stores and files for `meander measure`, and the surfaces on which they lie.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "io/store/store_reader.h"
#include "kernels/analyse/point_location.h"
#include "kernels/core/status.h"
#include "kernels/core/vector3.h"
#include "kernels/mesh/prepared_mesh.h"
#include "pipeline/sampling_graph.h"

namespace meander {

// A set of n points in the coordinates of the file.
struct MeasuredSet {
  std::string name;             // the file, or STORE:ITEM
  std::string item;             // id of the row, the file's stem for point files
  std::vector<double> x, y, z;  // n each
  std::vector<float> normals;   // 3 n, or empty
  std::vector<double> density;  // n positive values; empty: uniform
  double measure = 0;           // of stores: the integral of the density over the surface
  std::vector<double> axes,
      ratio;                 // 3 n directions of the longer spacing, n ratios of the spacings; or empty
  bool progressive = false;  // every prefix is a set of its own
  std::size_t count() const { return x.size(); }
};

// The sets that the arguments name, read one at a time: of stores (FILE.h5: all ok rows; FILE.h5::ITEM: one)
// and of point files.
class PointSets {
 public:
  // Reads the heads of stores, each checked as `check` says. Throws UsageError, RunError.
  PointSets(const std::vector<std::string>& arguments, StoreCheck check);
  ~PointSets();

  std::size_t size() const { return sources_.size(); }
  // Throws RunError; ItemError with the name of the file; UsageError for densities that are not positive.
  MeasuredSet load(std::size_t number);

 private:
  struct Source {
    std::string path;
    std::int64_t row = -1;  // of a store; -1: a point file
  };
  StoreReader& open_store(const std::string& path);

  std::vector<Source> sources_;
  std::unique_ptr<StoreReader> store_;  // the store that was opened last
  std::string store_path_;
  StoreCheck check_;
  std::set<std::string> checked_;  // stores are opened again and again, but checked once
};

// The surface on which a set lies.
struct MeasuredSurface {
  enum class Kind { plane, sphere, mesh };
  Kind kind = Kind::mesh;
  PreparedMesh mesh;                        // of kind mesh; in working coordinates
  std::unique_ptr<SurfaceLocator> locator;  // of kind mesh
  double area() const;                      // in file units squared
};

// Surfaces by the argument of --surface: `plane` (the unit square), `sphere` (the unit sphere), a mesh file,
// or the folder or archive that a store was made from, whose items are found by their ids.
class MeasuredSurfaces {
 public:
  explicit MeasuredSurfaces(std::string argument);
  // The surface of the set, read unless it is that of the set before. Throws UsageError when the points do
  // not lie on it: outside the square or more than 1e-4 from its plane; more than 1e-4 from the sphere
  // (others are projected onto it); more than one in a hundred farther from the mesh than 1e-3 of its
  // diagonal.
  const MeasuredSurface& of(MeasuredSet& set);

 private:
  void load(const MeasuredSet& set);
  PreparedMesh load_item(const std::string& id);
  std::string argument_, loaded_;
  bool is_collection_;
  std::map<std::string, PlanItem> items_;  // of a folder or an archive, by id
  EmbreeDevice device_;
  std::unique_ptr<MeasuredSurface> surface_;
};

// The 3 n coordinates of the points in working units of the mesh.
std::vector<double> working_points(const MeasuredSet& set, const PreparedMesh& mesh);

// Reads a mesh file, MESH.gz, or ARCHIVE/MEMBER. Throws ItemError that begins with the path; UsageError for a
// name that is not that of a mesh.
PolygonMesh read_model_mesh(const std::string& path);
// The same, prepared.
PreparedMesh load_mesh(const std::string& path);

// The result of `read`, whose ItemError gets the name of the file as its beginning.
template <class Read>
auto about_file(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const ItemError& error) {
    throw ItemError(error.status(), path + ": " + error.what());
  }
}

}  // namespace meander
