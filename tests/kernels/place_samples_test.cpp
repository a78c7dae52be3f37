#include "kernels/sample/place_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <set>

#include "kernels/curve/curve_key.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/partition/element_cells.h"
#include "kernels/sample/sample_sites.h"
#include "kernels/sample/sequence.h"
#include "support/catch.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

const RandomKey test_key = make_random_key(5, {});

Density uniform_density() { return {}; }

// Density x + 2 at every corner (working coordinates lie in [-1, 1]).
Density linear_density(const PreparedMesh& mesh) {
  Density density;
  for (const std::uint32_t v : mesh.triangles) density.corner.push_back(mesh.x[v] + 2);
  return density;
}

CurveElements direct_elements(const PreparedMesh& mesh, const Density& density, std::uint64_t samples) {
  ElementParameters parameters;
  parameters.samples = samples;
  return build_elements({mesh, measure_of(mesh, density), test_key}, parameters);
}

struct FramedSamples {
  Samples samples;
  OutputFrame frame;
  RepairCounts repairs;
  Notes notes;
};

FramedSamples place_framed(const PolygonMesh& file, std::uint32_t n, PlaceParameters parameters = {},
                           std::uint64_t seed = 5) {
  const PreparedMesh mesh = prepare_mesh(file);
  parameters.samples = n;
  ElementParameters element;
  element.samples = n;
  element.use = ElementUse::vertices;
  const RandomKey key = make_random_key(seed, {});
  FramedSamples result;
  result.frame = output_frame(mesh, parameters.normalize);
  const MeshMeasure measure = measure_of(mesh, uniform_density());
  const SurfaceContext context{mesh, measure, key};
  result.samples = place_samples({context, file, parameters}, build_elements(context, element), result.frame,
                                 result.repairs, result.notes);
  return result;
}
Samples place(const PolygonMesh& file, std::uint32_t n, const PlaceParameters& parameters = {},
              std::uint64_t seed = 5) {
  return place_framed(file, n, parameters, seed).samples;
}

}  // namespace

TEST_CASE("build_elements: masses of a triangle's elements sum to its mass, none is too heavy") {
  for (const bool linear : {false, true}) {
    const PolygonMesh file = torus(16, 9);
    const PreparedMesh mesh = prepare_mesh(file);
    const Density density = linear ? linear_density(mesh) : uniform_density();
    const std::vector<double> masses = triangle_masses(mesh, density);
    const double total = std::accumulate(masses.begin(), masses.end(), 0.0);
    const std::uint64_t samples = 1000;
    const CurveElements elements = direct_elements(mesh, density, samples);
    CHECK(elements.total() == Approx(total).epsilon(1e-13));
    std::vector<double> sum(mesh.triangle_count(), 0.0);
    for (std::size_t i = 0; i < elements.count(); ++i) {
      const double mass = elements.cumulative[i + 1] - elements.cumulative[i];
      REQUIRE(mass <= total / (4.0 * samples) * (1 + 1e-9));
      sum[elements.triangle[i]] += mass;
    }
    for (std::size_t t = 0; t < sum.size(); ++t) REQUIRE(sum[t] == Approx(masses[t]).epsilon(1e-9));
  }
}

TEST_CASE("build_elements, build_cells: a large mesh gives the same with any number of threads") {
  const PreparedMesh mesh = prepare_mesh(torus(600, 300));
  REQUIRE(mesh.triangle_count() > 300000);
  const Density density = uniform_density();
  ElementParameters parameters;
  parameters.samples = 100000;  // some triangles are cut
  const auto elements = [&](std::size_t threads) {
    return on_threads(threads, [&] {
      return build_elements({mesh, measure_of(mesh, density), test_key}, parameters);
    });
  };
  const CurveElements one = elements(1);
  CHECK(one.count() > mesh.triangle_count());
  for (const std::size_t threads : {2u, 8u}) {
    const CurveElements more = elements(threads);
    CHECK(more.triangle == one.triangle);
    CHECK(more.path == one.path);
    CHECK(more.cumulative == one.cumulative);
  }
  parameters.samples = 3000;  // cells of a hundred entries each
  parameters.elements_per_sample = 12;
  parameters.order = ElementOrder::balanced;
  const auto sites = [&](std::size_t threads) {
    return on_threads(threads, [&] {
      return elements_in_net(build_cells({mesh, measure_of(mesh, density), test_key}, parameters), test_key,
                             false, {});
    });
  };
  const SampleSites net = sites(1);
  for (const std::size_t threads : {2u, 8u}) {
    const SampleSites more = sites(threads);
    REQUIRE(more.count() == net.count());
    for (std::size_t i = 0; i < net.count(); ++i) {
      CHECK(more.site[i].triangle == net.site[i].triangle);
      CHECK(more.site[i].path == net.site[i].path);
    }
  }
}

