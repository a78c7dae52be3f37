#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>
#include <stdexcept>

#include "io/file/file_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "kernels/analyse/exact_geodesics.h"
#include "kernels/core/random.h"
#include "kernels/describe/geodesic_histogram.h"
#include "kernels/mesh/prepare_mesh.h"
#include "support/catch.h"
#include "support/collection.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

std::vector<double> heat_to_vertices(const PreparedMesh& mesh, PointsOnMesh sources) {
  std::vector<double> d(sources.count() * mesh.vertex_count());
  HeatGeodesics(mesh).to_vertices(sources, d);
  return d;
}

std::vector<double> exact_to_vertices(const PreparedMesh& mesh, PointsOnMesh sources) {
  std::vector<double> d(sources.count() * mesh.vertex_count());
  exact_geodesics(mesh, sources, d);
  return d;
}

// Points in random triangles, uniform in each.
PointsOnMeshArrays random_points(const PreparedMesh& mesh, std::size_t count, std::uint64_t seed) {
  const RandomKey key = make_random_key(seed, {});
  PointsOnMeshArrays points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto [pick, unused] = random_pair(key, Stream::sequence, 2 * i);
    auto [u, v] = random_pair(key, Stream::sequence, 2 * i + 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    points.triangle.push_back(static_cast<std::uint32_t>(pick * static_cast<double>(mesh.triangle_count())));
    points.barycentric.insert(points.barycentric.end(), {u, v});
  }
  return points;
}

Vector3 file_position(const PreparedMesh& mesh, PointsOnMesh points, std::size_t i) {
  const double w[3] = {1 - points.barycentric[2 * i] - points.barycentric[2 * i + 1],
                       points.barycentric[2 * i], points.barycentric[2 * i + 1]};
  Vector3 p;
  for (std::uint32_t k = 0; k < 3; ++k)
    p = p + w[k] * mesh.position(mesh.triangles[3 * points.triangle[i] + k]);
  return mesh.center + mesh.unit * p;
}
Vector3 file_position(const PreparedMesh& mesh, std::uint32_t vertex) {
  return mesh.center + mesh.unit * mesh.position(vertex);
}

struct Errors {
  double mean = 0, worst = 0;
};
template <class Exact>
Errors errors_of(std::span<const double> found, const Exact& exact) {
  Errors errors;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double error = std::abs(found[i] - exact(i));
    errors.mean += error / static_cast<double>(found.size());
    errors.worst =
        std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(errors.worst, error);
  }
  return errors;
}

double great_circle(Vector3 a, Vector3 b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

// A sheet of flat strips, `fold` radians between one and the next: the same triangles, edge lengths and paths
// whatever the fold. grid_plane(nx, ny, width, height) for 0.
PolygonMesh bent_sheet(std::uint32_t nx, std::uint32_t ny, double width, double height, double fold) {
  PolygonMesh mesh = grid_plane(nx, ny, width, height);
  const double step = width / nx;
  std::vector<Vector3> profile(nx + 1);
  for (std::uint32_t i = 0; i < nx; ++i)
    profile[i + 1] = profile[i] + step * Vector3{std::cos(fold * i), 0, std::sin(fold * i)};
  for (std::size_t v = 0; v < mesh.x.size(); ++v) {
    const auto column = static_cast<std::size_t>(std::lround(mesh.x[v] / step));
    mesh.x[v] = profile[column].x;
    mesh.z[v] = profile[column].z;
  }
  return mesh;
}

// Shortest paths through `steiner` points an edge (Dijkstra): never below the exact distance.
std::vector<double> steiner_distances(const PreparedMesh& mesh, std::uint32_t source, std::uint32_t steiner) {
  std::vector<Vector3> node;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) node.push_back(file_position(mesh, v));
  std::vector<std::vector<std::uint32_t>> on_edge(mesh.triangles.size());
  for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h) {
    if (mesh.opposite[h] != no_index && mesh.opposite[h] < h) {
      on_edge[h] = on_edge[mesh.opposite[h]];
      continue;
    }
    const Vector3 a = node[mesh.triangles[h]], b = node[mesh.triangles[next_half_edge(h)]];
    for (std::uint32_t i = 1; i <= steiner; ++i) {
      on_edge[h].push_back(static_cast<std::uint32_t>(node.size()));
      node.push_back(a + static_cast<double>(i) / (steiner + 1) * (b - a));
    }
  }
  std::vector<std::vector<std::uint32_t>> members(mesh.triangle_count()), triangles(node.size());
  for (std::uint32_t t = 0; t < members.size(); ++t) {
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      members[t].push_back(mesh.triangles[h]);
      members[t].insert(members[t].end(), on_edge[h].begin(), on_edge[h].end());
    }
    for (const std::uint32_t n : members[t]) triangles[n].push_back(t);
  }
  std::vector<double> reached(node.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.emplace(reached[source] = 0, source);
  while (!queue.empty()) {
    const auto [d, n] = queue.top();
    queue.pop();
    if (d > reached[n]) continue;
    for (const std::uint32_t t : triangles[n])
      for (const std::uint32_t m : members[t])
        if (const double to = d + distance(node[n], node[m]); to < reached[m])
          queue.emplace(reached[m] = to, m);
  }
  reached.resize(mesh.vertex_count());
  return reached;
}

}  // namespace

