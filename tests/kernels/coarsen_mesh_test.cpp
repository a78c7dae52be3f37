#include "kernels/mesh/coarsen_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "kernels/density/density.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/partition/chart_places.h"
#include "support/catch.h"
#include "support/hand_charts.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr CoarsenParameters few = {0.25, 64, 64};

CoarseMesh coarsened(const PreparedMesh& mesh, const CoarsenParameters& parameters = few,
                     std::uint64_t samples = 1) {
  return coarsen_mesh(mesh, mesh.area, samples, parameters);
}

double sum_of(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// One component: opposites agree, every star is one fan, and genus and boundary loops are what is said.
void check_component(const PreparedMesh& mesh, const Component& component) {
  REQUIRE(component.triangle_end > component.triangle_begin);
  std::map<std::uint32_t, std::size_t> incident;                 // triangles at each vertex
  std::map<std::uint32_t, std::uint32_t> leaving, next_on_loop;  // a half-edge from it; along the boundary
  std::size_t border = 0;
  for (std::uint32_t h = 3 * component.triangle_begin; h < 3 * component.triangle_end; ++h) {
    const std::uint32_t from = mesh.triangles[h], to = mesh.triangles[next_half_edge(h)];
    REQUIRE(from >= component.vertex_begin);
    REQUIRE(from < component.vertex_end);
    REQUIRE(from != to);
    ++incident[from];
    if (!leaving.contains(from) || mesh.opposite[h] == no_index) leaving[from] = h;
    if (mesh.opposite[h] == no_index) {
      REQUIRE(next_on_loop.emplace(from, to).second);
      ++border;
      continue;
    }
    REQUIRE(mesh.opposite[mesh.opposite[h]] == h);
    REQUIRE(mesh.triangles[mesh.opposite[h]] == to);
    REQUIRE(mesh.triangles[next_half_edge(mesh.opposite[h])] == from);
    REQUIRE(mesh.opposite[h] / 3 != h / 3);
  }
  REQUIRE(incident.size() == component.vertex_end - component.vertex_begin);
  for (const auto& [vertex, first] : leaving) {
    std::size_t fan = 0;
    std::uint32_t h = first;
    do {
      ++fan;
      h = mesh.opposite[previous_half_edge(h)];
    } while (h != first && h != no_index && fan <= incident[vertex]);
    REQUIRE(fan == incident[vertex]);
  }
  std::uint32_t loops = 0;
  while (!next_on_loop.empty()) {
    ++loops;
    for (auto at = next_on_loop.begin(); at != next_on_loop.end();) {
      const std::uint32_t to = at->second;
      next_on_loop.erase(at);
      at = next_on_loop.find(to);
    }
  }
  CHECK(loops == component.boundary_loops);
  const auto triangles = static_cast<std::int64_t>(component.triangle_end - component.triangle_begin);
  const auto edges = (3 * triangles + static_cast<std::int64_t>(border)) / 2;
  CHECK(static_cast<std::int64_t>(incident.size()) - edges + triangles ==
        2 - 2 * std::int64_t{component.genus} - std::int64_t{component.boundary_loops});
}

// What holds for every result that is not empty.
void check_coarse(const PreparedMesh& fine, const CoarseMesh& coarse) {
  const PreparedMesh& mesh = coarse.mesh;
  REQUIRE(coarse.triangle.size() == fine.triangle_count());
  REQUIRE(mesh.components.size() == fine.components.size());
  REQUIRE(mesh.triangle_count() < fine.triangle_count());
  REQUIRE(mesh.triangles.size() == 3 * mesh.triangle_count());
  REQUIRE(mesh.opposite.size() == mesh.triangles.size());
  REQUIRE(mesh.area.size() == mesh.triangle_count());
  REQUIRE(coarse.masses.size() == mesh.triangle_count());
  CHECK(sum_of(coarse.masses) == Approx(sum_of(fine.area)).epsilon(1e-12));
  CHECK(mesh.total_area == Approx(sum_of(mesh.area)).epsilon(1e-12));
  std::set<std::array<double, 3>> vertices;
  for (std::uint32_t v = 0; v < fine.vertex_count(); ++v) vertices.insert({fine.x[v], fine.y[v], fine.z[v]});
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    REQUIRE(vertices.contains({mesh.x[v], mesh.y[v], mesh.z[v]}));
  std::uint32_t triangle = 0, vertex = 0;
  for (std::size_t c = 0; c < mesh.components.size(); ++c) {
    const Component& component = mesh.components[c];
    CHECK(component.triangle_begin == triangle);
    CHECK(component.vertex_begin == vertex);
    triangle = component.triangle_end;
    vertex = component.vertex_end;
    check_component(mesh, component);
    for (std::uint32_t t = fine.components[c].triangle_begin; t < fine.components[c].triangle_end; ++t)
      REQUIRE(
          (coarse.triangle[t] >= component.triangle_begin && coarse.triangle[t] < component.triangle_end));
  }
  CHECK(triangle == mesh.triangle_count());
  CHECK(vertex == mesh.vertex_count());
}

// A fan of n triangles round one vertex, on a cone.
PolygonMesh cone(std::uint32_t n) {
  std::vector<double> xyz = {0, 0, 0.5};
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * 3.14159265358979 * i / n;
    xyz.insert(xyz.end(), {std::cos(angle), std::sin(angle), 0});
    faces.push_back({0, 1 + i, 1 + (i + 1) % n});
  }
  return polygon_mesh(std::move(xyz), std::move(faces));
}

