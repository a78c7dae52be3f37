// meander measure: quality of point sets of any origin.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/plot/heat_map.h"
#include "io/plot/png_writer.h"
#include "io/table/csv_writer.h"
#include "io/table/json_table.h"
#include "io/table/text_table.h"
#include "jobs/command_line.h"
#include "jobs/exit_status.h"
#include "jobs/inputs.h"
#include "jobs/laboratory/commands.h"
#include "jobs/laboratory/measured_sets.h"
#include "jobs/output_guard.h"
#include "jobs/store_items.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/differential_domain.h"
#include "kernels/analyse/discrepancy_plane.h"
#include "kernels/analyse/discrepancy_rings.h"
#include "kernels/analyse/discrepancy_sphere.h"
#include "kernels/analyse/discrepancy_star.h"
#include "kernels/analyse/integration_error.h"
#include "kernels/analyse/mesh_distance.h"
#include "kernels/analyse/point_location.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/analyse/spacing.h"
#include "kernels/analyse/spectrum.h"
#include "kernels/core/parallel.h"
#include "kernels/core/random.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

struct MeasureOptions {
  std::string what;
  std::vector<std::string> inputs;
  std::string surface, csv, picture;
  std::uint32_t shapes = 0;  // 0: the measure's own default
  std::uint64_t seed = 1;
  bool seed_given = false;
  std::uint64_t samples = 0;  // of distance, on each surface; 0: 100,000
  bool json = false;
  StoreCheck check = StoreCheck::every_byte;
};

constexpr std::uint32_t exact_star_limit = 1u << 14;

using Kind = MeasuredSurface::Kind;

[[noreturn]] void refuse_surface(const MeasureOptions& options, const char* possible) {
  throw UsageError("measure " + options.what + " needs --surface " + possible);
}

void require_uniform(const MeasuredSet& set, const MeasureOptions& options) {
  if (!set.density.empty())
    throw UsageError("measure " + options.what + " compares with area, but " + set.name +
                     " was sampled with a density; only `integral` weights it");
}

// ---- measures: each makes one table ----------------------------------------------------------------------

Table measure_boxes(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  Table table{{{"set"}, {"points"}, {"boxes"}, {"error / random", 4}}, {}};
  BoxParameters parameters;
  parameters.boxes = options.shapes > 0 ? options.shapes : parameters.boxes;
  parameters.seed = options.seed;
  const MeasuredSurface* last = nullptr;
  std::vector<RotatedBox> boxes;
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    require_uniform(set, options);
    const MeasuredSurface& surface = surfaces.of(set);
    if (surface.kind != Kind::mesh) refuse_surface(options, "MESH or FOLDER");
    if (&surface != last)
      boxes =
          random_boxes(surface.mesh.x, surface.mesh.y, surface.mesh.z, surface.mesh.triangles, parameters);
    last = &surface;
    if (boxes.empty())
      throw UsageError("hardly any box holds between 0.2 % and 60 % of the surface of " + set.name);
    table.rows.push_back(
        {set.name, set.count(), boxes.size(), box_error_ratio(boxes, working_points(set, surface.mesh))});
  }
  return table;
}