TEST_CASE("exact geodesics: plane, cube and bent sheet match their unfolding") {
  const PreparedMesh plane = prepare_mesh(grid_plane(17, 11, 1.3, 0.7));
  const PointsOnMeshArrays sources = random_points(plane, 6, 1);
  const std::vector<double> flat = exact_to_vertices(plane, sources);
  CHECK(errors_of(flat, [&](std::size_t i) {
          return distance(file_position(plane, sources, i / plane.vertex_count()),
                          file_position(plane, static_cast<std::uint32_t>(i % plane.vertex_count())));
        }).worst < 1e-13);

  const PreparedMesh bent = prepare_mesh(bent_sheet(17, 11, 1.3, 0.7, 0.5));  // more than a turn
  REQUIRE(bent.triangle_count() == plane.triangle_count());
  const std::vector<double> rolled = exact_to_vertices(bent, sources);
  REQUIRE(bent.corner_slot == plane.corner_slot);  // the same numbering
  CHECK(errors_of(rolled, [&](std::size_t i) { return flat[i]; }).worst < 1e-12);

  const PreparedMesh box = prepare_mesh(cube());
  for (std::uint32_t s = 0; s < 8; ++s) {
    const std::vector<double> d = exact_to_vertices(box, vertices_as_points(box, std::vector{s}));
    for (std::uint32_t v = 0; v < 8; ++v) {  // opposite corner: over two faces, 2 x 4 unfolded
      const double straight = distance(file_position(box, s), file_position(box, v));
      CHECK(d[v] == Approx(straight > 3 ? 2 * std::sqrt(5.0) : straight).margin(1e-14));
    }
  }
}

TEST_CASE("exact geodesics: paths around the inner corner of an L bend at a boundary vertex") {
  // Unit squares of an L, cut finely; the inner corner is (1, 1).
  PolygonMesh square = grid_plane(10, 10, 2, 2), el;
  std::vector<double> xyz;
  for (std::size_t v = 0; v < square.x.size(); ++v) xyz.insert(xyz.end(), {square.x[v], square.y[v], 0});
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::size_t p = 0; p < square.polygon_count(); ++p) {
    std::vector<std::uint32_t> face(square.corners.begin() + square.polygon_begin[p],
                                    square.corners.begin() + square.polygon_begin[p + 1]);
    double x = 0, y = 0;
    for (const std::uint32_t v : face) x += square.x[v], y += square.y[v];
    if (x / 3 < 1 || y / 3 < 1) faces.push_back(face);
  }
  const PreparedMesh mesh = prepare_mesh(polygon_mesh(xyz, faces));
  std::uint32_t source = no_index;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    if (distance(file_position(mesh, v), {2, 0.4, 0}) < 1e-9) source = v;
  REQUIRE(source != no_index);
  const std::vector<double> d = exact_to_vertices(mesh, vertices_as_points(mesh, std::vector{source}));
  const Vector3 from{2, 0.4, 0}, corner{1, 1, 0};
  for (std::uint32_t v = 0; v < d.size(); ++v) {
    const Vector3 to = file_position(mesh, v);
    const bool hidden = to.y > 1 + 1e-9 && cross(to - from, corner - from).z > 0;
    CHECK(d[v] ==
          Approx(hidden ? distance(from, corner) + distance(corner, to) : distance(from, to)).epsilon(1e-12));
  }
}