double longest_edge(const PreparedMesh& mesh) {
  double longest = 0;
  for (std::uint32_t h = 0; h < mesh.triangles.size(); ++h)
    longest = std::max(longest, mesh.length_in_space(h));
  return longest;
}

}  // namespace

TEST_CASE("coarsen_mesh: preserves topology and area of every kind of surface") {
  for (const PolygonMesh& mesh :
       {icosphere(4), torus(60, 30), two_sided_plate(24, 0.02), folded_sheet(6, 12, 0.01), grid_plane(40, 30),
        merged(icosphere(4), moved(torus(40, 20), 0.4, 3, 0, 0))}) {
    const PreparedMesh fine = prepare_mesh(mesh);
    const CoarseMesh coarse = coarsened(fine);
    REQUIRE(!coarse.empty());
    check_coarse(fine, coarse);
    INFO(fine.triangle_count() << " to " << coarse.mesh.triangle_count());
    CHECK(coarse.mesh.triangle_count() < 200 * fine.components.size());
    const CoarseMesh finer = coarsened(fine, {600, 64});
    check_coarse(fine, finer);
    CHECK(finer.mesh.total_area == Approx(fine.total_area).epsilon(0.1));
  }
}

TEST_CASE("coarsen_mesh: handles survive, even if nothing else is left") {
  const PreparedMesh slab = prepare_mesh(slab_with_tunnels(12));
  REQUIRE(slab.components.at(0).genus == 12);
  const CoarseMesh coarse = coarsened(slab);
  if (!coarse.empty()) check_coarse(slab, coarse);
  const PreparedMesh thin = prepare_mesh(torus(200, 12, 1, 0.1));
  check_coarse(thin, coarsened(thin));
}

TEST_CASE("coarsen_mesh: about as many triangles as requested, of about equal size") {
  const PreparedMesh fine = prepare_mesh(icosphere(6));
  for (const double wanted : {500.0, 2000.0, 8000.0}) {
    const CoarseMesh coarse = coarsened(fine, {wanted / 1000, 64}, 1000);
    check_coarse(fine, coarse);
    CHECK(static_cast<double>(coarse.mesh.triangle_count()) == Approx(wanted).epsilon(0.25));
    CHECK(coarse.mesh.total_area == Approx(fine.total_area).epsilon(20 / wanted));
    const double mean = coarse.mesh.total_area / static_cast<double>(coarse.mesh.triangle_count());
    CHECK(longest_edge(coarse.mesh) < 4.5 * std::sqrt(mean));  // 1.5: equilateral
    CHECK(*std::max_element(coarse.masses.begin(), coarse.masses.end()) < 6 * mean);
  }
  // The least numbers hold whatever the samples.
  CHECK(static_cast<double>(coarsened(fine, {2, 3000}, 1).mesh.triangle_count()) ==
        Approx(3000).epsilon(0.25));
  const PreparedMesh pair = prepare_mesh(merged(icosphere(6), moved(icosphere(5), 0.01, 3, 0, 0)));
  const CoarseMesh coarse_pair = coarsened(pair, {2, 3000, 500}, 1);
  check_coarse(pair, coarse_pair);
  for (const Component& c : coarse_pair.mesh.components)
    CHECK(static_cast<double>(c.triangle_end - c.triangle_begin) ==
          Approx(c.area > 0.1 ? 3000 : 500).epsilon(0.25));
}

TEST_CASE("coarsen_mesh: fine regular grids are coarsened fully") {
  // Shapes of cells whose vertices can be moved only so that a triangle has a height below a quarter.
  for (const auto& [around, across] : {std::pair<std::uint32_t, std::uint32_t>{1000, 500}, {500, 250}}) {
    const PreparedMesh mesh = prepare_mesh(torus(around, across));
    const CoarseMesh coarse = coarsened(mesh, CoarsenParameters{}, 2048);
    INFO(around << " x " << across);
    CHECK(coarse.mesh.triangle_count() < 2 * 1.5 * 2048);
    CHECK(sum_of(coarse.masses) == Approx(sum_of(mesh.area)));
  }
}