Table measure_rings(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  Table table{{{"set"}, {"points"}, {"seeds"}, {"discrepancy", 4}, {"largest distance / diagonal", 3}}, {}};
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    require_uniform(set, options);
    const MeasuredSurface& surface = surfaces.of(set);
    if (surface.kind != Kind::mesh) refuse_surface(options, "MESH or FOLDER");
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
               {"coverage / mean spacing", 3}},
              {}};
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    require_uniform(set, options);
    if (set.count() < 2) throw UsageError(set.name + " is one point, which has no neighbour");
    const MeasuredSurface& surface = surfaces.of(set);
    std::vector<double> points, reference;
    const std::uint64_t reference_count = std::max<std::uint64_t>(20000, 20 * set.count());
    double unit = 1;
    if (surface.kind == Kind::mesh) {
      points = working_points(set, surface.mesh);
      unit = surface.mesh.unit;
      reference = area_samples({surface.mesh.x, surface.mesh.y, surface.mesh.z, surface.mesh.triangles},
                               reference_count, options.seed);
    } else if (surface.kind == Kind::plane) {
      const auto side =
          static_cast<std::uint64_t>(std::ceil(std::sqrt(static_cast<double>(reference_count))));
      for (std::uint64_t i = 0; i < side * side; ++i) {
        reference.push_back((static_cast<double>(i % side) + 0.5) / static_cast<double>(side));
        reference.push_back((static_cast<double>(i / side) + 0.5) / static_cast<double>(side));
        reference.push_back(0);
      }
      for (std::size_t i = 0; i < set.count(); ++i) points.insert(points.end(), {set.x[i], set.y[i], 0.0});
    } else {
      refuse_surface(options, "plane, MESH or FOLDER");
    }
    const double area = surface.area() / (unit * unit);
    const Spacing spacing = spacing_of(nearest_distances(points), area);
    const double coverage = coverage_radius(points, reference);
    table.rows.push_back({set.name, set.count(), spacing.min * unit, spacing.mean * unit, spacing.rho,
                          coverage * unit, coverage / std::sqrt(area / static_cast<double>(set.count()))});
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

// An integrand at the points of a set, and its exact mean over the surface.
struct SetIntegrand {
  std::string name;
  std::vector<double> values;
  double exact = 0;
};

// On the plane the standard integrands; on meshes a quadratic polynomial (its integral over a triangle is
// area x mean at the edges' midpoints) and the side of a plane through the box centre (clipped exactly).
std::vector<SetIntegrand> integrands_of(const MeasuredSet& set, const MeasuredSurface& surface) {
  std::vector<SetIntegrand> result;
  if (surface.kind == Kind::plane) {
    for (const Integrand& f : standard_integrands()) {
      if (f.name == "weighted") continue;  // needs sets of its own density
      SetIntegrand integrand{std::string(f.name), {}, f.mean};
      for (std::size_t i = 0; i < set.count(); ++i) integrand.values.push_back(f.value(set.x[i], set.y[i]));
      result.push_back(std::move(integrand));
    }
    return result;
  }
  const PreparedMesh& mesh = surface.mesh;
  const std::vector<double> points = working_points(set, mesh);
  const auto smooth = [](Vector3 p) { return p.x * p.x + 0.5 * p.y * p.z - 0.3 * p.z + 0.7 * p.y; };
  SetIntegrand polynomial{"quadratic", {}, 0}, side{"half-space", {}, 0};
  double total = 0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Vector3 a = mesh.position(mesh.triangles[3 * t]), b = mesh.position(mesh.triangles[3 * t + 1]),
                  c = mesh.position(mesh.triangles[3 * t + 2]);
    total += mesh.area[t] * (smooth(0.5 * (a + b)) + smooth(0.5 * (b + c)) + smooth(0.5 * (c + a))) / 3;
  }
  polynomial.exact = total / mesh.total_area;
  // The half-space as a box that reaches far beyond the mesh on one side (working coordinates lie in [-1,
  // 1]).
  const Vector3 normal = (1 / std::sqrt(14.0)) * Vector3{1, 2, 3};
  const Vector3 across = (1 / std::sqrt(5.0)) * Vector3{2, -1, 0};
  RotatedBox half;
  half.axes = {normal, across, cross(normal, across)};
  half.half = {8, 8, 8};
  half.centre = 8.0 * normal;
  side.exact = area_in_box(mesh.x, mesh.y, mesh.z, mesh.triangles, half) / mesh.total_area;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const Vector3 p{points[i], points[i + 1], points[i + 2]};
    polynomial.values.push_back(smooth(p));
    side.values.push_back(dot(normal, p) >= 0 ? 1 : 0);
  }
  return {std::move(polynomial), std::move(side)};
}

// The mean of the integrand over the surface as the first n samples give it.
double estimate(const SetIntegrand& integrand, const MeasuredSet& set, std::size_t n) {
  const std::span<const double> values = std::span(integrand.values).first(n);
  if (set.density.empty()) return blocked_sum(values) / static_cast<double>(n);
  // Self-normalised weights 1 / density: the measure of the whole surface need not be known.
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < n; ++i) {
    sum += values[i] / static_cast<double>(set.density[i]);
    weights += 1 / static_cast<double>(set.density[i]);
  }
  return sum / weights;
}