TEST_CASE("exact geodesics: on a torus slightly below paths through edge points, and symmetric") {
  const PreparedMesh mesh = prepare_mesh(torus(20, 12));
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); v += 37) vertices.push_back(v);
  const std::vector<double> d = exact_to_vertices(mesh, vertices_as_points(mesh, vertices));
  const std::size_t width = mesh.vertex_count();
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (std::size_t j = 0; j < vertices.size(); ++j)
      CHECK(d[i * width + vertices[j]] == Approx(d[j * width + vertices[i]]).margin(1e-12));
  const std::vector<double> above = steiner_distances(mesh, vertices[2], 12);
  for (std::size_t v = 0; v < width; ++v) {
    CHECK(d[2 * width + v] <= above[v] + 1e-12);
    CHECK(d[2 * width + v] >= 0.993 * above[v]);
  }
}

TEST_CASE("heat geodesics: great circles of the sphere, with errors falling with the mesh size") {
  const double allowed_mean[] = {0.022, 0.0095, 0.0075}, allowed_worst[] = {0.08, 0.04, 0.03};
  double previous = 1;
  for (int s = 2; s <= 4; ++s) {
    const PreparedMesh mesh = prepare_mesh(icosphere(s, 50));
    const PointsOnMeshArrays sources = random_points(mesh, 16, 3);
    const std::vector<double> d = heat_to_vertices(mesh, sources);
    const Errors errors = errors_of(d, [&](std::size_t i) {
      return 50 * great_circle(file_position(mesh, sources, i / mesh.vertex_count()),
                               file_position(mesh, static_cast<std::uint32_t>(i % mesh.vertex_count())));
    });
    CAPTURE(s, errors.mean, errors.worst, previous);
    CHECK(errors.mean < 50 * allowed_mean[s - 2]);
    CHECK(errors.worst < 50 * allowed_worst[s - 2]);
    CHECK(errors.mean < 0.9 * previous * 50);
    previous = errors.mean / 50;
  }
}

TEST_CASE("heat geodesics: close to exact distances on a torus") {
  double previous = 1;
  for (const std::uint32_t across : {12u, 24u}) {
    const PreparedMesh mesh = prepare_mesh(torus(5 * across / 2, across));
    const PointsOnMeshArrays sources = random_points(mesh, 4, 5);
    const std::vector<double> exact = exact_to_vertices(mesh, sources);
    const Errors errors = errors_of(heat_to_vertices(mesh, sources), [&](std::size_t i) { return exact[i]; });
    const double largest = *std::max_element(exact.begin(), exact.end());
    CAPTURE(across, errors.mean / largest, errors.worst / largest);
    CHECK(errors.mean < (across == 12 ? 0.05 : 0.025) * largest);
    CHECK(errors.worst < (across == 12 ? 0.16 : 0.09) * largest);
    CHECK(errors.mean < 0.8 * previous * largest);
    previous = errors.mean / largest;
  }
}

TEST_CASE("heat geodesics: a bounded plane, zero at the source, nearly symmetric") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(40, 40));
  const PointsOnMeshArrays points = random_points(mesh, 40, 7);
  std::vector<double> d(40 * 40);
  HeatGeodesics(mesh).to_points(points, points, d);
  const auto straight = [&](std::size_t i) {
    return distance(file_position(mesh, points, i / 40), file_position(mesh, points, i % 40));
  };
  const Errors errors = errors_of(d, straight);
  CAPTURE(errors.mean, errors.worst);
  CHECK(errors.mean < 0.006);
  CHECK(errors.worst < 0.03);
  for (std::size_t i = 0; i < 40; ++i) {
    CHECK(d[41 * i] == 0);
    for (std::size_t j = 0; j < 40; ++j) {
      CHECK(d[40 * i + j] >= straight(40 * i + j) - 1e-12);
      CHECK(std::abs(d[40 * i + j] - d[40 * j + i]) < 0.03);
    }
  }
  const std::vector<std::uint32_t> vertices = {0, 5, 840, 1680};
  const std::vector<double> to = heat_to_vertices(mesh, vertices_as_points(mesh, vertices));
  for (std::size_t i = 0; i < vertices.size(); ++i) CHECK(to[i * mesh.vertex_count() + vertices[i]] == 0);
}

TEST_CASE("heat geodesics: a long strip where plain h^2 would underflow") {
  const PreparedMesh mesh = prepare_mesh(grid_plane(1500, 2, 1500, 2));
  const std::vector<double> d =
      heat_to_vertices(mesh, vertices_as_points(mesh, std::vector<std::uint32_t>{0}));
  const Errors errors = errors_of(d, [&](std::size_t v) {
    return distance(file_position(mesh, 0u), file_position(mesh, static_cast<std::uint32_t>(v)));
  });
  CAPTURE(errors.mean, errors.worst);
  CHECK(errors.worst < 8);
}

