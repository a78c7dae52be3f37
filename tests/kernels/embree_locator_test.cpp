#include "kernels/rays/embree_locator.h"

#include <oneapi/tbb/flow_graph.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <set>

#include "kernels/core/parallel.h"
#include "kernels/curve/curve_frames.h"
#include "kernels/density/density.h"
#include "kernels/flatten/chart_geometry.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/rays/chart_scene.h"
#include "kernels/wavy_square.h"
#include "support/catch.h"
#include "support/clip_tree.h"
#include "support/hand_charts.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr RandomKey key = {{12, 34}};

const EmbreeDevice& device() {
  static const EmbreeDevice one;
  return one;
}

// A prepared mesh, its charts and everything the locator made of them.
struct Model {
  PreparedMesh mesh;
  std::vector<FlatChart> charts;
  std::vector<double> masses;
  LocateParameters parameters;
  std::vector<CurveTree> trees;
  Located located;

  void locate() {
    trees = build_curves(mesh, charts, masses, parameters);
    located = locate_with_embree(device(), mesh, charts, masses, trees, key, parameters);
  }
  double total() const { return blocked_sum(masses); }
  double leaf_mass() const {
    return total() / (parameters.curve.leaves_per_sample * static_cast<double>(parameters.samples));
  }
};

Model model_of(const PolygonMesh& file, const ChartMap& map, std::uint64_t samples = 2048) {
  Model model;
  model.mesh = prepare_mesh(file);
  for (const Component& c : model.mesh.components) model.charts.push_back(hand_chart(model.mesh, c, map));
  model.masses = triangle_masses(model.mesh, {});
  model.parameters.samples = samples;
  return model;
}

// A place in [0, 1]^2 that is not dyadic, so that leaf borders and mesh edges do not coincide.
std::pair<double, double> folded_once(Vector3 p) { return flat({std::min(p.x, 1 - p.x) * 1.9, p.y, 0}); }

PolygonMesh jittered_grid(std::uint32_t n) { return wavy_grid(n, n, 0.3, bumps); }

// The ray that the locator casts through a final leaf.
std::pair<float, float> leaf_ray(const CurveTree& tree, std::size_t i, std::uint32_t chart = 0) {
  const UnitPair jitter = random_pair(key, Stream::leaf_ray, tree.key[i], chart * 64 + tree.depth[i]);
  return {static_cast<float>(tree.u[i] + jitter.first * tree.side[i]),
          static_cast<float>(tree.v[i] + jitter.second * tree.side[i])};
}

RayHits hits_of_leaves(const FlatChart& chart, const CurveTree& tree) {
  std::vector<float> u, v;
  for (std::size_t i = 0; i < tree.leaf_count(); ++i) {
    const auto [x, y] = leaf_ray(tree, i);
    u.push_back(x);
    v.push_back(y);
  }
  const ChartScene scene(device(), chart.u, chart.v, chart.cut.triangles);
  RayHits hits;
  scene.cast(u, v, hits);
  return hits;
}

// Distance in the plane from a point to a triangle's border lines, negative outside.
double depth_inside(const UvTriangle& t, double u, double v) {
  const double orientation = orient2d(t.u[0], t.v[0], t.u[1], t.v[1], t.u[2], t.v[2]) > 0 ? 1 : -1;
  double depth = 1e9;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const double length = std::hypot(t.u[next] - t.u[k], t.v[next] - t.v[k]);
    depth = std::min(depth, orientation * orient2d(t.u[k], t.v[k], t.u[next], t.v[next], u, v) / length);
  }
  return depth;
}

}  // namespace

TEST_CASE("ChartScene: finds every triangle over the point, as a full search does") {
  for (const ChartMap& map : {ChartMap(flat), ChartMap(folded_once)}) {
    const Model model = model_of(jittered_grid(12), map);
    const FlatChart& chart = model.charts[0];
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<float> u(3001), v(u.size());
    for (std::size_t i = 0; i < u.size(); ++i) {
      u[i] = unit(random);
      v[i] = unit(random);
    }
    RayHits hits;
    ChartScene(device(), chart.u, chart.v, chart.cut.triangles).cast(u, v, hits);
    REQUIRE(hits.begin.size() == u.size() + 1);
    std::size_t missed = 0, invented = 0, unsorted = 0, found = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      const auto own = hits.of(i);
      unsorted +=
          !std::is_sorted(own.begin(), own.end()) || std::adjacent_find(own.begin(), own.end()) != own.end();
      for (std::uint32_t t = 0; t < chart.cut.triangle_count(); ++t) {
        const bool hit = std::binary_search(own.begin(), own.end(), t);
        const double depth = depth_inside(uv_triangle(chart, t), u[i], v[i]);
        missed += depth > 1e-6 && !hit;
        invented += depth < -1e-6 && hit;
        found += hit;
      }
    }
    CHECK(missed == 0);
    CHECK(invented == 0);
    CHECK(unsorted == 0);
    CHECK(found > 2000);
  }
}