// Errors over the sets, by integrand and number of points; prefixes of progressive sets count too.
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
    for (const SetIntegrand& integrand : integrands_of(set, surface)) {
      if (set.progressive)
        for (std::size_t n = 16; n < set.count(); n *= 2)
          group(integrand.name, n).errors.push_back(estimate(integrand, set, n) - integrand.exact);
      group(integrand.name, set.count())
          .errors.push_back(estimate(integrand, set, set.count()) - integrand.exact);
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
      const auto sets_counted = static_cast<double>(g.errors.size());
      double squares = 0, sum = 0, largest = 0;
      for (const double e : g.errors) {
        squares += e * e;
        sum += e;
        largest = std::max(largest, std::abs(e));
      }
      const double rms = std::sqrt(squares / sets_counted);
      table.rows.push_back({g.integrand, g.points, g.errors.size(), rms, TableCell(), largest});
      if (g.errors.size() > 1)
        table.rows.back()[4] =
            std::sqrt(std::max(0.0, squares - sum * sum / sets_counted) / (sets_counted - 1));
      if (rms > 0) {
        counts.push_back(static_cast<double>(g.points));
        errors.push_back(rms);
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

void draw_map(const MeasureOptions& options, std::span<const double> values, std::size_t side, double upper) {
  if (options.picture.empty()) return;
  HeatMapParameters look;
  look.lower = 0;
  look.upper = upper;
  look.upwards = true;
  look.pixels = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(512 / side));
  write_png(options.picture,
            heat_map(values, static_cast<std::uint32_t>(side), static_cast<std::uint32_t>(side), look));
}

// Up to 2.5 sqrt(n), as far as 10^11 multiply-adds a set (some ten seconds of a core) allow.
std::uint32_t spectrum_radius(std::size_t points) {
  const auto n = static_cast<double>(points);
  return static_cast<std::uint32_t>(
      std::clamp(std::min(2.5 * std::sqrt(n), std::sqrt(1e11 / (4 * n))), 8.0, 1024.0));
}

Table measure_spectrum(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  std::optional<PowerSpectrum> spectrum;
  std::size_t count = 0;
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    if (!spectrum) {
      count = set.count();
      spectrum = make_power_spectrum(spectrum_radius(count));
    }
    require_count(set, count, options);
    require_uniform(set, options);
    if (surfaces.of(set).kind != Kind::plane) refuse_surface(options, "plane (on meshes: differences)");
    add_periodogram(*spectrum, set.x, set.y);
  }
  std::vector<double> power(spectrum->sum);
  for (double& p : power) p /= spectrum->sets;
  power[power.size() / 2] = 0;  // f = 0 is the number of points
  draw_map(options, power, spectrum->side(), 2);
  return profile_table(radial_power(*spectrum), "f / sqrt(n)", 1 / std::sqrt(static_cast<double>(count)));
}

std::vector<double> interleaved(const MeasuredSet& set) {
  std::vector<double> points;
  for (std::size_t i = 0; i < set.count(); ++i) points.insert(points.end(), {set.x[i], set.y[i], set.z[i]});
  return points;
}

// Random sets on the same mesh, with the normals of its triangles: what differences are compared with.
void add_random_differences(DifferenceMap& map, const PreparedMesh& mesh, std::size_t count,
                            std::uint64_t seed, std::uint32_t sets) {
  std::vector<double> cumulative(mesh.triangle_count() + 1, 0);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) cumulative[t + 1] = cumulative[t] + mesh.area[t];
  const double spacing = std::sqrt(cumulative.back() / static_cast<double>(count));
  for (std::uint32_t s = 0; s < sets; ++s) {
    std::vector<double> points, normals;
    for (std::size_t i = 0; i < count; ++i) {
      const UnitPair chosen = random_pair(make_random_key(seed, {}), Stream::surface_probe, i, 2 * s),
                     inside = random_pair(make_random_key(seed, {}), Stream::surface_probe, i, 2 * s + 1);
      const auto at =
          std::upper_bound(cumulative.begin() + 1, cumulative.end() - 1, chosen.first * cumulative.back());
      const auto t = static_cast<std::size_t>(at - cumulative.begin()) - 1;
      const Vector3 a = mesh.position(mesh.triangles[3 * t]), b = mesh.position(mesh.triangles[3 * t + 1]),
                    c = mesh.position(mesh.triangles[3 * t + 2]);
      const double root = std::sqrt(inside.first), second = root * inside.second;
      const Vector3 p = (1 - root) * a + (root - second) * b + second * c, n = cross(b - a, c - a);
      points.insert(points.end(), {p.x, p.y, p.z});
      normals.insert(normals.end(), {n.x, n.y, n.z});
    }
    add_surface_differences(map, points, normals, std::vector<double>(count, spacing));
  }
}