TEST_CASE("heat geodesics: batches and threads change no bit") {
  const PreparedMesh mesh = prepare_mesh(merged(icosphere(3), moved(torus(20, 12), 1, 5, 0, 0)));
  const PointsOnMeshArrays sources = random_points(mesh, 37, 11);
  const HeatGeodesics geodesics(mesh);
  const std::size_t width = mesh.vertex_count();
  std::vector<double> together(37 * width), alone(width), threads(37 * width);
  geodesics.to_vertices(sources, together);
  for (std::size_t s = 0; s < 37; s += 5) {
    const PointsOnMesh one{std::span(sources.triangle).subspan(s, 1),
                           std::span(sources.barycentric).subspan(2 * s, 2)};
    geodesics.to_vertices(one, alone);
    CHECK(std::equal(alone.begin(), alone.end(), together.begin() + static_cast<std::ptrdiff_t>(s * width)));
  }
  for (const std::size_t count : {1u, 4u}) {
    on_threads(count, [&] { HeatGeodesics(mesh).to_vertices(sources, threads); });
    CHECK(threads == together);
  }
  const auto first = geodesic_histogram(geodesics, sources),
             second = geodesic_histogram(HeatGeodesics(mesh), sources);
  CHECK(first.share == second.share);
}

TEST_CASE("geodesic histogram: separate components, bins, sources and scale") {
  const PreparedMesh mesh = prepare_mesh(merged(icosphere(2), moved(icosphere(2), 1, 9, 0, 0)));
  const HeatGeodesics geodesics(mesh);
  // 30 samples on one, 10 on the other.
  PointsOnMeshArrays samples;
  for (std::uint32_t i = 0; i < 40; ++i) {
    const std::uint32_t half = static_cast<std::uint32_t>(mesh.triangle_count()) / 2;
    samples.triangle.push_back(i < 30 ? 10 * i : half + 20 * (i - 30));
    samples.barycentric.insert(samples.barycentric.end(), {0.25, 0.5});
  }
  GeodesicHistogramParameters all;
  all.sources = 0;
  const GeodesicHistogram found = geodesic_histogram(geodesics, samples, all);
  CHECK(found.pairs == 30 * 29 + 10 * 9);
  CHECK(found.disconnected_share == Approx(600.0 / (40 * 39)));
  CHECK(found.upper == found.largest);
  CHECK(found.largest < 3.3);

  std::vector<double> d(40 * 40);
  geodesics.to_points(samples, samples, d);
  for (const HistogramScale scale : {HistogramScale::largest, HistogramScale::mean}) {
    GeodesicHistogramParameters parameters;
    parameters.bins = 8;
    parameters.sources = 5;
    parameters.scale = scale;
    const GeodesicHistogram some = geodesic_histogram(geodesics, samples, parameters);
    double sum = 0, largest = 0;
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t j = 0; j < 30; ++j) sum += d[40 * i + j], largest = std::max(largest, d[40 * i + j]);
    CHECK(some.pairs == 5 * 29);
    CHECK(some.mean == Approx(sum / (5 * 29)));
    const double upper = scale == HistogramScale::mean ? 3 * sum / (5 * 29) : largest;
    CHECK(some.upper == Approx(upper));
    std::vector<double> expected(8, 0);
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t j = 0; j < 30; ++j)
        if (i != j)
          expected[std::min<std::size_t>(7, static_cast<std::size_t>(d[40 * i + j] / upper * 8))] += 1;
    for (std::size_t b = 0; b < 8; ++b) CHECK(some.share[b] == Approx(expected[b] / (5 * 29)));
  }
  all.bins = 7;
  CHECK_THROWS_AS(geodesic_histogram(geodesics, samples, all), std::invalid_argument);
  samples.triangle[3] = 100000;
  CHECK_THROWS_AS(geodesic_histogram(geodesics, samples), std::invalid_argument);
}

