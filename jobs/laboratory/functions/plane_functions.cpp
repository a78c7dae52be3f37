// Curves in the square and on parametric surfaces, samples of these, and their references.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "jobs/cli/option_words.h"
#include "jobs/inputs/surface_sources.h"
#include "jobs/laboratory/functions/laboratory_functions.h"
#include "kernels/analyse/discrepancy_sphere.h"
#include "kernels/pointset/curve_point.h"
#include "kernels/pointset/sphere_points.h"
#include "kernels/pointset/surface_curve.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface_measure.h"

namespace meander {

namespace {

// The parameters surface, a name of surface_names() or formulas for x, y, z, and density, density_floor,
// curve, sequence, order, place, tolerance, reparameterize and seed, as in `meander surface`.
SurfaceSampleParameters surface_parameters(const LaboratoryArguments& given) {
  check_surface_name(given.text("surface"));
  SurfaceSampleParameters parameters;
  take_surface_density(given.text("density", "uniform"), parameters.density);
  parameters.density.floor = given.real("density_floor", parameters.density.floor);
  parameters.curve = value_of(curve_words, given.text("curve", "hilbert"));
  parameters.sequence = value_of(sequence_words, given.text("sequence", "shifted"));
  parameters.order = value_of(order_words, given.text("order", "progressive"));
  parameters.place = value_of(place_words, given.text("place", "element"));
  parameters.tolerance = given.real("tolerance", parameters.tolerance);
  parameters.reparameterize = given.flag("reparameterize");
  parameters.seed = given.whole("seed", parameters.seed);
  return parameters;
}

// The tree of at most this many leaves, as close to it as a bound on the mass of leaves gets.
CurveTree adaptive_tree(const SurfaceCurve& fine, std::uint64_t leaves) {
  std::vector<double> s, t, area;
  for (std::size_t i = 0; i < fine.mass.size(); ++i) {
    const double side = fine.tree.side[i];
    s.push_back(fine.tree.u[i] + 0.5 * side);
    t.push_back(fine.tree.v[i] + 0.5 * side);
    area.push_back(side * side);
  }
  const CurveParameters parameters{fine.tree.kind, 1, 24};
  const double total = std::accumulate(fine.mass.begin(), fine.mass.end(), 0.0);
  const auto tree_of = [&](double leaf_mass) {
    return build_curve_tree(s, t, fine.mass, area, leaf_mass, 0, parameters);
  };
  double most = 1, least = 0.25 / static_cast<double>(leaves);
  for (int step = 0; step < 24; ++step) {
    const double middle = std::sqrt(most * least);
    (tree_of(middle * total).leaf_count() <= leaves ? most : least) = middle;
  }
  return tree_of(most * total);
}

CurveTree uniform_tree(CurveKind kind, std::uint64_t leaves) {
  CurveTree tree = curve_root(kind);
  while (tree.leaf_count() < leaves) tree = refine(tree, std::vector<std::uint8_t>(tree.leaf_count(), 1));
  return tree;
}

std::vector<double> interleaved(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> result;
  for (std::size_t i = 0; i < x.size(); ++i) result.insert(result.end(), {x[i], y[i]});
  return result;
}

// The curve of a surface (surface_parameters) through the centers of at most `leaves` leaves of about equal
// measure, or, with `uniform`, of the equal cells of the lowest level that has as many. steps (1): pieces in
// the parameters between two centers. Returns for each point of the polyline `along` (P,) in [0, 1] by number
// of leaves, `square` (P, 2), its position in the (with reparameterize, warped) square, `uv` (P, 2),
// `positions` and unit `normals` (P, 3); for each leaf `mass` (L,), their sum being 1, and `depth` (L,).
LaboratoryResult surface_curve(const LaboratoryArguments& given) {
  SurfaceSampleParameters parameters = surface_parameters(given);
  const std::uint64_t leaves = given.whole("leaves"), steps = given.whole("steps", 1);
  if (leaves < 4 || leaves > 65536) throw std::invalid_argument("leaves must be from 4 to 65536");
  if (steps < 1 || steps > 1000) throw std::invalid_argument("steps must be from 1 to 1000");
  parameters.samples = static_cast<std::uint32_t>(leaves);
  parameters.leaves_per_sample = 16;
  const SurfaceSource source = open_surface(given.text("surface"));
  const SurfaceCurve fine = build_surface_curve(*source.surface, parameters);
  const CurveTree tree =
      given.flag("uniform") ? uniform_tree(parameters.curve, leaves) : adaptive_tree(fine, leaves);

  const double total = std::accumulate(fine.mass.begin(), fine.mass.end(), 0.0);
  std::vector<double> mass(tree.leaf_count(), 0);
  for (std::size_t i = 0; i < fine.mass.size(); ++i) {
    const auto after = std::upper_bound(tree.key.begin(), tree.key.end(), fine.tree.key[i]);
    mass[static_cast<std::size_t>(after - tree.key.begin()) - 1] += fine.mass[i] / total;
  }
  std::vector<double> s, t, along;
  for (std::size_t i = 0; i < tree.leaf_count(); ++i) {
    const std::size_t next = std::min(i + 1, tree.leaf_count() - 1);
    for (std::uint64_t k = 0; k < (next > i ? steps : 1); ++k) {
      const double part = static_cast<double>(k) / static_cast<double>(steps);
      const auto center = [&](const std::vector<double>& lower) {
        const double here = lower[i] + 0.5 * tree.side[i];
        return here + part * (lower[next] + 0.5 * tree.side[next] - here);
      };
      s.push_back(center(tree.u));
      t.push_back(center(tree.v));
      along.push_back((static_cast<double>(i) + part) / static_cast<double>(tree.leaf_count() - 1));
    }
  }
  MeasureBatch batch;
  SurfaceMeasure(*source.surface, parameters, {}).evaluate(s, t, batch);
  std::vector<double> positions, normals;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Vector3 p = batch.position[i], n = batch.du_cross_dv[i];
    const double length = norm(n);
    positions.insert(positions.end(), {p.x, p.y, p.z});
    if (length > 0)
      normals.insert(normals.end(), {n.x / length, n.y / length, n.z / length});
    else
      normals.insert(normals.end(), {0, 0, 1});
  }
  LaboratoryResult result;
  result.add("along", std::move(along));
  result.add("square", interleaved(s, t), 2);
  result.add("uv", interleaved(batch.u, batch.v), 2);
  result.add("positions", std::move(positions), 3);
  result.add("normals", std::move(normals), 3);
  result.add("mass", std::move(mass));
  result.add("depth", std::vector<std::uint32_t>(tree.depth.begin(), tree.depth.end()));
  return result;
}

// Returns n samples of a surface (surface_parameters): points and normals (n, 3) in coordinates of the
// surface, uv (n, 2), density (n,); area; and measure, the integral of the density.
LaboratoryResult surface_samples(const LaboratoryArguments& given) {
  SurfaceSampleParameters parameters = surface_parameters(given);
  parameters.samples = static_cast<std::uint32_t>(given.whole("n"));
  SurfaceSamples samples = sample_surface(*open_surface(given.text("surface")).surface, parameters);
  std::vector<double> points;
  const Vector3 loc = samples.frame.loc;
  for (std::size_t i = 0; i < samples.count(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      points.push_back((k == 0   ? loc.x
                        : k == 1 ? loc.y
                                 : loc.z) +
                       samples.frame.scale * samples.points[3 * i + k]);
  LaboratoryResult result;
  result.add("area", samples.area);
  result.add("measure", samples.measure);
  result.add("points", std::move(points), 3);
  result.add("normals", std::vector<double>(samples.normals.begin(), samples.normals.end()), 3);
  result.add("uv", std::move(samples.uv), 2);
  result.add("density", std::vector<double>(samples.density.begin(), samples.density.end()));
  return result;
}

// Takes curve (hilbert, peano, peano-meander) and level. Returns the centers of its cells (C, 2) in the unit
// square, along the curve.
LaboratoryResult curve_cells(const LaboratoryArguments& given) {
  const CurveKind kind = value_of(curve_words, given.text("curve"));
  const std::uint64_t level = given.whole("level");
  if (level > 8) throw std::invalid_argument("level must be from 0 to 8");
  std::uint64_t cells = 1;
  for (std::uint64_t l = 0; l < level; ++l) cells *= kind == CurveKind::hilbert ? 4 : 9;
  std::vector<double> centers;
  for (std::uint64_t rank = 0; rank < cells; ++rank) {
    const CurvePoint p = curve_cell_center(kind, rank, static_cast<int>(level));
    centers.insert(centers.end(), {p.u, p.v});
  }
  LaboratoryResult result;
  result.add("centers", std::move(centers), 2);
  return result;
}

// Takes method (of SphereMethod), n and seed. Returns points (n, 3) on the unit sphere.
LaboratoryResult points_on_sphere(const LaboratoryArguments& given) {
  const std::string name = given.text("method");
  const std::optional<SphereMethod> method = sphere_method(name);
  if (!method) throw std::invalid_argument("there is no method `" + name + "` on the sphere");
  const SpherePoints made =
      sphere_points(*method, static_cast<std::uint32_t>(given.whole("n")), given.whole("seed", 1));
  std::vector<double> points;
  for (std::size_t i = 0; i < made.count(); ++i)
    points.insert(points.end(), {made.x[i], made.y[i], made.z[i]});
  LaboratoryResult result;
  result.add("points", std::move(points), 3);
  return result;
}

// Takes points (n, 3) on the unit sphere, axes, triangles and seed. Returns the maximum error over caps
// around random axes and over spherical triangles.
LaboratoryResult sphere_discrepancy(const LaboratoryArguments& given) {
  ShapeParameters shapes;
  shapes.seed = given.whole("seed", 1);
  shapes.stable_rise = 0;  // sets are compared: the same number of shapes for all
  const std::vector<double> x = given.column("points", 3, 0), y = given.column("points", 3, 1),
                            z = given.column("points", 3, 2);
  LaboratoryResult result;
  shapes.shapes = static_cast<std::uint32_t>(given.whole("axes", 200));
  result.add("caps", cap_discrepancy(x, y, z, shapes).discrepancy);
  shapes.shapes = static_cast<std::uint32_t>(given.whole("triangles", 4096));
  result.add("triangles", spherical_triangle_discrepancy(build_point_index(x, y, z), shapes).discrepancy);
  return result;
}

constexpr LaboratoryFunction plane_table[] = {{"surface_curve", surface_curve},
                                              {"surface_samples", surface_samples},
                                              {"curve_cells", curve_cells},
                                              {"points_on_sphere", points_on_sphere},
                                              {"sphere_discrepancy", sphere_discrepancy}};

}  // namespace

const std::span<const LaboratoryFunction> plane_functions = plane_table;

}  // namespace meander