Table measure_differences(PointSets& sets, MeasuredSurfaces& surfaces, const MeasureOptions& options) {
  constexpr std::uint32_t random_sets = 8;
  DifferenceMap map = make_difference_map(), expected = make_difference_map();
  std::size_t count = 0;
  const bool plane = options.surface == "plane";
  const MeasuredSurface* last = nullptr;
  for (std::size_t number = 0; number < sets.size(); ++number) {
    MeasuredSet set = sets.load(number);
    if (number == 0) count = set.count();
    require_count(set, count, options);
    require_uniform(set, options);
    if (count < 2) throw UsageError(set.name + " is one point, which has no differences");
    const MeasuredSurface& surface = surfaces.of(set);
    if (surface.kind == Kind::sphere) refuse_surface(options, "plane, MESH or FOLDER");
    const double spacing = std::sqrt(surface.area() / static_cast<double>(count));
    if (plane) {
      add_differences(map, set.x, set.y, spacing);
      continue;
    }
    if (set.normals.empty())
      throw UsageError(set.name + " has no normals, which measure differences needs on meshes");
    if (last != nullptr && last != &surface)
      throw UsageError("measure differences averages over sets of one surface: " + set.name + " has another");
    if (last == nullptr) add_random_differences(expected, surface.mesh, count, options.seed, random_sets);
    last = &surface;
    const std::vector<double> normals(set.normals.begin(), set.normals.end());
    add_surface_differences(map, interleaved(set), normals, std::vector<double>(count, spacing));
  }
  const double side = std::sqrt(static_cast<double>(count));  // of the square in units of the mean spacing
  if (plane) expected = expected_differences(map.parameters, count, side, side);
  const std::vector<double> ratio = normalised_differences(map, expected);
  draw_map(options, ratio, map.side(), 2);
  return profile_table(radial_differences(map, ratio, 2), "distance / spacing", map.cell());
}

// ---- distance between meshes -----------------------------------------------------------------------------

