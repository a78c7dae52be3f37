#include "jobs/measured_sets.h"

#include <filesystem>
#include <numbers>

#include "io/mesh/mapped_file.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/point_reader.h"
#include "io/store/store.h"
#include "jobs/inputs.h"
#include "jobs/store_items.h"
#include "kernels/mesh/prepare_mesh.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

MeasuredSet set_of_row(const StoreReader& store, const std::string& path, std::uint64_t number) {
  const Row row = store.read_row(number);
  MeasuredSet set;
  set.item = store.id(number);
  set.name = path + "::" + set.item;
  set.progressive = store.order() == "progressive";
  const std::vector<float>& points = row.samples.points;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    set.x.push_back(row.report.loc[0] + row.report.scale * points[i]);
    set.y.push_back(row.report.loc[1] + row.report.scale * points[i + 1]);
    set.z.push_back(row.report.loc[2] + row.report.scale * points[i + 2]);
  }
  set.normals = row.samples.normals;
  for (const float density : row.samples.density)
    if (density != 1) {  // uniform sets need no weights
      set.density = row.samples.density;
      break;
    }
  return set;
}

void add_store(const std::string& path, const std::string& item, std::vector<MeasuredSet>& sets) {
  const StoreReader store(path);
  if (!item.empty()) {
    const std::uint64_t row = find_item(store, item);
    if (store.report(row).status != Status::ok)
      throw UsageError("`" + item + "` of " + path + " has no points");
    sets.push_back(set_of_row(store, path, row));
    return;
  }
  for (std::uint64_t row = 0; row < store.rows(); ++row)
    if (store.report(row).status == Status::ok) sets.push_back(set_of_row(store, path, row));
}

}  // namespace

std::vector<MeasuredSet> load_point_sets(const std::vector<std::string>& arguments) {
  std::vector<MeasuredSet> sets;
  for (const std::string& argument : arguments) {
    const std::size_t separator = argument.find("::");
    const std::string path = argument.substr(0, separator);
    if (fs::path(path).extension() == ".h5") {
      add_store(path, separator == std::string::npos ? "" : argument.substr(separator + 2), sets);
      continue;
    }
    PointCloud cloud = read_points(argument);
    MeasuredSet set;
    set.name = argument;
    set.item = fs::path(argument).stem().string();
    set.x = std::move(cloud.x);
    set.y = std::move(cloud.y);
    set.z = std::move(cloud.z);
    set.normals = std::move(cloud.normals);
    sets.push_back(std::move(set));
  }
  if (sets.empty()) throw UsageError("no point set in the input");
  return sets;
}

double MeasuredSurface::area() const {
  if (kind == Kind::plane) return 1;
  if (kind == Kind::sphere) return 4 * std::numbers::pi;
  return mesh.total_area * mesh.unit * mesh.unit;
}

const MeasuredSurface& MeasuredSurfaces::of(const MeasuredSet& set) {
  const bool folder = fs::is_directory(argument_);
  const std::string wanted = folder ? (fs::path(argument_) / set.item).string() : argument_;
  if (surface_ && loaded_ == wanted) return *surface_;
  auto surface = std::make_unique<MeasuredSurface>();
  if (argument_ == "plane")
    surface->kind = MeasuredSurface::Kind::plane;
  else if (argument_ == "sphere")
    surface->kind = MeasuredSurface::Kind::sphere;
  else
    surface->mesh = load_mesh(wanted);
  surface_ = std::move(surface);
  loaded_ = wanted;
  return *surface_;
}

std::vector<double> working_points(const MeasuredSet& set, const PreparedMesh& mesh) {
  std::vector<double> points;
  points.reserve(3 * set.count());
  for (std::size_t i = 0; i < set.count(); ++i) {
    points.push_back((set.x[i] - mesh.centre.x) / mesh.unit);
    points.push_back((set.y[i] - mesh.centre.y) / mesh.unit);
    points.push_back((set.z[i] - mesh.centre.z) / mesh.unit);
  }
  return points;
}

PreparedMesh load_mesh(const std::string& path) {
  MeshFormat format{};
  if (!mesh_format_of(path, format)) throw UsageError("`" + path + "` is no .off, .obj, .ply or .stl file");
  const MappedFile file(path);
  return prepare_mesh(read_mesh(file.bytes(), format));
}

}  // namespace meander