TEST_CASE("build_elements: a small part of a large box is sorted by whole keys, with any number of threads") {
  PolygonMesh file = torus(600, 300);
  // Far smaller than a cell of the coarse keys, beside a small triangle that makes the box.
  for (std::vector<double>* const axis : {&file.x, &file.y, &file.z})
    for (double& at : *axis) at *= 1e-6;
  const auto vertex = static_cast<std::uint32_t>(file.vertex_count());
  for (const std::array<double, 3>& at :
       {std::array<double, 3>{1, 1, 1}, {1, 1, 1 + 1e-8}, {1, 1 + 1e-8, 1}}) {
    file.x.push_back(at[0]);
    file.y.push_back(at[1]);
    file.z.push_back(at[2]);
  }
  file.corners.insert(file.corners.end(), {vertex, vertex + 1, vertex + 2});
  file.polygon_begin.push_back(static_cast<std::uint32_t>(file.corners.size()));
  const PreparedMesh mesh = prepare_mesh(file);
  const auto elements = [&](std::size_t threads) {
    return on_threads(threads, [&] { return direct_elements(mesh, uniform_density(), 64); });
  };
  const CurveElements one = elements(1);
  REQUIRE(one.count() == mesh.triangle_count());
  std::uint64_t last = 0;
  std::size_t different = 0;
  for (const std::uint32_t t : one.triangle) {
    const Vector3 c =
        (1.0 / 3) * (mesh.position(mesh.triangles[3 * t]) + mesh.position(mesh.triangles[3 * t + 1]) +
                     mesh.position(mesh.triangles[3 * t + 2]));
    const std::uint64_t key = hilbert_key_3d({static_cast<double>(static_cast<float>(c.x)),
                                              static_cast<double>(static_cast<float>(c.y)),
                                              static_cast<double>(static_cast<float>(c.z))});
    REQUIRE(key >= last);
    different += key != last;
    last = key;
  }
  CHECK(different > 5);
  const CurveElements more = elements(8);
  CHECK(more.triangle == one.triangle);
  CHECK(more.cumulative == one.cumulative);
}

TEST_CASE("build_cells: masses of a triangle's entries sum to its mass, every cell has its share") {
  for (const bool linear : {false, true}) {
    const PreparedMesh mesh = prepare_mesh(torus(16, 9));
    const Density density = linear ? linear_density(mesh) : uniform_density();
    const std::vector<double> masses = triangle_masses(mesh, density);
    const double total = std::accumulate(masses.begin(), masses.end(), 0.0);
    ElementParameters parameters;
    parameters.samples = 1000;
    parameters.elements_per_sample = 16;
    const ElementCells cells = build_cells({mesh, measure_of(mesh, density), test_key}, parameters);
    REQUIRE(cells.count() == 1000);
    std::vector<double> sum(mesh.triangle_count(), 0.0);
    for (const Cell& cell : cells.cells.cell) {
      double share = 0;
      for (const CellEntry& entry : cells.cells.entries(cell)) {
        const double mass = cells.cells.mass(entry);
        share += mass;
        sum[cells.triangle[entry.element()]] += mass;
      }
      REQUIRE(share == Approx(total / 1000).epsilon(1e-9));
    }
    for (std::size_t t = 0; t < sum.size(); ++t) REQUIRE(sum[t] == Approx(masses[t]).epsilon(1e-9));
  }
}

