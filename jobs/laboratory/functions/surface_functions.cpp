// Parametric surfaces, curves on meshes, errors of samples on meshes, and distances between meshes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "jobs/laboratory/functions/laboratory_functions.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/curve_chains.h"
#include "kernels/analyse/discrepancy_rings.h"
#include "kernels/analyse/kd_tree.h"
#include "kernels/analyse/mesh_distance.h"
#include "kernels/analyse/nearest_points.h"
#include "kernels/analyse/point_location.h"
#include "kernels/analyse/quadric_collapse.h"
#include "kernels/analyse/self_intersections.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/point_frames.h"
#include "kernels/surface/surface.h"

namespace meander {

namespace {

std::vector<double> coordinates(std::span<const Vector3> points, std::size_t columns) {
  std::vector<double> result;
  for (const Vector3& p : points)
    for (std::size_t k = 0; k < columns; ++k) result.push_back(k == 0 ? p.x : k == 1 ? p.y : p.z);
  return result;
}

// Takes surface, a name (see surface.h), and uv (n, 2) in the unit square. Returns points (n, 3).
LaboratoryResult surface_points(const LaboratoryArguments& given) {
  const std::unique_ptr<ParametricSurface> surface = make_surface(given.text("surface"));
  if (!surface) throw std::invalid_argument("there is no surface `" + given.text("surface") + "`");
  const std::vector<double> u = given.column("uv", 2, 0), v = given.column("uv", 2, 1);
  std::vector<Vector3> positions(u.size());
  surface->positions(u, v, positions);
  LaboratoryResult result;
  result.add("points", coordinates(positions, 3), 3);
  return result;
}

// The charts of a staged model with a curve over each.
struct CurvedCharts {
  const Model& model;
  std::vector<CurveTree> trees{};

  const PreparedMesh& mesh() const { return model.coarse.empty() ? model.surface : model.coarse.mesh; }
  std::vector<CurveChain> chains(std::size_t chart, std::uint32_t steps) const {
    return curve_chains(mesh(), model.charts[chart], trees[chart], steps);
  }

  // The leaves that lie over a chart and are joined to others; the rest of the square has no surface.
  std::uint64_t leaves() const {
    std::uint64_t count = 0;
    for (std::size_t c = 0; c < trees.size(); ++c)
      for (const CurveChain& chain : chains(c, 1)) count += chain.u.size();
    return count;
  }

  void make_uniform(std::uint64_t level) {
    if (level > 12) throw std::invalid_argument("a uniform curve has at most 12 levels");
    CurveTree tree = curve_root(CurveKind::hilbert);
    for (std::uint64_t i = 0; i < level; ++i)
      tree = refine(tree, std::vector<std::uint8_t>(tree.leaf_count(), 1));
    trees.assign(model.charts.size(), tree);
  }

