#include "jobs/laboratory/measure_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "jobs/cli/usage_error.h"
#include "jobs/laboratory/python_program.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/box_limit.h"
#include "kernels/analyse/coverage.h"
#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/discrepancy_plane.h"
#include "kernels/analyse/discrepancy_rings.h"
#include "kernels/analyse/discrepancy_sphere.h"
#include "kernels/analyse/discrepancy_star.h"
#include "kernels/analyse/integration_error.h"
#include "kernels/analyse/mesh_distance.h"
#include "kernels/analyse/mode_errors.h"
#include "kernels/analyse/point_location.h"
#include "kernels/analyse/random_differences.h"
#include "kernels/analyse/sampled_integrands.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/analyse/spacing.h"
#include "kernels/analyse/spectrum.h"
#include "kernels/describe/laplacian_spectrum.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

constexpr std::uint32_t exact_star_limit = 1u << 14;
constexpr std::uint32_t default_modes = 30;

using Kind = MeasuredSurface::Kind;

[[noreturn]] void refuse_surface(const MeasureOptions& options, const char* possible) {
  throw UsageError("measure " + options.what + " needs --surface " + possible);
}

void require_uniform(const MeasuredSet& set, const MeasureOptions& options) {
  if (!set.density.empty())
    throw UsageError("measure " + options.what + " compares with area, but " + set.name +
                     " was sampled with a density; only `integral` and `differences` take it");
}

// The mesh that a set of uniform density lies on.
const MeasuredSurface& mesh_under(MeasuredSet& set, MeasuredSurfaces& surfaces,
                                  const MeasureOptions& options) {
  require_uniform(set, options);
  const MeasuredSurface& surface = surfaces.of(set);
  if (surface.kind != Kind::mesh) refuse_surface(options, "MESH or FOLDER");
  return surface;
}

PreparedMesh unit_square() {
  PolygonMesh square;
  square.x = {0, 1, 1, 0};
  square.y = {0, 0, 1, 1};
  square.z = {0, 0, 0, 0};
  square.corners = {0, 1, 2, 0, 2, 3};
  square.polygon_begin = {0, 3, 6};
  return prepare_mesh(square);
}

}  // namespace

Table measure_boxes(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  Table table{{{"set"}, {"points"}, {"boxes"}, {"error / random", 4}, {"limit", 4}, {"over_limit", 4}}, {}};
  BoxParameters parameters;
  parameters.boxes = options.shapes > 0 ? options.shapes : parameters.boxes;
  parameters.seed = options.seed;
  const MeasuredSurface* last = nullptr;
  std::vector<RotatedBox> boxes;
  double boundary = 0;
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    const MeasuredSurface& surface = mesh_under(set, surfaces, options);
    if (&surface != last) {
      const PreparedMesh& mesh = surface.mesh;
      boxes = random_boxes(mesh.x, mesh.y, mesh.z, mesh.triangles, parameters);
      boundary = relative_boundary(mesh.x, mesh.y, mesh.z, mesh.triangles, boxes);
    }
    last = &surface;
    if (boxes.empty())
      throw UsageError("hardly any box holds between 0.2 % and 60 % of the surface of " + set.name);
    const double error = box_error_ratio(boxes, working_points(set, surface.mesh)),
                 limit = box_error_limit(boundary, set.count());
    table.rows.push_back({set.name, set.count(), boxes.size(), error, limit, error / limit});
  }
  return table;
}