TEST_CASE("ChartScene: no ray passes between two triangles") {
  const Model model = model_of(grid_plane(32, 32), [](Vector3 p) { return std::pair(p.x, p.y); });
  const FlatChart& chart = model.charts[0];
  std::vector<float> u, v;  // through vertices, along edges and diagonals
  for (int i = 1; i < 128; ++i)
    for (int j = 1; j < 128; ++j) {
      u.push_back(static_cast<float>(i) / 128);
      v.push_back(static_cast<float>(j) / 128);
    }
  RayHits hits;
  ChartScene(device(), chart.u, chart.v, chart.cut.triangles).cast(u, v, hits);
  std::size_t nothing = 0;
  for (std::size_t i = 0; i < u.size(); ++i) nothing += hits.of(i).empty();
  CHECK(nothing == 0);
}

TEST_CASE("ChartScene: a ray over too many triangles is given up, one below the limit is not") {
  for (const std::uint32_t layers : {most_hits_per_ray, most_hits_per_ray + 1, 700u}) {
    std::vector<double> u, v;
    std::vector<std::uint32_t> triangles;
    for (std::uint32_t t = 0; t < layers; ++t) {
      const double shift = 1e-4 * t;
      u.insert(u.end(), {0.1 + shift, 0.8, 0.3});
      v.insert(v.end(), {0.1, 0.2 + shift, 0.9});
      triangles.insert(triangles.end(), {3 * t, 3 * t + 1, 3 * t + 2});
    }
    const ChartScene scene(device(), u, v, triangles);
    RayHits hits;
    scene.cast(std::vector<float>(37, 0.4f), std::vector<float>(37, 0.4f), hits);
    for (std::size_t i = 0; i < 37; ++i) {
      CHECK(hits.crowded[i] == (layers > most_hits_per_ray));
      REQUIRE(hits.of(i).size() == (layers > most_hits_per_ray ? 0 : layers));
      for (std::uint32_t k = 0; k < hits.of(i).size(); ++k) CHECK(hits.of(i)[k] == k);
    }
  }
}

TEST_CASE("ChartScene: degenerate charts and no rays at all") {
  const std::vector<double> same(3, 0.5);
  const std::vector<std::uint32_t> one = {0, 1, 2};
  RayHits hits;
  ChartScene(device(), same, same, one)
      .cast(std::vector<float>{0.5f, 0.1f}, std::vector<float>{0.5f, 0.5f}, hits);
  CHECK(hits.begin == std::vector<std::uint32_t>{0, 0, 0});
  ChartScene(device(), same, same, one).cast({}, {}, hits);
  CHECK(hits.begin == std::vector<std::uint32_t>{0});
  ChartScene(device(), {}, {}, {}).cast(std::vector<float>{0.5f}, std::vector<float>{0.5f}, hits);
  CHECK(hits.begin == std::vector<std::uint32_t>{0, 0});
}

TEST_CASE("clip_tree: leaf masses sum to the mass of every triangle") {
  const Model model = model_of(jittered_grid(9), folded_once);
  CurveTree tree = curve_root(CurveKind::hilbert);
  for (int depth = 0; depth < 5; ++depth) {
    const std::vector<std::uint8_t> all(tree.leaf_count(), 1);
    tree = refine(tree, all);
    const ClipTree clipped = clip_tree(tree, model.charts[0], model.masses);
    const double sum = std::accumulate(clipped.leaf_mass.begin(), clipped.leaf_mass.end(), 0.0);
    CHECK(sum == Approx(model.total()).epsilon(1e-12));
    std::vector<double> of_triangle(model.masses.size(), 0.0);
    for (std::size_t f = 0; f < clipped.triangle.size(); ++f)
      of_triangle[clipped.triangle[f]] += clipped.mass[f];
    for (std::size_t t = 0; t < of_triangle.size(); ++t)
      CHECK(of_triangle[t] == Approx(model.masses[t]).epsilon(1e-11));
  }
}