  // Refines the curve as samplers do, to nearly `wanted` leaves over the charts: by bisection of the mass of
  // a leaf.
  void make_adaptive(const EmbreeDevice& device, std::uint64_t wanted, RandomKey key) {
    const std::vector<double>& masses = model.coarse.empty() ? model.measure.masses : model.coarse.masses;
    LocateParameters parameters;
    parameters.samples = wanted;
    double low = std::log(1.0 / 16), high = std::log(64.0);
    std::vector<CurveTree> best;
    std::uint64_t off = UINT64_MAX;
    for (int step = 0; step < 24 && off > 0; ++step) {
      const double middle = 0.5 * (low + high);
      parameters.curve.leaves_per_sample = std::exp(middle);
      trees = build_curves(mesh(), model.charts, masses, parameters);
      locate_with_embree(device, mesh(), model.charts, masses, trees, key, parameters);
      const std::uint64_t found = leaves(), now = found > wanted ? found - wanted : wanted - found;
      if (now < off) best = trees, off = now;
      (found < wanted ? low : high) = middle;
    }
    trees = std::move(best);
  }
};

// Takes a staged model with charts, and level, for the uniform curve of `level` Hilbert levels over each
// chart, or leaves, for the adaptive curve of about `leaves` leaves over all; steps, the points of a link
// between leaves; and spots. Returns points (P, 3) on the surface, in units of the file; uv (P, 2) in the
// chart; along (P,), the share of the leaves of the chart; chain and chart (P,): consecutive points of a
// chain are joined; leaves, those over charts; gaps (spots,), the distances from random points of the surface
// to the nearest point of the curve, in units of the file; and chart_uv (V, 2), chart_faces (T, 3) and
// chart_border (B, 2), vertices, of the largest chart, whose number is `largest`.
LaboratoryResult mesh_curve(const LaboratoryArguments& given) {
  const PreparedMesh& fine = given.staged().surface;
  const std::vector<FlatChart>& charts = given.staged().charts;
  const EmbreeDevice device;
  CurvedCharts curved{given.staged()};
  if (given.has("level"))
    curved.make_uniform(given.whole("level"));
  else
    curved.make_adaptive(device, given.whole("leaves"), make_random_key(given.whole("seed", 1), {}));
  const SurfaceLocator surface(device, fine.x, fine.y, fine.z, fine.triangles);
  const auto steps = static_cast<std::uint32_t>(given.whole("steps", 32));
  std::vector<Vector3> points, uv;
  std::vector<double> along, gaps;
  std::vector<std::uint32_t> chain_of, chart_of;
  std::uint32_t number = 0;
  std::size_t largest = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    if (charts[c].report.area > charts[largest].report.area) largest = c;
    for (const CurveChain& chain : curved.chains(c, steps)) {
      ++number;
      for (std::size_t i = 0; i < chain.u.size(); ++i) {
        // Charts may be those of a coarser mesh, above and below the surface, whose nearest point may jump;
        // and they may overlap themselves, where the curve changes from one sheet to the other.
        const Vector3 at = surface.nearest(chain.position[i]).point;
        if (i > 0 && distance(at, points.back()) >
                         std::min(0.05, 0.01 + 4 * distance(chain.position[i], chain.position[i - 1])))
          ++number;
        points.push_back(at);
        uv.push_back({chain.u[i], chain.v[i], 0});
        along.push_back(chain.along[i] / static_cast<double>(curved.trees[c].leaf_count()));
        chain_of.push_back(number);
        chart_of.push_back(static_cast<std::uint32_t>(c));
      }
    }
  }
  if (points.empty()) throw ItemError(Status::internal, "there is no chart below a leaf of the curve");
  const std::vector<double> spots = area_samples({fine.x, fine.y, fine.z, fine.triangles},
                                                 given.whole("spots", 20000), given.whole("seed", 1));
  const std::vector<std::uint32_t> nearest = nearest_points(KdTree<3>(coordinates(points, 3)), spots);
  for (std::size_t i = 0; i < nearest.size(); ++i)
    gaps.push_back(fine.unit *
                   distance({spots[3 * i], spots[3 * i + 1], spots[3 * i + 2]}, points[nearest[i]]));
  for (Vector3& p : points) p = to_file(fine, p);
  const FlatChart& chart = charts[largest];
  std::vector<Vector3> chart_uv;
  for (std::size_t v = 0; v < chart.u.size(); ++v) chart_uv.push_back({chart.u[v], chart.v[v], 0});
  const std::vector<std::uint32_t> corners(chart.cut.triangles.begin(), chart.cut.triangles.end());
  std::vector<std::uint32_t> border;
  for (std::uint32_t h = 0; h < corners.size(); ++h)
    if (chart.cut.opposite[h] == no_index)
      border.insert(border.end(), {corners[h], corners[next_half_edge(h)]});
  LaboratoryResult result;
  result.add("leaves", static_cast<double>(curved.leaves()));
  result.add("largest", static_cast<double>(largest));
  result.add("points", coordinates(points, 3), 3);
  result.add("uv", coordinates(uv, 2), 2);
  result.add("along", std::move(along));
  result.add("chain", std::move(chain_of));
  result.add("chart", std::move(chart_of));
  result.add("gaps", std::move(gaps));
  result.add("chart_uv", coordinates(chart_uv, 2), 2);
  result.add("chart_faces", corners, 3);
  result.add("chart_border", std::move(border), 2);
  return result;
}

// Takes a staged model; consecutive sets of samples, points (N, 3) in units of the file, triangle (N,) as
// `samples` returns it, and counts (k,), the sizes of the sets; boxes and rings, numbers of test shapes,
// which are the same for all sets of a seed. Returns boxes (k,), the root mean square error of the share in
// random rotated boxes, and rings (k,), the maximum error over patches that grow ring by ring.
LaboratoryResult set_errors(const LaboratoryArguments& given) {
  const PreparedMesh& surface = given.staged().surface;
  const std::span<const double> points = given.reals("points", 3);
  const std::span<const std::uint32_t> triangle = given.numbers("triangle"), counts = given.numbers("counts");
  const std::vector<RotatedBox> boxes = boxes_on(surface, given);
  const VertexTriangles around =
      triangles_around_vertices(surface.triangles, static_cast<std::uint32_t>(surface.x.size()));
  const std::vector<std::uint32_t> seeds =
      ring_seeds(surface.triangles, static_cast<std::uint32_t>(given.whole("rings")), given.whole("seed", 1));
  std::vector<double> of_boxes, of_rings;
  std::size_t first = 0;
  for (const std::uint32_t count : counts) {
    if (count == 0 || first + count > triangle.size() || 3 * triangle.size() != points.size())
      throw std::invalid_argument("points, triangles and counts do not fit");
    std::vector<std::uint32_t> hits(surface.triangle_count(), 0);
    for (const std::uint32_t hit : triangle.subspan(first, count)) ++hits.at(hit);
    double sum = 0;
    for (const double error :
         box_errors(boxes, working_points(points.subspan(3 * first, 3 * count), surface)))
      sum += error * error;
    of_boxes.push_back(std::sqrt(sum / static_cast<double>(boxes.size())));
    of_rings.push_back(ring_discrepancy(surface.triangles, around, surface.area, hits, seeds).discrepancy);
    first += count;
  }
  LaboratoryResult result;
  result.add("boxes", std::move(of_boxes));
  result.add("rings", std::move(of_rings));
  return result;
}

// Takes vertices (V, 3), faces (T, 3) and target. Returns the same surface with `target` vertices, by quadric
// edge collapse.
LaboratoryResult simplified(const LaboratoryArguments& given) {
  const PreparedMesh surface = prepare_mesh(given.mesh());
  SimplifiedMesh made = quadric_collapse(surface, given.whole("target"));
  std::vector<Vector3> vertices;
  for (std::size_t v = 0; v < made.x.size(); ++v)
    vertices.push_back(to_file(surface, {made.x[v], made.y[v], made.z[v]}));
  LaboratoryResult result;
  result.add("vertices", coordinates(vertices, 3), 3);
  result.add("faces", std::move(made.triangles), 3);
  return result;
}

// Takes vertices, faces, other_vertices, other_faces, samples on each (0: by area) and seed. Returns mean,
// rms and largest distance from the first mesh to the other, mean_back, rms_back and largest_back from the
// other to the first, the diagonal of the first, all in their units; and crossings, the pairs of triangles of
// the other that cross.
LaboratoryResult mesh_distances(const LaboratoryArguments& given) {
  const PolygonMesh first = given.mesh();
  const std::vector<double> x = given.column("other_vertices", 3, 0),
                            y = given.column("other_vertices", 3, 1),
                            z = given.column("other_vertices", 3, 2);
  const TriangleSpans other{x, y, z, given.numbers("other_faces", 3)};
  MeshDistanceParameters parameters;
  parameters.samples = given.whole("samples", 0);
  parameters.seed = given.whole("seed", 1);
  const EmbreeDevice device;
  const MeshDistance found =
      mesh_distance(device, {first.x, first.y, first.z, first.corners}, other, parameters);
  LaboratoryResult result;
  for (const auto& [suffix, of] : {std::pair("", found.forward), std::pair("_back", found.backward)}) {
    result.add(std::string("mean") + suffix, of.mean);
    result.add(std::string("rms") + suffix, of.rms);
    result.add(std::string("largest") + suffix, of.max);
  }
  result.add("diagonal", found.diagonal);
  result.add("crossings", static_cast<double>(self_intersections(other)));
  return result;
}

constexpr LaboratoryFunction surface_table[] = {{"surface_points", surface_points},
                                                {"mesh_curve", mesh_curve},
                                                {"set_errors", set_errors},
                                                {"simplified", simplified},
                                                {"mesh_distances", mesh_distances}};

}  // namespace

const std::span<const LaboratoryFunction> surface_functions = surface_table;

}  // namespace meander
