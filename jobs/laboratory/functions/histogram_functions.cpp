// Histograms of distances and their references; measures of many sets on one model.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "jobs/laboratory/functions/laboratory_functions.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/box_limit.h"
#include "kernels/analyse/distance_shares.h"
#include "kernels/analyse/histogram_error.h"
#include "kernels/analyse/lifted_area.h"
#include "kernels/analyse/nearest_points.h"
#include "kernels/analyse/spacing.h"
#include "kernels/analyse/weighted_distance_histogram.h"
#include "kernels/density/curvature.h"
#include "kernels/density/density.h"
#include "kernels/describe/distance_histogram.h"
#include "kernels/describe/heat_geodesics.h"
#include "kernels/pointset/sample_elimination.h"
#include "kernels/sample/curved_samples.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

// Takes a staged model. Returns vertices (W, 3) of the prepared mesh in working units, their areas (W,),
// normals (T, 9) of the corners of its triangles, split at creases; unit: the length of a working unit in the
// file; segments, accepted_share, chart_ratio, overlap and flips of the charts of the method anisotropic.
LaboratoryResult working_surface(const LaboratoryArguments& given) {
  const Model& model = given.staged();
  const PreparedMesh& mesh = model.surface;
  std::vector<double> vertices;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    vertices.insert(vertices.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  LaboratoryResult result;
  result.add("vertices", std::move(vertices), 3);
  result.add("areas", vertex_curvature(mesh).mixed_area);
  result.add("normals", crease_normals(mesh.x, mesh.y, mesh.z, mesh.triangles), 9);
  result.add("unit", mesh.unit);
  result.add("segments", model.segments.report.segments);
  result.add("accepted_share", model.segments.report.accepted_share);
  result.add("chart_ratio", model.segments.report.mean_chart_ratio);
  result.add("overlap", model.row.report.overlap);
  result.add("flips", static_cast<double>(model.row.report.flips));
  return result;
}

// Takes a staged model and its normals (T, 9). Returns the same model with the face attribute `lifted`, the
// area of the lifted triangle over that of the flat one, as its density. Samples with --density
// face-attribute:lifted are uniform on the lifted surface, but for O((edge x curvature)^2).
LaboratoryResult weighted_by_lifted_area(const LaboratoryArguments& given) {
  auto model = std::make_shared<Model>(given.staged());
  const PreparedMesh& mesh = model->surface;
  const std::vector<double> lifted =
      lifted_areas(mesh.x, mesh.y, mesh.z, mesh.triangles, given.reals("normals", 9));
  ScalarAttribute ratio{"lifted", std::vector<double>(model->file.polygon_count(), 1)};
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    if (mesh.area[t] > 0) ratio.values[mesh.polygon[t]] = lifted[t] / mesh.area[t];
  DensityParameters density;
  density.kind = DensityKind::face_attribute;
  density.attribute = ratio.name;
  model->file.face_attributes = {std::move(ratio)};
  model->measure = measure_of(mesh, make_density(model->file, mesh, density));
  LaboratoryResult result;
  result.staged = std::move(model);
  return result;
}

// Takes a staged model, triangle (n,) and barycentric (n, 2) of samples, and optional normals (T, 9). Returns
// points (n, 3) in working units: on the triangles, or lifted to the surface that the normals describe.
LaboratoryResult points_of_samples(const LaboratoryArguments& given) {
  const PreparedMesh& mesh = given.staged().surface;
  const std::span<const double> weights = given.reals("barycentric", 2);
  const std::vector<float> barycentric(weights.begin(), weights.end());
  const std::vector<double> flat(given.has("normals") ? 0 : 9 * mesh.triangle_count());
  LaboratoryResult result;
  result.add("points",
             lift_samples(mesh.x, mesh.y, mesh.z, mesh.triangles,
                          given.has("normals") ? given.reals("normals", 9) : std::span<const double>(flat),
                          given.numbers("triangle"), barycentric),
             3);
  return result;
}

// Takes points (n, 3), optional weights (n,), bins and range (0: the maximum distance). Returns range and
// shares (bins,) of the distances of all pairs in equal parts of [0, range]; a pair counts by the product of
// its weights.
LaboratoryResult distance_shares(const LaboratoryArguments& given) {
  const std::span<const double> points = given.reals("points", 3);
  DistanceHistogramParameters parameters;
  parameters.bins = static_cast<std::uint32_t>(given.whole("bins", parameters.bins));
  parameters.range = given.real("range", 0);
  DistanceHistogram histogram =
      given.has("weights") ? weighted_distance_histogram(points, given.reals("weights"), parameters)
                           : distance_histogram(std::vector<float>(points.begin(), points.end()), parameters);
  LaboratoryResult result;
  result.add("shares", std::move(histogram.shares));
  result.add("range", histogram.range);
  return result;
}

// Takes shape, "sphere" of radius 1 or "torus" of radii 1 and `tube`, and bins. Returns shares (bins,) of the
// distances of two random points in equal parts of [0, range]; range is the diameter.
LaboratoryResult known_distance_shares(const LaboratoryArguments& given) {
  const auto bins = static_cast<std::uint32_t>(given.whole("bins"));
  const bool sphere = given.text("shape") == "sphere";
  if (!sphere && given.text("shape") != "torus") throw std::invalid_argument("shape must be sphere or torus");
  const double tube = sphere ? 0 : given.real("tube");
  LaboratoryResult result;
  result.add("shares", sphere ? sphere_distance_shares(bins) : torus_distance_shares(bins, tube));
  result.add("range", 2 + 2 * tube);
  return result;
}

// Takes bins, shares (K, bins) and truth (bins,). Returns relative (K,), the sum of absolute errors, and norm
// (K,), the root of the sum of their squares, both over the sum of the truth; and largest (K,).
LaboratoryResult histogram_errors(const LaboratoryArguments& given) {
  const std::uint64_t bins = given.whole("bins");
  const std::span<const double> shares = given.reals("shares", bins), truth = given.reals("truth");
  if (truth.size() != bins) throw std::invalid_argument("truth must have as many values as there are bins");
  std::vector<double> relative, norm, largest;
  for (std::size_t begin = 0; begin < shares.size(); begin += bins) {
    const HistogramError error = histogram_error(shares.subspan(begin, bins), truth);
    relative.push_back(error.relative);
    norm.push_back(error.norm);
    largest.push_back(error.largest);
  }
  LaboratoryResult result;
  result.add("relative", std::move(relative));
  result.add("norm", std::move(norm));
  result.add("largest", std::move(largest));
  return result;
}

// Takes points (n, 3) and queries (m, 3). Returns nearest (m,), the number of the point nearest to each.
LaboratoryResult nearest_of_points(const LaboratoryArguments& given) {
  LaboratoryResult result;
  result.add("nearest", nearest_points(KdTree<3>(given.reals("points", 3)), given.reals("queries", 3)));
  return result;
}

// The consecutive parts of an array of n elements, by their sizes (uint32).
std::vector<std::pair<std::size_t, std::size_t>> parts_of(std::size_t n,
                                                          std::span<const std::uint32_t> sizes) {
  std::vector<std::pair<std::size_t, std::size_t>> parts;
  std::size_t begin = 0;
  for (const std::uint32_t size : sizes) {
    parts.emplace_back(begin, size);
    begin += size;
  }
  if (begin != n) throw std::invalid_argument("the sizes of the sets do not fit their number of points");
  return parts;
}

// Adds pairs to the bins of [0, range]; longer distances count in the last bin, unreached ones in none.
void add_distance(std::span<double> shares, double distance, double range, double weight) {
  if (!std::isfinite(distance)) return;
  const auto bins = static_cast<double>(shares.size());
  shares[static_cast<std::size_t>(std::min(distance / range * bins, bins - 1))] += weight;
}

void divide_by_sum(std::span<double> shares) {
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share /= sum;
}

// Approximates the diameter: the maximum distance on repeated steps to the farthest vertex.
double far_distance(const HeatGeodesics& geodesics, const PreparedMesh& mesh) {
  std::vector<double> distance(mesh.vertex_count());
  std::uint32_t from = 0;
  double largest = 0;
  for (int step = 0; step < 8; ++step) {
    geodesics.to_vertices(vertices_as_points(mesh, std::span(&from, 1)), distance);
    for (double& d : distance)
      if (!std::isfinite(d)) d = 0;
    from = static_cast<std::uint32_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    largest = std::max(largest, distance[from]);
  }
  return largest;
}

// Takes a staged model, sources (S,), areas (W,), bins, and consecutive sets of vertices: points (N,), sizes
// (K,). Returns histograms of geodesic distances between working vertices (heat method): range in units of
// the file; alike (bins,) and by_area (bins,), the shares of the pairs of a source and any other vertex, with
// equal weights and by the product of their areas; shares (K, bins) of all pairs of each set.
LaboratoryResult geodesic_shares(const LaboratoryArguments& given) {
  constexpr std::size_t block = 256;
  const PreparedMesh& mesh = given.staged().surface;
  const std::uint64_t bins = std::max<std::uint64_t>(given.whole("bins"), 1);
  const std::span<const std::uint32_t> sources = given.numbers("sources"), points = given.numbers("points");
  const std::span<const double> areas = given.reals("areas");
  const std::size_t vertices = mesh.vertex_count();
  if (areas.size() != vertices) throw std::invalid_argument("there must be an area for every vertex");
  const HeatGeodesics geodesics(mesh);
  const double range = far_distance(geodesics, mesh);
  if (!(range > 0)) throw ItemError(Status::zero_area, "all vertices are at one place");
  std::vector<double> alike(bins), by_area(bins), shares, distance(block * vertices);
  for (std::size_t begin = 0; begin < sources.size(); begin += block) {
    const std::span<const std::uint32_t> from =
        sources.subspan(begin, std::min(block, sources.size() - begin));
    geodesics.to_vertices(vertices_as_points(mesh, from), std::span(distance).first(from.size() * vertices));
    for (std::size_t r = 0; r < from.size(); ++r)
      for (std::size_t v = 0; v < vertices; ++v) {
        if (v == from[r]) continue;
        add_distance(alike, distance[r * vertices + v], range, 1);
        add_distance(by_area, distance[r * vertices + v], range, areas[from[r]] * areas[v]);
      }
  }
  divide_by_sum(alike);
  divide_by_sum(by_area);
  for (const auto& [begin, size] : parts_of(points.size(), given.numbers("sizes"))) {
    const PointsOnMeshArrays set = vertices_as_points(mesh, points.subspan(begin, size));
    distance.resize(size * size);
    geodesics.to_points(set, set, distance);
    std::vector<double> of_set(bins);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j < size; ++j)
        if (i != j) add_distance(of_set, distance[i * size + j], range, 1);
    divide_by_sum(of_set);
    shares.insert(shares.end(), of_set.begin(), of_set.end());
  }
  LaboratoryResult result;
  result.add("range", range);
  result.add("alike", std::move(alike));
  result.add("by_area", std::move(by_area));
  result.add("shares", std::move(shares), bins);
  return result;
}