Table measure_rings(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  Table table{{{"set"}, {"points"}, {"seeds"}, {"discrepancy", 4}, {"largest distance / diagonal", 3}}, {}};
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    const MeasuredSurface& surface = mesh_under(set, surfaces, options);
    const PreparedMesh& mesh = surface.mesh;
    const SurfaceLocations found = locate_points(*surface.locator, working_points(set, mesh));
    std::vector<std::uint32_t> counts(mesh.triangle_count(), 0);
    for (const std::uint32_t t : found.triangle) ++counts[t];
    const std::vector<std::uint32_t> seeds =
        ring_seeds(mesh.triangles, options.shapes > 0 ? options.shapes : 256, options.seed);
    const ShapeDiscrepancy result = ring_discrepancy(
        mesh.triangles, triangles_around_vertices(mesh.triangles, static_cast<std::uint32_t>(mesh.x.size())),
        mesh.area, counts, seeds);
    const double farthest = *std::max_element(found.distance.begin(), found.distance.end());
    table.rows.push_back(
        {set.name, set.count(), seeds.size(), result.discrepancy, farthest * mesh.unit / mesh.diagonal});
  }
  return table;
}

Table measure_spacing(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  Table table{{{"set"},
               {"points"},
               {"min"},
               {"mean"},
               {"rho", 3},
               {"coverage radius"},
               {"coverage / mean spacing", 3},
               {"hole", 3},
               {"chamfer", 4}},
              {}};
  const PreparedMesh square = unit_square();
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    require_uniform(set, options);
    if (set.count() < 2) throw UsageError(set.name + " is one point, which has no neighbor");
    const MeasuredSurface& surface = surfaces.of(set);
    if (surface.kind == Kind::sphere) refuse_surface(options, "plane, MESH or FOLDER");
    const PreparedMesh& mesh = surface.kind == Kind::mesh ? surface.mesh : square;
    const std::vector<double> points = working_points(set, mesh);
    const Spacing spacing = spacing_of(nearest_distances(points), mesh.total_area);
    const Coverage coverage = coverage_of({mesh.x, mesh.y, mesh.z, mesh.triangles}, points, options.seed);
    table.rows.push_back({set.name, set.count(), spacing.min * mesh.unit, spacing.mean * mesh.unit,
                          spacing.rho, coverage.radius * mesh.unit,
                          coverage.radius / std::sqrt(mesh.total_area / static_cast<double>(set.count())),
                          coverage.hole, coverage.chamfer});
  }
  return table;
}

Table measure_modes(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  Table table{{{"set"}, {"points"}, {"modes"}, {"error / random", 4}}, {}};
  const std::size_t count = options.shapes > 0 ? options.shapes : default_modes;
  if (count > most_surface_modes)
    throw UsageError(
        fmt::format("measure modes takes at most {} functions: --shapes is {}", most_surface_modes, count));
  const MeasuredSurface* last = nullptr;
  std::vector<SurfaceMode> modes;
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    const MeasuredSurface& surface = mesh_under(set, surfaces, options);
    if (&surface != last) {
      try {
        modes = lowest_modes(surface.mesh, count);
      } catch (const SpectrumNotFound& error) {
        throw UsageError(fmt::format("the surface of {}: {}", set.name, error.what()));
      }
    }
    last = &surface;
    if (modes.empty()) throw UsageError("the surface of " + set.name + " has no eigenfunctions");
    const SurfaceLocations found = locate_points(*surface.locator, working_points(set, surface.mesh));
    table.rows.push_back({set.name, set.count(), modes.size(), mode_error_ratio(surface.mesh, modes, found)});
  }
  return table;
}