TEST_CASE("coarsen_mesh: triangles are small where the density is high") {
  const PreparedMesh fine = prepare_mesh(icosphere(6));
  std::vector<double> masses = fine.area;
  const auto above = [](const PreparedMesh& mesh, std::size_t t) {
    return mesh.z[mesh.triangles[3 * t]] + mesh.z[mesh.triangles[3 * t + 1]] +
               mesh.z[mesh.triangles[3 * t + 2]] >
           0;
  };
  for (std::size_t t = 0; t < masses.size(); ++t)
    if (above(fine, t)) masses[t] *= 100;
  const CoarseMesh coarse = coarsen_mesh(fine, masses, 1000, {2, 64});
  double upper = 0, lower = 0;
  for (std::size_t t = 0; t < coarse.mesh.triangle_count(); ++t) (above(coarse.mesh, t) ? upper : lower) += 1;
  CHECK(upper > 2 * lower);
  CHECK(sum_of(coarse.masses) == Approx(sum_of(masses)).epsilon(1e-12));
}

TEST_CASE("coarsen_mesh: small meshes are unchanged, small components beside large ones too") {
  CHECK(coarsened(prepare_mesh(tetrahedron())).empty());
  CHECK(coarsened(prepare_mesh(icosphere(1))).empty());
  const PreparedMesh fine = prepare_mesh(icosphere(5));
  CHECK(coarsened(fine, {1e12, 64}, 1).empty());
  CHECK(coarsened(fine, {2, 20000}, 1).empty());
  CHECK(coarsened(fine, {2, 64, 20000}, 1).empty());
  CHECK(coarsened(fine, {2, 64}, 10000).empty());
  const PreparedMesh both = prepare_mesh(merged(icosphere(5), moved(icosphere(1), 0.1, 5, 0, 0)));
  const CoarseMesh coarse = coarsened(both);
  check_coarse(both, coarse);
  for (std::size_t c = 0; c < 2; ++c) {
    const Component& before = both.components[c];
    const Component& after = coarse.mesh.components[c];
    if (before.triangle_end - before.triangle_begin > 80) continue;
    REQUIRE(after.triangle_end - after.triangle_begin == 80);
    CHECK(after.area == Approx(before.area).epsilon(1e-14));
    for (std::uint32_t t = before.triangle_begin; t < before.triangle_end; ++t)
      CHECK(coarse.triangle[t] == after.triangle_begin + (t - before.triangle_begin));
  }
}

TEST_CASE("coarsen_mesh: a plane is reproduced, and fine triangles stay where they were") {
  const PolygonMesh plane = moved(grid_plane(50, 50), 0.7, 1, 2, 3);
  const PreparedMesh fine = prepare_mesh(plane);
  const CoarseMesh coarse = coarsened(fine);
  check_coarse(fine, coarse);
  CHECK(coarse.mesh.total_area == Approx(fine.total_area).epsilon(0.1));
  // A chart that is the plane itself, as some affine map of space: each corner is mapped to where it lies.
  const auto map = [](Vector3 p) {
    return std::pair(0.3 + 0.1 * p.x - 0.02 * p.y + 0.05 * p.z, 0.4 - 0.03 * p.x + 0.09 * p.y + 0.01 * p.z);
  };
  const std::vector<FlatChart> charts = {hand_chart(coarse.mesh, coarse.mesh.components[0], map)};
  const ChartPlaces places(fine, {charts, &coarse});
  for (std::size_t t = 0; t < fine.triangle_count(); ++t) {
    std::array<double, 3> u{}, v{};
    REQUIRE(places.find(t, u, v));
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 p = fine.center + fine.unit * fine.position(fine.triangles[3 * t + k]);
      const auto [expected_u, expected_v] = map(p);
      REQUIRE(u[k] == Approx(expected_u).margin(1e-9));
      REQUIRE(v[k] == Approx(expected_v).margin(1e-9));
    }
  }
}

TEST_CASE("coarsen_mesh: the coarse triangle lies under the fine one") {
  const PreparedMesh fine = prepare_mesh(icosphere(5));
  const CoarseMesh coarse = coarsened(fine, {0.5, 64}, 1000);
  check_coarse(fine, coarse);
  std::size_t outside = 0;
  for (std::size_t t = 0; t < fine.triangle_count(); ++t) {
    Vector3 centroid;
    for (std::size_t k = 0; k < 3; ++k)
      centroid = centroid + (1.0 / 3) * fine.position(fine.triangles[3 * t + k]);
    const PlaneWeights plane = plane_weights(coarse.mesh, coarse.triangle[t]);
    const double b1 = dot(plane.first, centroid - plane.origin),
                 b2 = dot(plane.second, centroid - plane.origin);
    const double least = std::min({b1, b2, 1 - b1 - b2});
    CHECK(least > -0.2);
    outside += least < -1e-9 ? 1 : 0;
  }
  CHECK(static_cast<double>(outside) < 0.05 * static_cast<double>(fine.triangle_count()));
}