TEST_CASE("build_curves: charts that expect enough samples get a tree, the others an empty one") {
  PolygonMesh file = merged(jittered_grid(10), moved(jittered_grid(10), 1e-3, 5, 5, 5));
  file = merged(file, moved(jittered_grid(10), 0.5, -5, 5, 5));
  Model model = model_of(file, [](Vector3) { return std::pair(0.5, 0.5); });
  REQUIRE(model.mesh.components.size() == 3);
  std::size_t with_tree = 0, small = 3;
  for (std::size_t c = 0; c < 3; ++c)
    if (model.mesh.components[c].area < 1e-4 * model.mesh.total_area) small = c;
  const std::size_t refused = small == 0 ? 1 : 0;
  model.charts[refused].report.method = Method::none;
  model.locate();
  for (const CurveTree& tree : model.trees) with_tree += tree.leaf_count() > 0;
  CHECK(with_tree == 1);
  CHECK(model.trees[small].leaf_count() == 0);
  CHECK(model.trees[refused].leaf_count() == 0);
  const Component& component = model.mesh.components[small];
  for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t)
    CHECK(model.located.hits[t] == 0);
}

TEST_CASE("locate_with_embree: hits are exactly the triangles on the ray of the leaf") {
  for (const ChartMap& map : {ChartMap(flat), ChartMap(folded_once)}) {
    Model model = model_of(jittered_grid(14), map, 512);
    model.locate();
    const CurveTree& tree = model.trees[0];
    const RayHits hits = hits_of_leaves(model.charts[0], tree);
    const ClipTree clipped = clip_tree(tree, model.charts[0], model.masses);
    std::vector<std::uint32_t> counted(model.masses.size(), 0);
    std::size_t strangers = 0, several = 0;
    for (std::size_t i = 0; i < tree.leaf_count(); ++i) {
      const auto [u, v] = leaf_ray(tree, i);
      std::size_t sure = 0;
      for (const std::uint32_t t : hits.of(i)) {
        ++counted[t];
        const UvTriangle corners = uv_triangle(model.charts[0], t);
        sure += strictly_inside(corners, u, v);
        strangers += !(clipped.mass_in_leaf(i, t) > 0) && depth_inside(corners, u, v) < 1e-6 &&
                             depth_inside(corners, u, v) > -1e-6
                         ? 0
                         : !(clipped.mass_in_leaf(i, t) > 0);
      }
      several += sure > 1;
    }
    CHECK(strangers == 0);
    CHECK(counted == model.located.hits);
    CHECK(model.located.leaves == tree.leaf_count());
    CHECK(model.located.multiple_hits == several);
    if (map.target<std::pair<double, double> (*)(Vector3)>() != nullptr &&
        *map.target<std::pair<double, double> (*)(Vector3)>() == flat)
      CHECK(several == 0);
    else
      CHECK(several > 200);
  }
}

TEST_CASE("locate_with_embree: the tree is as fine as the mass requires, for every curve") {
  for (const CurveKind kind : {CurveKind::hilbert, CurveKind::peano, CurveKind::peano_meander})
    for (const std::uint32_t n : {2u, 20u, 90u}) {
      Model model = model_of(jittered_grid(n), flat, 1024);
      model.parameters.curve.kind = kind;
      model.locate();
      const CurveTree& tree = model.trees[0];
      const double area = std::inner_product(tree.side.begin(), tree.side.end(), tree.side.begin(), 0.0);
      CHECK(area == Approx(1.0));
      CHECK(std::is_sorted(tree.key.begin(), tree.key.end()));
      CHECK(tree.leaf_count() > 2048);
      CHECK(tree.leaf_count() < 10 * 2048);
      CAPTURE(static_cast<int>(kind), n, tree.leaf_count());
      CHECK(*std::max_element(tree.depth.begin(), tree.depth.end()) <= curve_depth(kind, 11));
      CHECK(*std::min_element(tree.depth.begin(), tree.depth.end()) >= curve_depth(kind, 4));
      if (kind != CurveKind::hilbert) continue;
      // Each leaf was judged by one ray only, which may miss the part of the chart that the leaf holds: few
      // are heavier than asked, none heavier than a whole leaf of the least depth (of 256, 2048 asked for).
      const ClipTree clipped = clip_tree(tree, model.charts[0], model.masses);
      std::size_t heavy = 0;
      for (const double mass : clipped.leaf_mass) heavy += mass > model.leaf_mass();
      CHECK(static_cast<double>(heavy) < 0.05 * static_cast<double>(tree.leaf_count()));
      CHECK(*std::max_element(clipped.leaf_mass.begin(), clipped.leaf_mass.end()) < 12 * model.leaf_mass());
    }
}