Table measure_discrepancy(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  ShapeParameters parameters;
  parameters.shapes = options.shapes > 0 ? options.shapes : 4096;
  parameters.seed = options.seed;
  parameters.stable_rise = 0;  // sets are compared: the same number of shapes for all
  const bool sphere = options.surface == "sphere";
  Table table;
  table.columns = {{"set"}, {"points"}};
  if (sphere)
    table.columns.insert(table.columns.end(), {{"caps"}, {"triangles"}});
  else
    table.columns.insert(table.columns.end(),
                         {{"boxes at 0"}, {"exact"}, {"triangles"}, {"quarter circles"}, {"rotated boxes"}});
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    require_uniform(set, options);
    const MeasuredSurface& surface = surfaces.of(set);
    if (surface.kind == Kind::mesh) refuse_surface(options, "plane or sphere (for meshes: boxes, rings)");
    if (sphere) {
      ShapeParameters axes = parameters;
      axes.shapes = options.shapes > 0 ? options.shapes : 200;
      table.rows.push_back(
          {set.name, set.count(), cap_discrepancy(set.x, set.y, set.z, axes).discrepancy,
           spherical_triangle_discrepancy(build_point_index(set.x, set.y, set.z), parameters).discrepancy});
      continue;
    }
    const PointIndex<2> index = build_point_index(set.x, set.y);
    StarSearchParameters search;
    search.seed = options.seed;
    const double star = set.count() <= exact_star_limit ? star_discrepancy_exact(set.x, set.y)
                                                        : star_discrepancy_search(set.x, set.y, search);
    table.rows.push_back({set.name, set.count(), star, set.count() <= exact_star_limit ? "yes" : "search",
                          triangle_discrepancy(index, parameters).discrepancy,
                          quarter_circle_discrepancy(set.x, set.y),
                          rotated_box_discrepancy(index, parameters).discrepancy});
  }
  return table;
}

// ---- integration -----------------------------------------------------------------------------------------

// Errors over the sets, by integrand and number of points; prefixes of progressive sets are sets too.
Table measure_integral(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  struct Errors {
    std::string integrand;
    std::size_t points;
    std::vector<double> errors;  // signed
  };
  std::vector<Errors> groups;
  const auto group = [&](const std::string& name, std::size_t points) -> Errors& {
    for (Errors& g : groups)
      if (g.integrand == name && g.points == points) return g;
    return groups.emplace_back(Errors{name, points, {}});
  };
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    const MeasuredSurface& surface = surfaces.of(set);
    if (surface.kind == Kind::sphere) refuse_surface(options, "plane, MESH or FOLDER");
    const bool plane = surface.kind == Kind::plane;
    for (const SampledIntegrand& integrand :
         plane ? plane_integrands(set.x, set.y)
               : mesh_integrands(surface.mesh, working_points(set, surface.mesh))) {
      const auto add = [&](std::size_t n) {
        const std::span<const double> density(set.density);
        const double mean =
            mean_estimate(std::span(integrand.values).first(n), density.first(std::min(n, density.size())));
        group(integrand.name, n).errors.push_back(mean - integrand.mean);
      };
      if (set.progressive)
        for (std::size_t n = 16; n < set.count(); n *= 2) add(n);
      add(set.count());
    }
  }
  std::stable_sort(groups.begin(), groups.end(), [](const Errors& a, const Errors& b) {
    return a.integrand != b.integrand ? a.integrand < b.integrand : a.points < b.points;
  });
  Table table{{{"integrand"},
               {"points"},
               {"sets"},
               {"RMS error"},
               {"standard deviation"},
               {"largest"},
               {"slope", 3},
               {"its error", 2}},
              {}};
  for (std::size_t begin = 0, end = 0; begin < groups.size(); begin = end) {
    std::vector<double> counts, errors;
    for (end = begin; end < groups.size() && groups[end].integrand == groups[begin].integrand; ++end) {
      const Errors& g = groups[end];
      const ErrorSummary summary = summarize_errors(g.errors);
      table.rows.push_back(
          {g.integrand, g.points, g.errors.size(), summary.rms, TableCell(), summary.largest});
      if (g.errors.size() > 1) table.rows.back()[4] = summary.standard_deviation;
      if (summary.rms > 0) {
        counts.push_back(static_cast<double>(g.points));
        errors.push_back(summary.rms);
      }
    }
    if (counts.size() < 2 || counts.front() == counts.back()) continue;
    const SlopeFit fit = fit_slope(counts, errors);
    table.rows.back().push_back(fit.slope);
    if (counts.size() > 2) table.rows.back().push_back(fit.standard_error);
  }
  return table;
}

// ---- spectra ---------------------------------------------------------------------------------------------