TEST_CASE("build_cells: cells are cut exactly where triangles are few for most of the mass") {
  const auto is_exact = [](const PolygonMesh& file, std::uint32_t samples, ElementUse use = ElementUse::net) {
    const PreparedMesh mesh = prepare_mesh(file);
    ElementParameters parameters;
    parameters.samples = samples;
    parameters.elements_per_sample = 12;
    parameters.use = use;
    const ElementCells cells = build_cells({mesh, measure_of(mesh, {}), test_key}, parameters);
    REQUIRE(cells.count() == samples);
    CHECK((cells.cells.point.empty() || use == ElementUse::net));
    return !cells.cells.point.empty() || cells.has_polygons();
  };
  const PolygonMesh ball = icosphere(3);  // 1,280 triangles that are nearly alike
  CHECK(is_exact(ball, 320));
  CHECK_FALSE(is_exact(ball, 320, ElementUse::positions));
  CHECK_FALSE(is_exact(ball, 213));  // 6 a sample
  CHECK(is_exact(ball, 320, ElementUse::places));
  CHECK_FALSE(is_exact(ball, 213, ElementUse::places));
  // Beside a large cube, most samples are in its twelve triangles; but there may not be any number of others.
  const PolygonMesh soup = merged(moved(ball, 0.05, 3, 0, 0), cube());
  CHECK(is_exact(soup, 213));
  CHECK(is_exact(soup, 82));
  CHECK_FALSE(is_exact(soup, 80));  // 16.2 a sample
}

TEST_CASE("build_cells: cells of long needles fall back to elements above the polygon limit") {
  std::vector<double> xyz;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < 10000; ++i) {
    const UnitPair from = random_pair(test_key, Stream::test_shapes, i, 0),
                   to = random_pair(test_key, Stream::test_shapes, i, 1),
                   z = random_pair(test_key, Stream::test_shapes, i, 2);
    xyz.insert(xyz.end(), {from.first, from.second, z.first, to.first, to.second, z.second, to.first + 1e-3,
                           to.second, z.second + 1e-3});
    faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const PreparedMesh needles = prepare_mesh(polygon_mesh(xyz, faces));
  ElementParameters parameters;
  parameters.samples = 3000;
  parameters.elements_per_sample = 12;
  parameters.use = ElementUse::places;
  const ElementCells cells = build_cells({needles, measure_of(needles, {}), test_key}, parameters);
  REQUIRE(cells.count() == 3000);
  CHECK_FALSE(cells.has_polygons());
  CHECK(!cells.cells.entries(cells.cells.cell.front()).empty());
}

TEST_CASE("build_cells: parts of split pieces lie where their paths say") {
  // One cell is passed along x, the largest extent, so entries ascend by the centroids of their pieces.
  PolygonMesh file;
  file.x = {0, 3, 0.7};
  file.y = {0, 0.1, 1};
  file.z = {0, 0.4, -0.2};
  file.corners = {0, 1, 2};
  file.polygon_begin = {0, 3};
  const PreparedMesh mesh = prepare_mesh(file);
  ElementParameters parameters;
  parameters.samples = 1;
  parameters.elements_per_sample = 64;
  const ElementCells cells = build_cells({mesh, measure_of(mesh, {}), test_key}, parameters);
  std::vector<std::uint32_t> order;
  order_entries(cells.cells, cells.cells.cell[0], order);
  REQUIRE(order.size() == 64);
  double last = -INFINITY;
  std::set<std::uint32_t> paths;
  for (const std::uint32_t number : order) {
    const CellEntry& entry = cells.cells.entries(cells.cells.cell[0])[number];
    const std::uint32_t path = cells.path_of(entry);
    paths.insert(path);
    const Piece piece = piece_of(bisection_corners(mesh, 0), path);
    double at = 0;
    for (std::size_t k = 0; k < 3; ++k)
      at += mesh.x[mesh.triangles[0]] * (1 - piece.b1[k] - piece.b2[k]) +
            mesh.x[mesh.triangles[1]] * piece.b1[k] + mesh.x[mesh.triangles[2]] * piece.b2[k];
    CHECK(at >= last - 1e-6);
    last = at;
  }
  CHECK(paths.size() == 64);
  CHECK(std::bit_width(*paths.begin()) == 7);
  CHECK(std::bit_width(*paths.rbegin()) == 7);
}

TEST_CASE("build_elements: hints request more elements and never change the mass") {
  const PreparedMesh mesh = prepare_mesh(icosphere(1));
  const std::vector<std::uint32_t> hits(mesh.triangle_count(), 37);
  ElementParameters parameters;
  parameters.samples = 1;
  const CurveElements elements =
      build_elements({mesh, measure_of(mesh, {}), test_key, {}, {hits, {}}}, parameters);
  CHECK(elements.count() == 64 * mesh.triangle_count());
  CHECK(elements.total() == Approx(mesh.total_area).epsilon(1e-13));
}

