#include "jobs/laboratory/measured_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "io/archive/model_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "io/mesh/point_reader.h"
#include "io/store/store_reader.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/inputs.h"
#include "jobs/inputs/store_items.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

// Drops the weights of uniform sets.
void set_density(std::vector<double> density, MeasuredSet& set) {
  if (std::all_of(density.begin(), density.end(), [](double d) { return d == 1; })) return;
  for (const double d : density)
    if (!(d > 0) || !std::isfinite(d))
      throw UsageError(
          fmt::format("{} has a density of {} at a point: weights need positive finite ones", set.name, d));
  set.density = std::move(density);
}

MeasuredSet set_of_row(const StoreReader& store, const std::string& path, std::uint64_t number) {
  // A set of another density must not be measured as uniform: it would pass for a bad one.
  store.require(&Samples::density, "`measure`");
  const Row row = store.read_row(number);
  MeasuredSet set;
  set.item = store.id(number);
  set.name = path + "::" + set.item;
  set.progressive = store.order() == "progressive";
  for (std::size_t i = 0; i < row.samples.count(); ++i) {
    const Vector3 p = file_point(row.report, row.samples.points, i);
    set.x.push_back(p.x);
    set.y.push_back(p.y);
    set.z.push_back(p.z);
  }
  set.normals = row.samples.normals;
  set_density({row.samples.density.begin(), row.samples.density.end()}, set);
  set.measure = row.report.measure;
  set.axes.assign(row.samples.tensor_direction.begin(), row.samples.tensor_direction.end());
  for (std::size_t i = 0; i < row.samples.tensor_spacing.size(); i += 2)
    set.ratio.push_back(double{row.samples.tensor_spacing[i]} / double{row.samples.tensor_spacing[i + 1]});
  return set;
}

}  // namespace

PointSets::PointSets(const std::vector<std::string>& arguments, StoreCheck check) : check_(check) {
  for (const std::string& argument : arguments) {
    const std::size_t separator = argument.find("::");
    const std::string path = argument.substr(0, separator);
    if (fs::path(path).extension() != ".h5") {
      sources_.push_back({argument, -1});
      continue;
    }
    const StoreReader& store = open_store(path);
    if (separator != std::string::npos) {
      const std::uint64_t row = find_item(store, argument.substr(separator + 2));
      if (store.report(row).status != Status::ok) throw UsageError("`" + argument + "` has no points");
      sources_.push_back({path, static_cast<std::int64_t>(row)});
      continue;
    }
    for (std::uint64_t row = 0; row < store.rows(); ++row)
      if (store.report(row).status == Status::ok) sources_.push_back({path, static_cast<std::int64_t>(row)});
  }
  if (sources_.empty()) throw UsageError("no point set in the input");
}

PointSets::~PointSets() = default;

StoreReader& PointSets::open_store(const std::string& path) {
  if (!store_ || store_path_ != path)
    store_ = std::make_unique<StoreReader>(path, checked_.contains(path) ? StoreCheck::none : check_);
  store_path_ = path;
  checked_.insert(path);
  return *store_;
}

MeasuredSet PointSets::load(std::size_t number) {
  const Source& source = sources_[number];
  if (source.row >= 0)
    return set_of_row(open_store(source.path), source.path, static_cast<std::uint64_t>(source.row));
  PointCloud cloud = about_file(source.path, [&] { return read_points(source.path); });
  MeasuredSet set;
  set.name = source.path;
  set.item = fs::path(source.path).stem().string();
  set.x = std::move(cloud.x);
  set.y = std::move(cloud.y);
  set.z = std::move(cloud.z);
  set.normals = std::move(cloud.normals);
  set_density(std::move(cloud.density), set);
  return set;
}

double MeasuredSurface::area() const {
  if (kind == Kind::plane) return 1;
  if (kind == Kind::sphere) return 4 * std::numbers::pi;
  return mesh.total_area * mesh.unit * mesh.unit;
}

MeasuredSurfaces::MeasuredSurfaces(std::string argument) : argument_(std::move(argument)) {
  MeshFormat format{};
  is_collection_ =
      argument_ != "plane" && argument_ != "sphere" &&
      (fs::is_directory(argument_) || (!mesh_format_of(argument_, format) && !find_packed(argument_)));
}

PreparedMesh MeasuredSurfaces::load_item(const std::string& id) {
  if (items_.empty())
    for (PlanItem& item : collect_inputs({argument_}).items) {
      std::string name = item.id;
      items_.emplace(std::move(name), std::move(item));
    }
  const auto found = items_.find(id);
  if (found == items_.end())
    throw UsageError(fmt::format(
        "--surface: `{}` has no item `{}`: give the input of the store, or the mesh itself", argument_, id));
  const PlanItem& item = found->second;
  return about_file(item.path.string(), [&] {
    if (!item.known_format) throw UsageError("`" + item.path.string() + "` is no mesh file");
    return prepare_mesh(ModelBytes(item).mesh());
  });
}