namespace {

void require_count(const MeasuredSet& set, std::size_t count, const MeasureOptions& options) {
  if (set.count() != count)
    throw UsageError(
        fmt::format("measure {} averages over sets of one size: the first has {} points, {} has {}",
                    options.what, count, set.name, set.count()));
}

Table profile_table(const RadialProfile& profile, const char* radius_name, double scale) {
  Table table{{{radius_name, 4}, {"mean", 4}, {"anisotropy dB", 3}, {"bins"}}, {}};
  for (std::size_t k = 0; k < profile.rings(); ++k)
    if (profile.reliable(k))
      table.rows.push_back(
          {profile.radius[k] * scale, profile.mean[k], profile.anisotropy_db[k], profile.bins[k]});
  return table;
}

// Black 0, white 2. extent: half of the width.
void draw_map(const MeasureOptions& options, std::span<const double> values, std::size_t side, double extent,
              const char* unit) {
  if (options.picture.empty()) return;
  JsonWriter json;
  json.begin_object();
  json.member("kind", "map");
  json.member("title", options.what);
  json.member("x", unit);
  json.member("y", unit);
  json.member("side", std::uint64_t{side});
  json.member("extent", extent);
  json.member("upper", 2.0);
  json.member("format", "png");
  json.list("values", values);
  json.end_object();
  replace_file(options.picture, draw_plot(json.text()));
}

}  // namespace

Table measure_spectrum(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  std::optional<PowerSpectrum> spectrum;
  std::size_t count = 0;
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    if (!spectrum) {
      count = set.count();
      spectrum = make_power_spectrum(affordable_radius(count));
    }
    require_count(set, count, options);
    require_uniform(set, options);
    if (surfaces.of(set).kind != Kind::plane) refuse_surface(options, "plane (on meshes: differences)");
    add_periodogram(*spectrum, set.x, set.y);
  }
  std::vector<double> power(spectrum->sum);
  for (double& p : power) p /= spectrum->sets;
  power[power.size() / 2] = 0;  // f = 0 is the number of points
  draw_map(options, power, spectrum->side(), 0.5 * static_cast<double>(spectrum->side()), "frequency");
  return profile_table(radial_power(*spectrum), "f / sqrt(n)", 1 / std::sqrt(static_cast<double>(count)));
}

namespace {

std::vector<double> interleaved(const MeasuredSet& set) {
  std::vector<double> points;
  for (std::size_t i = 0; i < set.count(); ++i) points.insert(points.end(), {set.x[i], set.y[i], set.z[i]});
  return points;
}

// The samples of a set on the surface `mesh`, which is the unit square for sets of the plane.
FieldSamples field_samples(const MeasuredSet& set, const PreparedMesh& mesh, bool plane) {
  FieldSamples samples;
  samples.points = working_points(set, mesh);
  samples.density = set.density.empty() ? std::vector<double>(set.count(), 1) : set.density;
  samples.axes = set.axes;
  samples.ratio = set.ratio;
  if (!plane) {
    samples.normals.assign(set.normals.begin(), set.normals.end());
    return samples;
  }
  for (std::size_t i = 0; i < set.count(); ++i) {
    samples.normals.insert(samples.normals.end(), {0, 0, 1});
    samples.frames.insert(samples.frames.end(), {1, 0, 0});
  }
  return samples;
}

}  // namespace