TEST_CASE("locate_with_embree: every triangle larger than a few leaves is hit") {
  Model model = model_of(jittered_grid(16), flat, 4096);
  model.locate();
  const std::uint32_t least = *std::min_element(model.located.hits.begin(), model.located.hits.end());
  CHECK(least >= 3);  // about 16 leaves a triangle
  const double sum = std::accumulate(model.located.hits.begin(), model.located.hits.end(), 0.0);
  double leaves_of_chart = 0;
  for (std::size_t i = 0; i < model.trees[0].leaf_count(); ++i) {
    const auto [u, v] = leaf_ray(model.trees[0], i);
    leaves_of_chart += u > 0.013f && u < 0.983f && v > 0.007f && v < 0.977f;
  }
  CHECK(sum == leaves_of_chart);  // each ray over the chart met one triangle (none lies on an edge)
}

TEST_CASE("locate_with_embree: without mass no leaf is finer than the min depth") {
  Model model = model_of(jittered_grid(20), flat, 1024);
  for (std::uint32_t t = 0; t < model.masses.size(); ++t) {
    const UvTriangle corners = uv_triangle(model.charts[0], t);
    if (std::max({corners.u[0], corners.u[1], corners.u[2]}) > 0.5) model.masses[t] = 0;
  }
  model.locate();
  const CurveTree& tree = model.trees[0];
  int deepest = 0;
  for (std::size_t i = 0; i < tree.leaf_count(); ++i)
    if (tree.u[i] > 0.5) deepest = std::max<int>(deepest, tree.depth[i]);
  CHECK(deepest == 4);  // floor(log2(2 * 1024) / 2) - 1
}

TEST_CASE("locate_with_embree: a chart folded in two is separated along the fold") {
  Model model = model_of(jittered_grid(24), folded_once);
  model.locate();
  CHECK(model.located.multiple_hits > 1000);
  CHECK(model.located.rays > model.located.leaves + model.masses.size());
  std::array<std::size_t, 2> sheet_of_left = {0, 0}, sheet_of_right = {0, 0};
  for (std::uint32_t t = 0; t < model.masses.size(); ++t) {
    double x = 0;
    for (std::size_t k = 0; k < 3; ++k)
      x += (model.mesh.center + model.mesh.unit * model.mesh.position(model.mesh.triangles[3 * t + k])).x / 3;
    REQUIRE(model.located.sheet[t] < 2);
    if (x < 0.45) ++sheet_of_left[model.located.sheet[t]];
    if (x > 0.55) ++sheet_of_right[model.located.sheet[t]];
  }
  CHECK(sheet_of_left[0] * sheet_of_left[1] == 0);
  CHECK(sheet_of_right[0] * sheet_of_right[1] == 0);
  CHECK((sheet_of_left[0] > 0) != (sheet_of_right[0] > 0));
}

TEST_CASE("locate_with_embree: the turns of a spiral lie in separate sheets") {
  constexpr int turns = 3;
  const auto spiral = [](Vector3 p) {
    const double angle = 2 * std::numbers::pi * turns * p.x, r = 0.2 + 0.25 * p.y;
    return std::pair(0.5 + r * std::cos(angle), 0.5 + r * std::sin(angle));
  };
  Model model = model_of(wavy_grid(180, 8, 0.3, bumps), spiral);
  model.parameters.min_sheet_samples = 0;  // scraps left over between two regions get sheets too
  model.locate();
  // Where two triangles overlap by more than a touch they are in different sheets.
  const FlatChart& chart = model.charts[0];
  std::size_t together = 0, apart = 0;
  for (std::uint32_t a = 0; a < model.masses.size(); ++a) {
    const UvTriangle ta = uv_triangle(chart, a);
    const double u = (ta.u[0] + ta.u[1] + ta.u[2]) / 3, v = (ta.v[0] + ta.v[1] + ta.v[2]) / 3;
    for (std::uint32_t b = 0; b < model.masses.size(); ++b)
      if (a != b && strictly_inside(uv_triangle(chart, b), u, v))
        ++(model.located.sheet[a] == model.located.sheet[b] ? together : apart);
  }
  CHECK(apart > 2 * model.masses.size() - 200);
  CHECK(together == 0);
  CHECK(std::set<std::uint8_t>(model.located.sheet.begin(), model.located.sheet.end()).size() <= turns + 2);

  model.parameters.max_sheets = 1;
  model.locate();
  CHECK(*std::max_element(model.located.sheet.begin(), model.located.sheet.end()) == 0);
}