void MeasuredSurfaces::load(const MeasuredSet& set) {
  const std::string& wanted = is_collection_ ? set.item : argument_;
  if (surface_ && loaded_ == wanted) return;
  auto surface = std::make_unique<MeasuredSurface>();
  if (argument_ == "plane") {
    surface->kind = MeasuredSurface::Kind::plane;
  } else if (argument_ == "sphere") {
    surface->kind = MeasuredSurface::Kind::sphere;
  } else {
    surface->mesh = is_collection_ ? load_item(set.item) : load_mesh(argument_);
    const PreparedMesh& mesh = surface->mesh;
    surface->locator = std::make_unique<SurfaceLocator>(device_, mesh.x, mesh.y, mesh.z, mesh.triangles);
  }
  surface_ = std::move(surface);
  loaded_ = wanted;
}

namespace {

constexpr double flat_tolerance = 1e-4;  // for the square and the sphere, whose points may be float32
constexpr double mesh_tolerance = 1e-3;  // for meshes, over their diagonal
constexpr std::size_t few_of = 100;      // one point in this many may be farther

void check_plane(const MeasuredSet& set) {
  for (std::size_t i = 0; i < set.count(); ++i)
    if (!(set.x[i] >= 0 && set.x[i] <= 1 && set.y[i] >= 0 && set.y[i] <= 1 &&
          std::abs(set.z[i]) <= flat_tolerance))
      throw UsageError(fmt::format("point {} of {} is ({}, {}, {}): not in the unit square", i, set.name,
                                   set.x[i], set.y[i], set.z[i]));
}

void pull_to_sphere(MeasuredSet& set) {
  for (std::size_t i = 0; i < set.count(); ++i) {
    const double length = std::sqrt(set.x[i] * set.x[i] + set.y[i] * set.y[i] + set.z[i] * set.z[i]);
    if (!(std::abs(length - 1) <= flat_tolerance))
      throw UsageError(
          fmt::format("point {} of {} lies {} from the origin: not on the unit sphere", i, set.name, length));
    set.x[i] /= length;
    set.y[i] /= length;
    set.z[i] /= length;
  }
}

void check_mesh(const MeasuredSet& set, const MeasuredSurface& surface) {
  const SurfaceLocations found = locate_points(*surface.locator, working_points(set, surface.mesh));
  const double diagonal = surface.mesh.diagonal / surface.mesh.unit;
  const auto far = static_cast<std::size_t>(
      std::count_if(found.distance.begin(), found.distance.end(),
                    [&](double distance) { return distance > mesh_tolerance * diagonal; }));
  if (few_of * far > set.count())
    throw UsageError(
        fmt::format("{} of {} points of {} lie farther from the surface than 0.1 % of its diagonal (the "
                    "farthest {:.3g} %): is it the surface that they were sampled from?",
                    far, set.count(), set.name,
                    100 * *std::max_element(found.distance.begin(), found.distance.end()) / diagonal));
}

}  // namespace

const MeasuredSurface& MeasuredSurfaces::of(MeasuredSet& set) {
  load(set);
  switch (surface_->kind) {
    case MeasuredSurface::Kind::plane:
      check_plane(set);
      break;
    case MeasuredSurface::Kind::sphere:
      pull_to_sphere(set);
      break;
    case MeasuredSurface::Kind::mesh:
      check_mesh(set, *surface_);
      break;
  }
  return *surface_;
}

std::vector<double> working_points(const MeasuredSet& set, const PreparedMesh& mesh) {
  std::vector<double> points;
  points.reserve(3 * set.count());
  for (std::size_t i = 0; i < set.count(); ++i) {
    const Vector3 p = to_working(mesh, {set.x[i], set.y[i], set.z[i]});
    points.insert(points.end(), {p.x, p.y, p.z});
  }
  return points;
}

PolygonMesh read_model_mesh(const std::string& path) {
  return about_file(path, [&] {
    const PackedFile packed = find_packed(path);
    MeshFormat format{};
    if (!mesh_format_of(packed ? packed.facts().name : path, format))
      throw UsageError("`" + path + "` is no " + mesh_extensions("or") + " file");
    return ModelBytes({path, packed, format}).mesh();
  });
}

PreparedMesh load_mesh(const std::string& path) {
  const PolygonMesh mesh = read_model_mesh(path);
  return about_file(path, [&] { return prepare_mesh(mesh); });
}

}  // namespace meander