Table measure_differences(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  constexpr std::uint32_t random_sets = 8;
  DifferenceMap map = make_difference_map(), expected = make_difference_map();
  std::size_t count = 0;
  double integral = 0;
  bool is_anisotropic = false, is_field = false;
  const bool plane = options.surface == "plane";
  const MeasuredSurface* last = nullptr;
  std::vector<FieldSamples> fields;  // of sets with densities or tensors
  const PreparedMesh square = unit_square();
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    if (number == 0) {
      count = set.count();
      integral = set.measure;
      is_anisotropic = !set.ratio.empty();
      is_field = is_anisotropic || !set.density.empty();
    }
    require_count(set, count, options);
    if (count < 2) throw UsageError(set.name + " is one point, which has no differences");
    if (is_field != (!set.ratio.empty() || !set.density.empty()) || is_anisotropic != !set.ratio.empty())
      throw UsageError("measure differences averages over sets of one density and one tensor field: " +
                       set.name + " has others");
    const MeasuredSurface& surface = surfaces.of(set);
    if (surface.kind == Kind::sphere) refuse_surface(options, "plane, MESH or FOLDER");
    if (!plane && set.normals.empty())
      throw UsageError(set.name + " has no normals, which measure differences needs on meshes");
    if (last != nullptr && last != &surface)
      throw UsageError("measure differences averages over sets of one surface: " + set.name + " has another");
    if (!plane && !is_field && last == nullptr)
      add_random_surface_differences(expected, surface.mesh, count, options.seed, random_sets);
    last = &surface;
    const double spacing = std::sqrt(surface.area() / static_cast<double>(count));
    if (is_field) {
      fields.push_back(field_samples(set, plane ? square : surface.mesh, plane));
    } else if (plane) {
      add_differences(map, set.x, set.y, spacing);
    } else {
      const std::vector<double> normals(set.normals.begin(), set.normals.end());
      add_surface_differences(map, interleaved(set), normals, std::vector<double>(count, spacing));
    }
  }
  if (is_field) {
    FieldSamples all;
    for (const FieldSamples& set : fields) all.append(set);
    const PreparedMesh& mesh = plane ? square : last->mesh;
    const SampledField field(mesh, std::move(all), count, integral / (mesh.unit * mesh.unit), options.seed);
    for (const FieldSamples& set : fields) field.add(map, set);
    field.add_random(expected, options.seed, random_sets);
  } else if (plane) {
    const double side = std::sqrt(static_cast<double>(count));  // of the square in units of the mean spacing
    expected = expected_differences(map.parameters, count, side, side);
  }
  const std::vector<double> ratio = normalized_differences(map, expected);
  draw_map(options, ratio, map.side(), 0.5 * static_cast<double>(map.side()) * map.cell(),
           "difference / spacing");
  return profile_table(radial_differences(map, ratio, 2), "distance / spacing", map.cell());
}

// ---- distance between meshes -----------------------------------------------------------------------------

Table measure_distance(const MeasureOptions& options) {
  if (options.inputs.size() != 2) throw UsageError("measure distance compares two meshes: give two as INPUT");
  std::array<std::vector<double>, 6> at;  // x, y, z of both, in the file's units
  std::array<PreparedMesh, 2> meshes = {load_mesh(options.inputs[0]), load_mesh(options.inputs[1])};
  std::array<TriangleSpans, 2> spans;
  for (std::size_t m = 0; m < 2; ++m) {
    const PreparedMesh& mesh = meshes[m];
    for (std::size_t v = 0; v < mesh.x.size(); ++v) {
      const Vector3 p = to_file(mesh, mesh.position(static_cast<std::uint32_t>(v)));
      at[3 * m].push_back(p.x);
      at[3 * m + 1].push_back(p.y);
      at[3 * m + 2].push_back(p.z);
    }
    spans[m] = {at[3 * m], at[3 * m + 1], at[3 * m + 2], mesh.triangles};
  }
  MeshDistanceParameters parameters;
  parameters.samples = options.samples > 0 ? options.samples : 100000;
  parameters.seed = options.seed;
  const EmbreeDevice device;
  const MeshDistance distance = mesh_distance(device, spans[0], spans[1], parameters);
  Table table{{{"from"}, {"to"}, {"samples"}, {"mean"}, {"RMS"}, {"max"}, {"mean %"}, {"RMS %"}, {"max %"}},
              {}};
  const auto add = [&](const std::string& from, const std::string& to, const OneSidedDistance& d) {
    table.rows.push_back({from, to, d.samples, d.mean, d.rms, d.max, distance.percent(d.mean),
                          distance.percent(d.rms), distance.percent(d.max)});
  };
  add(options.inputs[0], options.inputs[1], distance.forward);
  add(options.inputs[1], options.inputs[0], distance.backward);
  return table;
}

}  // namespace meander