TEST_CASE("piece_of: the pieces of one depth tile the triangle") {
  const Vector3 a{0, 0, 0}, b{3, 0, 0}, c{0, 1, 0};
  for (int depth = 0; depth < 7; ++depth) {
    double area = 0;
    for (std::uint32_t path = 1u << depth; path < 2u << depth; ++path) {
      const Piece p = piece_of({a, b, c}, path);
      const double twice =
          (p.b1[1] - p.b1[0]) * (p.b2[2] - p.b2[0]) - (p.b1[2] - p.b1[0]) * (p.b2[1] - p.b2[0]);
      CHECK(std::abs(twice) == std::ldexp(1.0, -depth));
      area += std::abs(twice);
    }
    CHECK(area == 1.0);
  }
}

TEST_CASE("sample_sequence: stratified sets have one position per stratum, shifted ones one common shift") {
  for (const std::uint32_t n : {1u, 7u, 256u, 1000u}) {
    const auto stratified = sample_sequence(SequenceKind::stratified, n, 0.25, test_key);
    for (std::uint32_t i = 0; i < n; ++i) REQUIRE(std::floor(stratified[i] * n) == i);
    const auto regular = sample_sequence(SequenceKind::regular, n, 0.25, test_key);
    const auto systematic = sample_sequence(SequenceKind::shifted, n, 0, test_key);
    for (std::uint32_t i = 1; i < n; ++i) {
      REQUIRE(regular[i] - regular[i - 1] == Approx(1.0 / n));
      REQUIRE(systematic[i] - systematic[i - 1] == Approx(1.0 / n));
    }
    for (const SequenceKind kind : {SequenceKind::shifted, SequenceKind::owen, SequenceKind::random}) {
      const auto t = sample_sequence(kind, n, 0.25, test_key);
      REQUIRE(std::is_sorted(t.begin(), t.end()));
      REQUIRE(t.front() >= 0);
      REQUIRE(t.back() < 1);
    }
  }
}

TEST_CASE("sample_sequence: every position is uniform over seeds") {
  // 4000 seeds of 3 positions: the mean of each sorted set is 1/2, and the share below 0.1 is 0.1 (4 sigma).
  for (const SequenceKind kind :
       {SequenceKind::shifted, SequenceKind::stratified, SequenceKind::owen, SequenceKind::random}) {
    double sum = 0, low = 0;
    for (std::uint64_t seed = 0; seed < 4000; ++seed)
      for (const double t : sample_sequence(kind, 3, 0.25, make_random_key(seed, {}))) {
        sum += t / 12000;
        low += (t < 0.1) / 12000.0;
      }
    CHECK(sum == Approx(0.5).margin(4 * 0.2887 / std::sqrt(12000.0)));
    CHECK(low == Approx(0.1).margin(4 * 0.3 / std::sqrt(12000.0)));
  }
}

TEST_CASE("sample_sequence: owen points fill every binary interval and can be extended") {
  const SampleSequence small = make_sequence(SequenceKind::owen, 64, 0, test_key),
                       large = make_sequence(SequenceKind::owen, 256, 0, test_key);
  for (std::uint32_t i = 0; i < 64; ++i) REQUIRE(std::floor(small.position[i] * 64) == i);
  for (std::uint32_t i = 0; i < 64; ++i)
    REQUIRE(small.position[small.rank_of_index[i]] == large.position[large.rank_of_index[i]]);
}

TEST_CASE("progressive_order: a permutation whose prefixes are spread along the curve") {
  for (const std::uint32_t n : {1u, 2u, 3u, 5u, 7u, 8u, 100u, 256u, 1000u, 3000u}) {
    const auto order = progressive_order(n, test_key);
    std::vector<std::uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t i = 0; i < n; ++i) REQUIRE(sorted[i] == i);
    for (std::uint32_t k = 1; k <= n; k *= 2) {  // prefixes of 2^k: one in every block [b n/k, (b+1) n/k)
      std::vector<int> hits(k, 0);
      for (std::uint32_t i = 0; i < k; ++i) {
        std::uint32_t block = 0;
        while ((std::uint64_t{block} + 1) * n / k <= order[i]) ++block;
        ++hits[block];
      }
      for (const int h : hits) REQUIRE(h == 1);
    }
  }
}