TEST_CASE("locate_with_embree: a small overlap gets no sheet of its own") {
  // The last hundredth of the strip lies over its beginning.
  const auto overlapping = [](Vector3 p) { return flat({p.x < 0.99 ? p.x : 1.98 - p.x, p.y, 0}); };
  Model model = model_of(wavy_grid(200, 20, 0, bumps), overlapping, 512);
  model.locate();
  CHECK(model.located.multiple_hits > 0);
  CHECK(*std::max_element(model.located.sheet.begin(), model.located.sheet.end()) == 0);
  model.parameters.min_sheet_samples = 0;
  model.locate();
  CHECK(*std::max_element(model.located.sheet.begin(), model.located.sheet.end()) == 1);
}

TEST_CASE("locate_with_embree: a chart that collapses to a point costs bounded time and memory") {
  const auto collapsed = [](Vector3 p) {
    return p.x < 0.5 ? flat(p) : std::pair(0.7 + 1e-9 * p.x, 0.4 + 1e-9 * p.y);
  };
  Model model = model_of(jittered_grid(100), collapsed);
  model.locate();
  CHECK(model.located.leaves < 60 * 2048);
  CHECK(*std::max_element(model.trees[0].depth.begin(), model.trees[0].depth.end()) == 24);
  for (std::uint32_t t = 0; t < model.masses.size(); ++t) {  // the valid half is located as before
    const UvTriangle corners = uv_triangle(model.charts[0], t);
    if (std::max({corners.u[0], corners.u[1], corners.u[2]}) < 0.4) REQUIRE(model.located.sheet[t] == 0);
  }
}

TEST_CASE("locate_with_embree: triangles without UV area are harmless") {
  const auto line = [](Vector3 p) { return flat({p.x, 0.3, 0}); };
  Model model = model_of(jittered_grid(10), line);
  model.locate();
  CHECK(model.located.multiple_hits == 0);
  CHECK(*std::max_element(model.located.sheet.begin(), model.located.sheet.end()) == 0);
}

TEST_CASE("locate_with_embree: the same on one thread and on two") {
  PolygonMesh file = merged(jittered_grid(60), moved(jittered_grid(40), 0.7, 5, 5, 5));
  const Model whole = model_of(file, folded_once, 20000);
  const auto run = [&](std::size_t threads) {
    Model model = whole;
    for (std::size_t c = 0; c < model.charts.size(); ++c)  // the map of the second component is arbitrary
      for (std::size_t i = 0; c == 1 && i < model.charts[c].u.size(); ++i) {
        model.charts[c].u[i] = std::fmod(std::abs(model.charts[c].u[i]), 1.0);
        model.charts[c].v[i] = std::fmod(std::abs(model.charts[c].v[i]), 1.0);
      }
    on_threads(threads, [&] { model.locate(); });
    return model;
  };
  const Model one = run(1), two = run(2), again = run(2);
  CHECK(one.located.leaves > 40000);
  for (const Model* other : {&two, &again}) {
    CHECK(one.located.hits == other->located.hits);
    CHECK(one.located.sheet == other->located.sheet);
    CHECK(one.located.rays == other->located.rays);
    CHECK(one.located.multiple_hits == other->located.multiple_hits);
    for (std::size_t c = 0; c < one.trees.size(); ++c) CHECK(one.trees[c].key == other->trees[c].key);
  }
}

TEST_CASE("locate_with_embree: many calls inside a flow graph share one device without deadlock") {
  const Model whole = model_of(jittered_grid(70), folded_once, 12000);
  Model reference = whole;
  reference.locate();
  std::atomic<int> equal = 0;
  namespace flow = oneapi::tbb::flow;
  flow::graph graph;
  flow::function_node<int, int> node(graph, flow::unlimited, [&](int i) {
    Model model = whole;
    model.locate();
    equal += model.located.hits == reference.located.hits && model.trees[0].key == reference.trees[0].key;
    return i;
  });
  for (int i = 0; i < 24; ++i) node.try_put(i);
  graph.wait_for_all();
  CHECK(equal == 24);
}

TEST_CASE("locate_with_embree: an expired deadline, and charts of another mesh, are errors") {
  Model model = model_of(jittered_grid(10), flat);
  model.trees = build_curves(model.mesh, model.charts, model.masses, model.parameters);
  CancelToken late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK_THROWS_AS(locate_with_embree(device(), model.mesh, model.charts, model.masses, model.trees, key,
                                     model.parameters, late),
                  ItemError);
  model.charts.push_back(model.charts[0]);
  CHECK_THROWS_WITH(build_curves(model.mesh, model.charts, model.masses, model.parameters),
                    Catch::Matchers::ContainsSubstring("2 charts"));
}
