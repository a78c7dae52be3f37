// Measures of point sets.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "jobs/laboratory/functions/laboratory_functions.h"
#include "jobs/python/array_mesh.h"
#include "kernels/analyse/box_limit.h"
#include "kernels/analyse/coverage.h"
#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/discrepancy_plane.h"
#include "kernels/analyse/discrepancy_star.h"
#include "kernels/analyse/mode_errors.h"
#include "kernels/analyse/spacing.h"
#include "kernels/analyse/spectrum.h"
#include "kernels/describe/laplacian_spectrum.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/pointset/planar_points.h"
#include "kernels/rays/embree_locator.h"
#include "kernels/sample/point_frames.h"

namespace meander {

std::vector<RotatedBox> boxes_on(const PreparedMesh& surface, const LaboratoryArguments& given) {
  BoxParameters parameters;
  parameters.boxes = static_cast<std::uint32_t>(given.whole("boxes", parameters.boxes));
  parameters.seed = given.whole("seed", parameters.seed);
  std::vector<RotatedBox> boxes =
      random_boxes(surface.x, surface.y, surface.z, surface.triangles, parameters);
  if (boxes.empty())
    throw ItemError(Status::zero_area, "hardly any box holds between 0.2 % and 60 % of the surface");
  return boxes;
}

namespace {

PlanarMethod method_named(const std::string& name) {
  const std::optional<PlanarMethod> method = planar_method(name);
  if (!method) throw std::invalid_argument("there is no method `" + name + "`");
  return *method;
}

// Takes method, n, seed, and leaves (per point, for hilbert-vertex). Returns points (n, 2) in the unit
// square; deterministic: 1 if the seed changes nothing.
LaboratoryResult points_in_square(const LaboratoryArguments& given) {
  const PlanarMethod method = method_named(given.text("method"));
  PlanarParameters parameters;
  parameters.leaves_per_point = given.real("leaves", parameters.leaves_per_point);
  const PlanarPoints made =
      planar_points(method, static_cast<std::uint32_t>(given.whole("n")), given.whole("seed", 1), parameters);
  std::vector<double> points;
  for (std::size_t i = 0; i < made.count(); ++i) points.insert(points.end(), {made.x[i], made.y[i]});
  LaboratoryResult result;
  result.add("deterministic", is_deterministic(method) ? 1 : 0);
  result.add("points", std::move(points), 2);
  return result;
}

ShapeParameters shapes_of(const LaboratoryArguments& given, std::uint32_t otherwise) {
  ShapeParameters shapes;
  shapes.shapes = static_cast<std::uint32_t>(given.whole("shapes", otherwise));
  shapes.seed = given.whole("seed", 1);
  shapes.stable_rise = 0;  // sets are compared: the same number of shapes for all
  return shapes;
}

// Takes points (n, 2) in the unit square, shapes and seed. Returns the maximum errors over boxes at the
// origin (exact up to 16,384 points), triangles at the origin and quarter circles.
LaboratoryResult square_discrepancy(const LaboratoryArguments& given) {
  constexpr std::size_t exact_limit = std::size_t{1} << 14;
  const std::vector<double> x = given.column("points", 2, 0), y = given.column("points", 2, 1);
  const ShapeParameters shapes = shapes_of(given, 4096);
  StarSearchParameters search;
  search.seed = shapes.seed;
  LaboratoryResult result;
  result.add("boxes",
             x.size() <= exact_limit ? star_discrepancy_exact(x, y) : star_discrepancy_search(x, y, search));
  result.add("triangles", triangle_discrepancy(build_point_index(x, y), shapes).discrepancy);
  result.add("circles", quarter_circle_discrepancy(x, y));
  return result;
}

// Takes a mesh, points (sets x n, 3), sets, boxes and seed. Returns ratios (sets,): the root mean square
// error of each set over random rotated boxes, the same for all, over that of random points; limit, the least
// that is known to be possible for as many points.
LaboratoryResult box_errors_on_mesh(const LaboratoryArguments& given) {
  const PreparedMesh surface = prepare_mesh(given.mesh());
  const std::vector<RotatedBox> boxes = boxes_on(surface, given);
  const std::span<const double> points = given.reals("points", 3);
  require_finite(points, "points");
  const std::size_t sets = given.whole("sets", 1), each = sets > 0 ? points.size() / 3 / sets : 0;
  if (each == 0 || 3 * each * sets != points.size())
    throw std::invalid_argument("points must be those of `sets` sets of equal size");
  std::vector<double> ratios;
  for (std::size_t s = 0; s < sets; ++s)
    ratios.push_back(box_error_ratio(boxes, working_points(points.subspan(3 * each * s, 3 * each), surface)));
  LaboratoryResult result;
  result.add("ratios", std::move(ratios));
  result.add(
      "limit",
      box_error_limit(relative_boundary(surface.x, surface.y, surface.z, surface.triangles, boxes), each));
  return result;
}

// Takes a mesh, points (n, 3), n >= 2, in its coordinates, and seed. Returns the least and the mean distance
// to the nearest other point, and the coverage radius, in units of the mesh; rho, hole and chamfer, over
// those of the hexagonal lattice: as `measure spacing`.
LaboratoryResult spacing_on_mesh(const LaboratoryArguments& given) {
  const PreparedMesh surface = prepare_mesh(given.mesh());
  const std::span<const double> at = given.reals("points", 3);
  require_finite(at, "points");
  const std::vector<double> points = working_points(at, surface);
  const Spacing spacing = spacing_of(nearest_distances(points), surface.total_area);
  const Coverage coverage =
      coverage_of({surface.x, surface.y, surface.z, surface.triangles}, points, given.whole("seed", 1));
  LaboratoryResult result;
  result.add("least", spacing.min * surface.unit);
  result.add("mean", spacing.mean * surface.unit);
  result.add("rho", spacing.rho);
  result.add("coverage", coverage.radius * surface.unit);
  result.add("hole", coverage.hole);
  result.add("chamfer", coverage.chamfer);
  return result;
}

// Takes a mesh, points (n, 3) in its coordinates, and modes. Returns ratio, the root mean square error of the
// integrals of the lowest eigenfunctions over that of random points; modes, the number of functions.
LaboratoryResult mode_errors(const LaboratoryArguments& given) {
  const double count = given.real("modes");
  if (!(count >= 0 && count <= most_surface_modes))
    throw std::invalid_argument(fmt::format("modes is {}: 0 to {}", count, most_surface_modes));
  const PreparedMesh surface = prepare_mesh(given.mesh());
  const std::span<const double> at = given.reals("points", 3);
  require_finite(at, "points");
  const EmbreeDevice device;
  const SurfaceLocator locator(device, surface.x, surface.y, surface.z, surface.triangles);
  std::vector<SurfaceMode> modes;
  try {
    modes = lowest_modes(surface, static_cast<std::size_t>(count));
  } catch (const SpectrumNotFound& error) {
    throw ItemError(Status::internal, error.what());
  }
  if (modes.empty()) throw ItemError(Status::zero_area, "the surface has no eigenfunctions");
  LaboratoryResult result;
  result.add("ratio", mode_error_ratio(surface, modes, locate_points(locator, working_points(at, surface))));
  result.add("modes", static_cast<double>(modes.size()));
  return result;
}

// Takes points (n, 2) in the unit square that follow a density (of planar_density_names), shapes and seed.
// Returns the maximum error over boxes at the origin, against their exact shares of the density.
LaboratoryResult density_discrepancy(const LaboratoryArguments& given) {
  const std::string name = given.text("density");
  const std::optional<PlanarDensity> density = planar_density(name);
  if (!density) throw std::invalid_argument("there is no density `" + name + "`");
  LaboratoryResult result;
  result.add("boxes", density_box_discrepancy(
                          build_point_index(given.column("points", 2, 0), given.column("points", 2, 1)),
                          *density, shapes_of(given, 4096))
                          .discrepancy);
  return result;
}

// Takes points (n, 2) in the unit square and radius. Returns power (2 radius + 1, 2 radius + 1) at whole
// frequencies, white noise being 1; rows by the frequency in y from -radius.
LaboratoryResult power_spectrum(const LaboratoryArguments& given) {
  PowerSpectrum spectrum = make_power_spectrum(static_cast<std::uint32_t>(given.whole("radius")));
  add_periodogram(spectrum, given.column("points", 2, 0), given.column("points", 2, 1));
  LaboratoryResult result;
  const std::size_t side = spectrum.side();
  result.add("power", std::move(spectrum.sum), side);
  return result;
}

// Takes points (n, 3), normals (n, 3), spacing (n,), the wanted distance at each point, range in spacings,
// cells, and optional frames (n, 3), the first axis of the map at each point; else a random direction by
// seed. Returns pairs (cells, cells) by their difference in units of spacings, over the number of points, and
// the average for independent points of the same density, to divide by.
LaboratoryResult differences(const LaboratoryArguments& given) {
  DifferenceParameters parameters;
  parameters.range = given.real("range", parameters.range);
  parameters.cells = static_cast<std::uint32_t>(given.whole("cells", parameters.cells));
  SurfaceDifferenceParameters surface;
  surface.seed = given.whole("seed", surface.seed);
  DifferenceMap map = make_difference_map(parameters);
  const std::span<const double> spacing = given.reals("spacing");
  add_surface_differences(map, given.reals("points", 3), given.reals("normals", 3), spacing,
                          given.has("frames") ? given.reals("frames", 3) : std::span<const double>{},
                          surface);
  for (double& pairs : map.sum) pairs /= static_cast<double>(spacing.size());
  LaboratoryResult result;
  const std::size_t side = map.side();
  result.add("pairs", std::move(map.sum), side);
  return result;
}

// Takes map (side^2,), symmetric about its middle, and first and width of its rings in cells. Returns radius
// (cells), mean, anisotropy (dB) and bins of each ring; rings with too few bins are left out.
LaboratoryResult radial(const LaboratoryArguments& given) {
  const std::span<const double> map = given.reals("map");
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(map.size()))));
  RadialProfile profile = radial_profile(map, side, given.real("first", 0), given.real("width", 1));
  std::size_t kept = 0;
  for (std::size_t k = 0; k < profile.rings(); ++k) {
    if (!profile.reliable(k)) continue;
    profile.radius[kept] = profile.radius[k];
    profile.mean[kept] = profile.mean[k];
    profile.anisotropy_db[kept] = profile.anisotropy_db[k];
    profile.bins[kept++] = profile.bins[k];
  }
  for (std::vector<double>* values : {&profile.radius, &profile.mean, &profile.anisotropy_db})
    values->resize(kept);
  profile.bins.resize(kept);
  LaboratoryResult result;
  result.add("radius", std::move(profile.radius));
  result.add("mean", std::move(profile.mean));
  result.add("anisotropy", std::move(profile.anisotropy_db));
  result.add("bins", std::move(profile.bins));
  return result;
}

constexpr LaboratoryFunction measure_table[] = {{"points_in_square", points_in_square},
                                                {"square_discrepancy", square_discrepancy},
                                                {"box_errors", box_errors_on_mesh},
                                                {"spacing_on_mesh", spacing_on_mesh},
                                                {"mode_errors", mode_errors},
                                                {"density_discrepancy", density_discrepancy},
                                                {"power_spectrum", power_spectrum},
                                                {"differences", differences},
                                                {"radial", radial}};

}  // namespace

const std::span<const LaboratoryFunction> measure_functions = measure_table;

}  // namespace meander