TEST_CASE("progressive_order: a power of two gives bit reversal under a mask") {
  const auto order = progressive_order(16, test_key);
  const std::uint32_t mask = order[0];
  for (std::uint32_t i = 0; i < 16; ++i) {
    const std::uint32_t reversed = (i & 1) << 3 | (i & 2) << 1 | (i & 4) >> 1 | (i & 8) >> 3;
    CHECK(order[i] == (reversed ^ mask));
  }
}

TEST_CASE("place_samples: exactly n distinct points on their polygons, for every sequence, order and place") {
  const PolygonMesh file = cube();
  for (const std::uint32_t n : {1u, 7u, 256u, 5000u})
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::stratified, SequenceKind::owen,
                                        SequenceKind::regular, SequenceKind::random, SequenceKind::spaced})
      for (const OrderKind order : {OrderKind::progressive, OrderKind::curve})
        for (const PlaceKind where : {PlaceKind::element, PlaceKind::vertex}) {
          if (sequence == SequenceKind::spaced && where == PlaceKind::vertex) continue;
          PlaceParameters parameters;
          parameters.sequence = sequence;
          parameters.order = order;
          parameters.place = where;
          const Samples s = place(file, n, parameters);
          std::set<std::array<float, 3>> distinct;
          std::vector<std::uint32_t> ranks = s.curve_rank;
          std::sort(ranks.begin(), ranks.end());
          for (std::uint32_t i = 0; i < n; ++i) {
            REQUIRE(ranks[i] == i);
            const std::array<float, 3> p = {s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]};
            distinct.insert(p);
            const double b1 = s.barycentric[2 * i], b2 = s.barycentric[2 * i + 1], b0 = 1 - b1 - b2;
            for (std::size_t axis = 0; axis < 3; ++axis) {
              const auto& c = axis == 0 ? file.x : axis == 1 ? file.y : file.z;
              REQUIRE(p[axis] == Approx(b0 * c[s.corners[3 * i]] + b1 * c[s.corners[3 * i + 1]] +
                                        b2 * c[s.corners[3 * i + 2]])
                                     .margin(1e-6));
            }
            // The normal of face f of the cube is along one axis, and the point lies in that plane.
            const double height =
                s.normals[3 * i] * p[0] + s.normals[3 * i + 1] * p[1] + s.normals[3 * i + 2] * p[2];
            REQUIRE(height == Approx(1).margin(1e-6));
            REQUIRE(s.face[i] < 6);
          }
          REQUIRE(distinct.size() == n);
        }
}

TEST_CASE("place_samples: counts per face follow area") {
  // A closed box whose faces have areas 1, 2, 2 (x 4): n x share +- 1 for a stratified sequence along the
  // curve is not exact per face, but the error of each face is far below random: sqrt(n p (1 - p)) = 20 here.
  PolygonMesh box = cube();
  for (double& x : box.x) x *= 2;
  const std::uint32_t n = 2000;
  const Samples s = place(box, n);
  std::array<int, 6> counts{};
  for (const std::uint32_t f : s.face) ++counts[f];
  const double total = 2 * 4 + 4 * 8;
  const double share[6] = {8 / total, 8 / total, 8 / total, 4 / total, 8 / total, 4 / total};
  for (std::size_t f = 0; f < 6; ++f) CHECK(counts[f] == Approx(n * share[f]).margin(12));
}

TEST_CASE("place_samples: repeated points are redrawn unless float32 has no other point") {
  // Float32 holds few points on a triangle of 4 ulps: 200 distinct ones are impossible, the rest is counted.
  const double ulp = 0x1p-23;
  PolygonMesh sliver = polygon_mesh({1, 0, 0, 1 + 4 * ulp, 0, 0, 1, 4 * ulp, 0}, {{0, 1, 2}});
  const PreparedMesh mesh = prepare_mesh(sliver);
  PlaceParameters parameters;
  parameters.samples = 200;
  RepairCounts repairs;
  Notes notes;
  // Without a moved frame the stored x takes 5 values and y many: distinct points exist; x only: they do not.
  OutputFrame frame;
  frame.loc = {0, 0, 0};
  const MeshMeasure measure = measure_of(mesh, {});
  const PlaceContext context{{mesh, measure, test_key}, sliver, parameters};
  const Samples s = place_samples(context, direct_elements(mesh, {}, 200), frame, repairs, notes);
  std::set<std::array<float, 3>> distinct;
  for (std::size_t i = 0; i < 200; ++i)
    distinct.insert({s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]});
  CHECK(distinct.size() + repairs[Repair::coincident_points] == 200);
  frame.scale = 1e44;  // a handful of denormal values is left
  RepairCounts collapsed;
  place_samples(context, direct_elements(mesh, {}, 200), frame, collapsed, notes);
  CHECK(collapsed[Repair::coincident_points] > 0);
}