// Takes a staged model, consecutive sets of samples, points (N, 3) in units of the file and sizes (K,), boxes
// and seed. Returns ratio (K,), the error over that of random points; bias, the mean error of a box over that
// of one set (0 for one set); limit (K,), the least error known to be possible for as many points; rho (K,)
// and mean_distance (K,), the minimum and the mean distance to the nearest other point over that of the
// hexagonal lattice.
LaboratoryResult measures_of_sets(const LaboratoryArguments& given) {
  const PreparedMesh& mesh = given.staged().surface;
  const std::vector<RotatedBox> boxes = boxes_on(mesh, given);
  const std::span<const double> points = given.reals("points", 3);
  const double boundary = relative_boundary(mesh.x, mesh.y, mesh.z, mesh.triangles, boxes);
  std::vector<double> ratio, limit, rho, mean_distance;
  BoxBias bias;
  for (const auto& [begin, size] : parts_of(points.size() / 3, given.numbers("sizes"))) {
    const std::vector<double> set = working_points(points.subspan(3 * begin, 3 * size), mesh);
    ratio.push_back(box_error_ratio(boxes, set));
    limit.push_back(box_error_limit(boundary, size));
    bias.add(box_errors(boxes, set));
    const Spacing spacing = spacing_of(nearest_distances(set), mesh.total_area);
    rho.push_back(spacing.rho);
    mean_distance.push_back(spacing.mean / hexagonal_spacing(mesh.total_area, size));
  }
  LaboratoryResult result;
  result.add("bias", ratio.size() > 1 ? bias.ratio() : 0);
  result.add("ratio", std::move(ratio));
  result.add("limit", std::move(limit));
  result.add("rho", std::move(rho));
  result.add("mean_distance", std::move(mean_distance));
  return result;
}

// Takes a staged model, points (M, 3) in units of the file, and n. Returns kept (n,), the numbers of the
// points that sample elimination (Yuksel 2015) keeps.
LaboratoryResult kept_by_elimination(const LaboratoryArguments& given) {
  const PreparedMesh& mesh = given.staged().surface;
  LaboratoryResult result;
  result.add("kept", eliminate_samples(working_points(given.reals("points", 3), mesh),
                                       static_cast<std::uint32_t>(given.whole("n")), mesh.total_area));
  return result;
}

constexpr LaboratoryFunction histogram_table[] = {{"working_surface", working_surface},
                                                  {"weighted_by_lifted_area", weighted_by_lifted_area},
                                                  {"points_of_samples", points_of_samples},
                                                  {"distance_shares", distance_shares},
                                                  {"known_distance_shares", known_distance_shares},
                                                  {"histogram_errors", histogram_errors},
                                                  {"nearest_of_points", nearest_of_points},
                                                  {"geodesic_shares", geodesic_shares},
                                                  {"measures_of_sets", measures_of_sets},
                                                  {"kept_by_elimination", kept_by_elimination}};

}  // namespace

const std::span<const LaboratoryFunction> histogram_functions = histogram_table;

}  // namespace meander