TEST_CASE("coarsen_mesh: adversarial meshes keep their topology") {
  // A vertex of 5,000 neighbors, needles, coincident vertices, lengths at the ends of double.
  const PreparedMesh fan = prepare_mesh(cone(5000));
  const CoarseMesh coarse_fan = coarsened(fan);
  if (!coarse_fan.empty()) check_coarse(fan, coarse_fan);
  PolygonMesh needles = torus(300, 4);
  for (double& z : needles.z) z *= 1e-6;
  const PreparedMesh flat = prepare_mesh(needles);
  const CoarseMesh coarse_flat = coarsened(flat);
  if (!coarse_flat.empty()) check_coarse(flat, coarse_flat);
  PreparedMesh collapsed = prepare_mesh(icosphere(4));
  for (std::size_t i = 0; i < collapsed.x.size(); i += 3)
    collapsed.x[i] = collapsed.y[i] = collapsed.z[i] = 0.25;
  for (std::size_t t = 0; t < collapsed.triangle_count(); ++t)
    collapsed.area[t] = triangle_area(collapsed.position(collapsed.triangles[3 * t]),
                                      collapsed.position(collapsed.triangles[3 * t + 1]),
                                      collapsed.position(collapsed.triangles[3 * t + 2]));
  collapsed.total_area = sum_of(collapsed.area);
  const CoarseMesh coarse_collapsed = coarsened(collapsed);
  if (!coarse_collapsed.empty()) {
    check_coarse(collapsed, coarse_collapsed);
    for (std::size_t t = 0; t < coarse_collapsed.mesh.triangle_count(); ++t) {
      const PlaneWeights plane = plane_weights(coarse_collapsed.mesh, t);
      CHECK(std::isfinite(norm(plane.first) + norm(plane.second)));
    }
  }
  PreparedMesh tiny = prepare_mesh(icosphere(4));
  for (std::size_t i = 0; i < tiny.x.size(); ++i) {
    tiny.x[i] *= 1e-120;
    tiny.y[i] *= 1e-120;
    tiny.z[i] *= 1e-120;
  }
  for (double& a : tiny.area) a *= 1e-240;
  tiny.total_area *= 1e-240;
  for (Component& c : tiny.components) c.area *= 1e-240;
  const CoarseMesh coarse_tiny = coarsened(tiny);
  if (!coarse_tiny.empty()) check_coarse(tiny, coarse_tiny);
}

TEST_CASE("coarsen_mesh: a surface without mass, triangles without area") {
  const PreparedMesh fine = prepare_mesh(icosphere(4));
  CHECK(coarsen_mesh(fine, std::vector<double>(fine.triangle_count(), 0.0), 10, few).empty());
  std::vector<double> half = fine.area;
  std::fill(half.begin(), half.begin() + static_cast<std::ptrdiff_t>(half.size() / 2), 0.0);
  const CoarseMesh coarse = coarsen_mesh(fine, half, 10, few);
  REQUIRE(!coarse.empty());
  CHECK(coarse.mesh.triangle_count() < 400);
  CHECK(sum_of(coarse.masses) == Approx(sum_of(half)).epsilon(1e-12));
}

TEST_CASE("coarsen_mesh: the same bits with 1, 2 and 8 threads, and at any power-of-two scale") {
  PolygonMesh many;
  for (int i = 0; i < 4; ++i) {
    const PolygonMesh next = moved(i % 2 == 0 ? icosphere(4) : torus(50, 30), 0.3, i, 0, 0);
    many = i == 0 ? next : merged(many, next);
  }
  const PreparedMesh fine = prepare_mesh(many);
  std::vector<CoarseMesh> found;
  for (const std::size_t threads : {1u, 2u, 8u})
    found.push_back(on_threads(threads, [&] { return coarsened(fine); }));
  PolygonMesh larger = many;
  for (std::vector<double>* axis : {&larger.x, &larger.y, &larger.z})
    for (double& value : *axis) value *= 1024;
  found.push_back(coarsened(prepare_mesh(larger)));
  for (const CoarseMesh& coarse : found) {
    CHECK(coarse.triangle == found[0].triangle);
    CHECK(coarse.masses == found[0].masses);
    CHECK(coarse.mesh.x == found[0].mesh.x);
    CHECK(coarse.mesh.triangles == found[0].mesh.triangles);
    CHECK(coarse.mesh.opposite == found[0].mesh.opposite);
  }
}

TEST_CASE("coarsen_mesh: an expired deadline ends the item") {
  const PreparedMesh mesh = prepare_mesh(icosphere(4));
  CancelToken token;
  token.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK_THROWS_AS(coarsen_mesh(mesh, mesh.area, 1, few, token), ItemError);
}