TEST_CASE("output_frame: distant meshes are stored about their center, loc and scale undo normalization") {
  const PreparedMesh near = prepare_mesh(icosphere(1)), far = prepare_mesh(moved(icosphere(1), 1, 1e5, 0, 0));
  CHECK(output_frame(near, NormalizeKind::none).loc.x == 0);
  CHECK(output_frame(far, NormalizeKind::none).loc.x == Approx(1e5));
  const PolygonMesh file = moved(icosphere(2), 3, 10, 20, 30);
  for (const NormalizeKind kind : {NormalizeKind::unit_sphere, NormalizeKind::unit_box}) {
    PlaceParameters parameters;
    parameters.normalize = kind;
    const Samples s = place(file, 500, parameters);
    double radius = 0, box = 0;
    for (std::size_t i = 0; i < 500; ++i) {
      const double x = s.points[3 * i], y = s.points[3 * i + 1], z = s.points[3 * i + 2];
      radius = std::max(radius, std::sqrt(x * x + y * y + z * z));
      box = std::max({box, std::abs(x), std::abs(y), std::abs(z)});
    }
    if (kind == NormalizeKind::unit_sphere) CHECK(radius == Approx(1).margin(0.05));
    if (kind == NormalizeKind::unit_box) CHECK(box == Approx(0.5).margin(0.02));
  }
}

namespace {

constexpr NormalizeKind all_normalizations[] = {NormalizeKind::none, NormalizeKind::unit_sphere,
                                                NormalizeKind::unit_box, NormalizeKind::unit_diagonal,
                                                NormalizeKind::pointnet};

Vector3 stored_point_of(const FramedSamples& s, std::size_t i) {
  return {s.samples.points[3 * i], s.samples.points[3 * i + 1], s.samples.points[3 * i + 2]};
}
Vector3 file_point_of(const FramedSamples& s, std::size_t i) {
  return s.frame.loc + s.frame.scale * stored_point_of(s, i);
}

// Mean and largest distance from 0 of the stored points.
struct Spread {
  Vector3 mean;
  double farthest = 0;
};
Spread spread_of(const FramedSamples& s) {
  Spread spread;
  const std::size_t n = s.samples.count();
  for (std::size_t i = 0; i < n; ++i) {
    spread.mean = spread.mean + 1.0 / static_cast<double>(n) * stored_point_of(s, i);
    spread.farthest = std::max(spread.farthest, norm(stored_point_of(s, i)));
  }
  return spread;
}

std::size_t count_distinct(const Samples& samples) {
  std::set<std::array<float, 3>> distinct;
  for (std::size_t i = 0; i < samples.count(); ++i)
    distinct.insert({samples.points[3 * i], samples.points[3 * i + 1], samples.points[3 * i + 2]});
  return distinct.size();
}

}  // namespace

TEST_CASE("output_frame: closed forms of a box, for every normalization") {
  PolygonMesh box = cube();  // sides 4, 2 and 1, center 10, -20, 30
  for (std::size_t v = 0; v < box.vertex_count(); ++v) {
    box.x[v] = 10 + 2 * box.x[v];
    box.y[v] = -20 + box.y[v];
    box.z[v] = 30 + 0.5 * box.z[v];
  }
  const PreparedMesh mesh = prepare_mesh(box);
  CHECK(output_frame(mesh, NormalizeKind::none) == OutputFrame{});
  CHECK(output_frame(mesh, NormalizeKind::unit_box).scale == 4);
  CHECK(output_frame(mesh, NormalizeKind::unit_sphere).scale == Approx(std::sqrt(21.0) / 2).epsilon(1e-15));
  CHECK(output_frame(mesh, NormalizeKind::unit_diagonal).scale == Approx(std::sqrt(21.0)).epsilon(1e-15));
  for (const NormalizeKind kind :
       {NormalizeKind::unit_sphere, NormalizeKind::unit_box, NormalizeKind::unit_diagonal})
    CHECK(distance(output_frame(mesh, kind).loc, {10, -20, 30}) == 0);
}