Table measure_distance(const MeasureOptions& options) {
  if (options.inputs.size() != 2) throw UsageError("measure distance compares two meshes");
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

// ---- the job ---------------------------------------------------------------------------------------------

struct Measure {
  const char* name;
  const char* help;
  Table (*table)(PointSets&, MeasuredSurfaces&, const MeasureOptions&);
  bool draws, shapes, random;  // which of --picture, --shapes, --seed mean something
};
constexpr Measure measures[] = {
    {"boxes", "error over random rotated boxes with exact areas, relative to random points (meshes)",
     measure_boxes, false, true, true},
    {"rings", "discrepancy over patches grown ring by ring, the survey's (meshes)", measure_rings, false,
     true, true},
    {"spacing", "nearest-neighbour distances, rho, coverage radius (plane, meshes)", measure_spacing, false,
     false, true},
    {"discrepancy", "boxes, triangles, quarter circles (plane); caps, triangles (sphere)",
     measure_discrepancy, false, true, true},
    {"integral", "integration error over n and its slope (plane, meshes)", measure_integral, false, false,
     false},
    {"spectrum", "radially averaged power and anisotropy over all sets (plane)", measure_spectrum, true,
     false, false},
    {"differences", "differential domain analysis over all sets (plane, meshes)", measure_differences, true,
     false, true},
    {"distance", "mean, RMS and largest distance between two meshes, both ways", nullptr, false, false, true},
};

void check_outputs(const MeasureOptions& options) {
  OutputGuard guard;
  for (const std::string& input : options.inputs) {
    guard.protect(input);
    guard.protect(input.substr(0, input.find("::")));  // FILE.h5::ITEM
  }
  guard.protect(options.surface);
  guard.check(options.csv, {FileKind::csv}, "--csv");
  guard.check(options.picture, {FileKind::png}, "--picture");
}

int measure(const MeasureOptions& options) {
  const Measure& chosen = *std::find_if(std::begin(measures), std::end(measures),
                                        [&](const Measure& m) { return options.what == m.name; });
  if (!options.picture.empty() && !chosen.draws)
    throw UsageError("measure " + options.what + " draws nothing: leave --picture out");
  if (options.samples > 0 && chosen.table != nullptr)
    throw UsageError("measure " + options.what + " takes the points that it is given: leave --samples out");
  if (options.seed_given && !chosen.random)
    throw UsageError("measure " + options.what + " draws nothing at random: leave --seed out");
  if (options.shapes > 0 && !chosen.shapes)
    throw UsageError("measure " + options.what + " has no shapes: leave --shapes out");
  check_outputs(options);
  Table table;
  if (chosen.table == nullptr) {
    if (!options.surface.empty()) throw UsageError("measure distance takes two meshes: leave --surface out");
    table = measure_distance(options);
  } else {
    if (options.surface.empty())
      throw UsageError("measure " + options.what +
                       " needs --surface: plane, sphere, a mesh file, or the folder "
                       "of a store's models");
    PointSets sets(options.inputs, options.check);
    MeasuredSurfaces surfaces(options.surface);
    table = chosen.table(sets, surfaces, options);
  }
  if (!options.csv.empty()) replace_file(options.csv, csv_text(table));
  if (options.json) {
    JsonWriter json;
    json.begin_object();
    json.member("measure", options.what);
    json.member("surface", options.surface);
    json.member("seed", options.seed);
    json.key("results");
    write_table(json, table);
    json.end_object();
    fmt::print("{}\n", json.text());
  } else {
    fmt::print("{}", text_table(table));
  }
  return exit_done;
}

}  // namespace

JobFunction add_measure_job(CLI::App& program) {
  CLI::App* command = program.add_subcommand("measure", "How good point sets are, ours or anybody's");
  auto options = std::make_shared<MeasureOptions>();
  std::vector<std::string> names;
  std::string help = "What to measure:";
  for (const Measure& m : measures) {
    names.push_back(m.name);
    help += fmt::format("\n  {}: {}", m.name, m.help);
  }
  command->add_option("WHAT", options->what, help)->required()->check(OneOf(names));
  command
      ->add_option(
          "INPUT", options->inputs,
          "Stores (FILE.h5: all ok items, FILE.h5::ITEM: one), point files (.ply .xyz .txt .csv .pts "
          ".off); two meshes for distance")
      ->required();
  command->add_option(
      "--surface", options->surface,
      "Where the points lie: plane (unit square), sphere (unit sphere), a mesh, or the folder of "
      "a store's models");
  command
      ->add_option(
          "--shapes", options->shapes,
          "Test shapes, 1 to 200000 (default: 1000 boxes, 256 ring seeds, 4096 planar shapes, 200 cap axes)")
      ->check(CLI::Range(1, 200000));
  command->add_option("--seed", options->seed, "Seed of shapes and references")
      ->capture_default_str()
      ->check(WholeNumber());
  command
      ->add_option("--samples", options->samples,
                   "Points on each mesh for distance, 1 to 10^9 (default 100000)")
      ->check(CLI::Range(1.0, 1e9));
  command->add_option("--csv", options->csv, "Write the table to this file too");
  command->add_option("--picture", options->picture, "PNG file: the map of spectrum or differences");
  command->add_flag("--json", options->json, "The table as JSON");
  add_trust_option(*command, options->check);
  return [options, command] {
    options->seed_given = command->count("--seed") > 0;
    return measure(*options);
  };
}

}  // namespace meander