TEST_CASE("geodesic histogram: isometric copies of a sheet agree, their Euclidean histograms do not") {
  const PreparedMesh flat = prepare_mesh(grid_plane(30, 15, 2, 1)),
                     bent = prepare_mesh(bent_sheet(30, 15, 2, 1, 0.15));
  REQUIRE(bent.corner_slot == flat.corner_slot);
  const PointsOnMeshArrays samples = random_points(flat, 300, 13);
  const auto a = geodesic_histogram(HeatGeodesics(flat), samples),
             b = geodesic_histogram(HeatGeodesics(bent), samples);
  double apart = 0;
  for (std::size_t i = 0; i < a.share.size(); ++i) apart += std::abs(a.share[i] - b.share[i]);
  CAPTURE(apart, a.mean, b.mean);
  CHECK(apart < 0.06);
  CHECK(b.mean == Approx(a.mean).epsilon(0.01));
  double euclidean_flat = 0, euclidean_bent = 0;
  for (std::size_t i = 0; i < 64; ++i)
    for (std::size_t j = 0; j < 300; ++j) {
      euclidean_flat += distance(file_position(flat, samples, i), file_position(flat, samples, j));
      euclidean_bent += distance(file_position(bent, samples, i), file_position(bent, samples, j));
    }
  CHECK(euclidean_bent < 0.85 * euclidean_flat);
}

namespace {

// Sum of the differences of two histograms of 32 shares up to the largest of `expected`: 0 equal, 2 apart.
double histogram_distance(const std::vector<double>& found, const std::vector<double>& expected) {
  const double largest = *std::max_element(expected.begin(), expected.end());
  std::vector<double> difference(32, 0);
  const auto add = [&](const std::vector<double>& distances, double sign) {
    for (const double d : distances)
      difference[std::min<std::size_t>(31, static_cast<std::size_t>(32 * d / largest))] +=
          sign / static_cast<double>(distances.size());
  };
  add(found, 1);
  add(expected, -1);
  double sum = 0;
  for (const double d : difference) sum += std::abs(d);
  return sum;
}

std::vector<std::uint32_t> spread_vertices(const PreparedMesh& mesh, std::uint32_t count) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t i = 0; i < count; ++i)
    vertices.push_back(static_cast<std::uint32_t>(mesh.vertex_count() * i / count));
  return vertices;
}

}  // namespace

TEST_CASE("geodesic histogram: the closed form on a sphere, exact distances on a torus") {
  const PreparedMesh ball = prepare_mesh(icosphere(4));
  const GeodesicHistogram on_ball = geodesic_histogram(HeatGeodesics(ball), random_points(ball, 2000, 17));
  double apart = 0;
  // Distances d of uniform points have the density sin(d) / 2 on [0, pi].
  for (std::size_t b = 0; b < on_ball.share.size(); ++b) {
    const double width = on_ball.upper / static_cast<double>(on_ball.share.size());
    const double low = std::min(std::numbers::pi, static_cast<double>(b) * width);
    const double high = std::min(std::numbers::pi, low + width);
    apart += std::abs(on_ball.share[b] - 0.5 * (std::cos(low) - std::cos(high)));
  }
  CAPTURE(apart, on_ball.mean);
  CHECK(on_ball.mean == Approx(std::numbers::pi / 2).epsilon(0.01));
  CHECK(apart < 0.05);  // 64 sources

  const PreparedMesh ring = prepare_mesh(torus(60, 24));
  const PointsOnMeshArrays sources = vertices_as_points(ring, spread_vertices(ring, 16));
  const double off = histogram_distance(heat_to_vertices(ring, sources), exact_to_vertices(ring, sources));
  CAPTURE(off);
  CHECK(off < 0.12);
}

TEST_CASE("geodesic histogram: exact distances on the bunny", "[slow]") {
  MEANDER_NEEDS_SHARED_DATA();
  const FileBytes file(shared_data("paper/bunny_closed.off"));
  const PreparedMesh mesh = prepare_mesh(read_mesh(file.bytes(), MeshFormat::off));
  const PointsOnMeshArrays sources = vertices_as_points(mesh, spread_vertices(mesh, 4));
  const std::vector<double> exact = exact_to_vertices(mesh, sources), heat = heat_to_vertices(mesh, sources);
  const double largest = *std::max_element(exact.begin(), exact.end());
  const Errors errors = errors_of(heat, [&](std::size_t i) { return exact[i]; });
  const double off = histogram_distance(heat, exact);
  WARN("bunny: mean error " << 100 * errors.mean / largest << " % of the largest distance, worst "
                            << 100 * errors.worst / largest << " %; histograms differ by " << off << " of 2");
  CHECK(errors.mean < 0.01 * largest);
  CHECK(off < 0.08);
}