TEST_CASE("place_samples: the same points of the file for every normalization, up to float32") {
  for (const PolygonMesh& file : {moved(torus(24, 12), 3, 10, 20, 30), moved(tetrahedron(), 1e-3, 0.5, 0, 0),
                                  moved(cube(), 50, 1e6, -1e6, 0)})
    for (const SequenceKind sequence : {SequenceKind::shifted, SequenceKind::random, SequenceKind::spaced}) {
      PlaceParameters parameters;
      parameters.sequence = sequence;
      const FramedSamples plain = place_framed(file, 1000, parameters);
      const double diagonal = prepare_mesh(file).diagonal;
      for (const NormalizeKind kind : all_normalizations) {
        parameters.normalize = kind;
        const FramedSamples s = place_framed(file, 1000, parameters);
        REQUIRE(s.samples.barycentric == plain.samples.barycentric);
        REQUIRE(s.samples.face == plain.samples.face);
        REQUIRE(count_distinct(s.samples) == 1000);
        double far = 0;
        for (std::size_t i = 0; i < 1000; ++i)
          far = std::max(far, distance(file_point_of(s, i), file_point_of(plain, i)));
        CHECK(far < 1e-4 * diagonal);  // float32 keeps 2^-14 of it, 2^-24 where normalized
      }
    }
}

TEST_CASE("place_samples: pointnet centers the samples at their mean, with the farthest at 1") {
  for (const std::uint32_t n : {2u, 3u, 64u, 5000u, 40000u})
    for (const OrderKind order : {OrderKind::progressive, OrderKind::curve}) {
      PlaceParameters parameters;
      parameters.normalize = NormalizeKind::pointnet;
      parameters.order = order;
      // Not symmetric: the mean is not the center of the box.
      const PolygonMesh file = moved(merged(icosphere(2), moved(cube(), 0.2, 3, 0, 0)), 7, 100, -50, 20);
      const FramedSamples s = place_framed(file, n, parameters);
      const Spread spread = spread_of(s);
      INFO(n);
      CHECK(norm(spread.mean) < 1e-7);
      CHECK(std::abs(spread.farthest - 1) <= 0x1p-24);
      // As pc_normalize computes it from the points of the file.
      parameters.normalize = NormalizeKind::none;
      const FramedSamples plain = place_framed(file, n, parameters);
      Vector3 mean;
      for (std::size_t i = 0; i < n; ++i) mean = mean + 1.0 / n * file_point_of(plain, i);
      double farthest = 0;
      for (std::size_t i = 0; i < n; ++i)
        farthest = std::max(farthest, distance(file_point_of(plain, i), mean));
      CHECK(distance(s.frame.loc, mean) < 1e-5);
      CHECK(s.frame.scale == Approx(farthest).epsilon(1e-6));
      CHECK(distance(s.frame.loc, output_frame(prepare_mesh(file), NormalizeKind::pointnet).loc) > 0.1);
      // Whatever the order in the file and the threads.
      parameters.normalize = NormalizeKind::pointnet;
      parameters.order = order == OrderKind::curve ? OrderKind::progressive : OrderKind::curve;
      CHECK(place_framed(file, n, parameters).frame == s.frame);
      for (const std::size_t threads : {1, 3})
        CHECK(on_threads(threads, [&] { return place_framed(file, n, parameters).frame; }) == s.frame);
    }
}

TEST_CASE("place_samples: pointnet puts a single sample at 0, with the scale of unit-sphere") {
  PlaceParameters parameters;
  parameters.normalize = NormalizeKind::pointnet;
  const PolygonMesh file = moved(torus(12, 8), 1, 1e5, 0, 0);
  const FramedSamples s = place_framed(file, 1, parameters);
  CHECK(norm(stored_point_of(s, 0)) < 1e-9);
  CHECK(s.frame.scale == output_frame(prepare_mesh(file), NormalizeKind::unit_sphere).scale);
  parameters.normalize = NormalizeKind::none;
  CHECK(distance(s.frame.loc, file_point_of(place_framed(file, 1, parameters), 0)) < 1e-2);
}

TEST_CASE("place_samples: pointnet is computed after repeated points are redrawn") {
  // Two specks of some 1,000 places of float32 each, far apart.
  const double side = 40 * 0x1p-23;
  const auto speck = [&](double at) {
    return polygon_mesh({at, at, at, at + side, at, at, at, at + side, at}, {{0, 1, 2}});
  };
  const PolygonMesh file = merged(speck(1), speck(-1));
  PlaceParameters parameters;
  parameters.normalize = NormalizeKind::pointnet;
  const FramedSamples s = place_framed(file, 200, parameters);
  CHECK(count_distinct(s.samples) == 200);
  CHECK(s.repairs[Repair::coincident_points] == 0);
  CHECK(norm(spread_of(s).mean) < 1e-7);
  CHECK(std::abs(spread_of(s).farthest - 1) <= 0x1p-24);
  // Other samples are drawn again than in another frame.
  parameters.normalize = NormalizeKind::none;
  const FramedSamples plain = place_framed(file, 200, parameters);
  CHECK(plain.samples.barycentric != s.samples.barycentric);
  // More samples than places: some stay at one place, and the frame is that of all of them all the same.
  parameters.normalize = NormalizeKind::pointnet;
  const FramedSamples crowded = place_framed(file, 6000, parameters);
  CHECK(crowded.repairs[Repair::coincident_points] > 0);
  CHECK(count_distinct(crowded.samples) + crowded.repairs[Repair::coincident_points] == 6000);
  CHECK(norm(spread_of(crowded).mean) < 1e-7);
  CHECK(std::abs(spread_of(crowded).farthest - 1) <= 2 * 0x1p-24);
}

TEST_CASE("place_samples: normals of the file are interpolated, unusable ones replaced") {
  PolygonMesh file = icosphere(2);
  for (std::size_t v = 0; v < file.x.size(); ++v)
    file.normals.insert(file.normals.end(), {static_cast<float>(file.x[v]), static_cast<float>(file.y[v]),
                                             static_cast<float>(file.z[v])});
  const Samples s = place(file, 300);
  for (std::size_t i = 0; i < 300; ++i) {
    const double r = std::hypot(s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]);
    for (std::size_t k = 0; k < 3; ++k)
      REQUIRE(s.normals[3 * i + k] == Approx(s.points[3 * i + k] / r).margin(0.02));
  }
  std::fill(file.normals.begin(), file.normals.end(), 0.0f);
  const Samples geometric = place(file, 10);
  for (std::size_t i = 0; i < 10; ++i)
    CHECK(std::hypot(geometric.normals[3 * i], geometric.normals[3 * i + 1], geometric.normals[3 * i + 2]) ==
          Approx(1).epsilon(1e-6));
}

TEST_CASE("elements_at: finds the element that holds each position") {
  CurveElements elements;
  elements.cumulative = {0};
  for (std::uint32_t e = 0; e < 5000; ++e) {
    elements.triangle.push_back(e);
    elements.path.push_back(1);
    // Some have no mass, the last ones among them.
    const bool empty = e % 7 == 3 || e >= 4990 || (e > 1000 && e < 1100);
    elements.cumulative.push_back(elements.cumulative.back() + (empty ? 0.0 : 1.0 + e % 5));
  }
  const double total = elements.total();
  for (const std::size_t count :
       {std::size_t{1}, std::size_t{2}, std::size_t{9}, std::size_t{300}, std::size_t{20000}}) {
    std::vector<double> position;
    for (std::size_t i = 0; i < count; ++i)
      position.push_back(static_cast<double>(i) / static_cast<double>(count));
    for (const std::size_t e : {0u, 1u, 1000u, 1099u, 1100u, 4989u})  // where elements begin
      position.push_back(elements.cumulative[e] / total);
    position.push_back(below_one);
    std::sort(position.begin(), position.end());
    const SampleSites found = elements_at(elements, position, false, {});
    std::size_t expected = 0;
    for (std::size_t i = 0; i < position.size(); ++i) {
      const double target = position[i] * total;
      while (expected < 4989 && elements.cumulative[expected + 1] <= target) ++expected;
      REQUIRE(found.site[i].triangle == expected);
    }
  }
}

TEST_CASE("output_frame: unit-sphere ignores faces without area inside the box") {
  // A rhombus, and a face without area that ends in a corner of its box.
  const PolygonMesh mesh =
      polygon_mesh({1, 0, 0, 2, 1, 0, 1, 2, 0, 0, 1, 0, 0, 2, 0, 0, 1.5, 0}, {{0, 1, 2, 3}, {3, 5, 4}});
  for (const PreparedMesh& prepared : {prepare_mesh(mesh), prepare_soup(mesh)})
    CHECK(output_frame(prepared, NormalizeKind::unit_sphere).scale == 1);
}
