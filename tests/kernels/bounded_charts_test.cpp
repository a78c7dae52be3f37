// Charts that nothing can make good: their work is bounded, the model is sampled all the same.
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string_view>
#include <vector>

#include "io/file/file_bytes.h"
#include "io/mesh/mesh_reader.h"
#include "kernels/core/work_budget.h"
#include "kernels/cut/cut_to_disk.h"
#include "kernels/flatten/flatten_chart.h"
#include "kernels/flatten/mean_value.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/model/model_sampler.h"
#include "kernels/solve/sparse_cholesky.h"
#include "support/catch.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;

namespace {

// A ball of which some vertices, all over it, stand out up to `height` radii: needles on every side, which a
// conformal map folds by the hundred.
PolygonMesh spiked_ball(std::uint32_t n, double height) {
  std::vector<double> xyz = {0, 0, 1};
  for (std::uint32_t j = 1; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const double t = std::numbers::pi * j / n, s = 2 * std::numbers::pi * i / n;
      const double share = 0x1p-32 * ((i * 7919u + j * 104729u) * 2654435761u);
      const double r = 1 + height * std::pow(share, 8);
      xyz.insert(xyz.end(), {r * std::sin(t) * std::cos(s), r * std::sin(t) * std::sin(s), r * std::cos(t)});
    }
  xyz.insert(xyz.end(), {0, 0, -1});
  const auto at = [n](std::uint32_t j, std::uint32_t i) { return 1 + (j - 1) * n + i % n; };
  const std::uint32_t last = 1 + (n - 1) * n;
  std::vector<std::vector<std::uint32_t>> faces;
  for (std::uint32_t i = 0; i < n; ++i) {
    faces.push_back({0, at(1, i), at(1, i + 1)});
    for (std::uint32_t j = 1; j + 1 < n; ++j) {
      faces.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
      faces.push_back({at(j, i), at(j + 1, i + 1), at(j, i + 1)});
    }
    faces.push_back({at(n - 1, i), last, at(n - 1, i + 1)});
  }
  return polygon_mesh(std::move(xyz), std::move(faces));
}

FlatChart flatten_within(const PreparedMesh& mesh, double effort) {
  FlattenParameters parameters;
  parameters.effort = effort;
  return flatten_chart(mesh, cut_to_disk(mesh, mesh.components.at(0), {}), parameters);
}

Row sample(const PolygonMesh& mesh, std::string_view method, std::uint32_t samples) {
  SampleParameters parameters = parameters_for(method);
  parameters.samples = samples;
  const EmbreeDevice device;
  Model model;
  model.file = mesh;
  model.key = make_random_key(1, {});
  run_stages(stages_of(parameters, &device), model);
  return std::move(model.row);
}

}  // namespace

TEST_CASE("work budget: once refused is refused for good") {
  WorkBudget budget(10);
  CHECK(budget.spend(4));
  CHECK(budget.spend(6));
  CHECK(budget.left() == 0);
  CHECK(budget.spend(0));
  CHECK(!budget.exhausted());
  CHECK(!budget.spend(1));
  CHECK(budget.exhausted());
  CHECK(!budget.spend(0));
  WorkBudget small(10);
  CHECK(!small.spend(11));
  CHECK(!small.spend(1));
  CHECK(small.left() == 0);
  CHECK(spend(nullptr, ~std::uint64_t{0}));
  CHECK(!spend(&small, 1));
}

TEST_CASE("work budget: a factorization is refused before it is computed") {
  // A path of four unknowns.
  const auto matrix = [] {
    return GraphMatrix{{{0, 1, 3, 5, 6}, {1, 0, 2, 1, 3, 2}}, {-1, -1, -1, -1, -1, -1}, {3, 3, 3, 3}};
  };
  const std::vector<std::uint32_t> order = {0, 1, 2, 3};
  WorkBudget one(1), enough(1000);
  SparseCholesky cholesky;
  cholesky.factorize(matrix(), order, {}, &one);
  CHECK(!cholesky.succeeded());
  CHECK(one.exhausted());
  cholesky.factorize(matrix(), order, {}, &enough);
  CHECK(cholesky.succeeded());
  CHECK(enough.left() < 1000);
  cholesky.factorize(matrix(), order, {}, &one);  // nothing of the factor before is left
  CHECK(!cholesky.succeeded());
}

TEST_CASE("bounded charts: a folded chart of needles ends without a map, a good one is kept") {
  const PreparedMesh ball = prepare_mesh(spiked_ball(24, 30));
  const FlatChart bounded = flatten_within(ball, 1);
  CHECK(bounded.report.method == Method::none);
  CHECK(bounded.report.reason == OrderReason::work_limit);
  CHECK(bounded.cut.triangle_count() == ball.triangle_count());
  // With far more work there is a map, if a bad one.
  const FlatChart unbounded = flatten_within(ball, 1000);
  CHECK(unbounded.report.method == Method::mean_value);
  CHECK(unbounded.report.reason == OrderReason::flipped);
  // No work at all: not even a first map.
  const PreparedMesh sphere = prepare_mesh(icosphere(3));
  const FlatChart none = flatten_within(sphere, 1e-6);
  CHECK(none.report.method == Method::none);
  CHECK(none.report.reason == OrderReason::work_limit);
  CHECK(none.u.empty());
  // A bound that is met while seams are tried: the maps before it stand.
  const FlatChart few = flatten_within(sphere, 2.5 / 64), all = flatten_within(sphere, 1);
  CHECK(few.report.method == Method::conformal);
  CHECK(few.report.reason == OrderReason::as_asked);
  CHECK(few.report.extra_seams <= all.report.extra_seams);
  const FlatChart ten_times = flatten_within(sphere, 10);
  CHECK(all.u == ten_times.u);
  CHECK(all.v == ten_times.v);
}

TEST_CASE("bounded charts: the budget never decreases with the size of the chart") {
  std::uint64_t before = 0;
  for (const std::size_t triangles : {1u, 10u, 1000u, 1000000u, 2000000000u}) {
    const std::uint64_t units = flatten_budget(triangles, 1).left();
    CHECK(units > 10 * before);
    before = units;
  }
  CHECK(flatten_budget(1000, 0.25).left() == flatten_budget(1000, 1).left() / 4);
  CHECK(flatten_budget(2000000000, 1e30).left() > before);
}

TEST_CASE("bounded charts: their component is sampled in spatial order, others keep their charts") {
  const PolygonMesh mesh = merged(moved(spiked_ball(24, 30), 0.1, 9, 0, 0), icosphere(3));
  const Row row = sample(mesh, "conformal", 1000);
  CHECK(row.report.status == Status::ok);
  CHECK(row.report.method == Method::direct);
  CHECK(row.report.order_reason == OrderReason::work_limit);
  CHECK(row.samples.count() == 1000);
  CHECK(row.samples.points.size() == 3000);
  CHECK(row.report.distortion > 1);  // that of the sphere's chart alone
  CHECK(row.report.distortion < 2);
  std::size_t on_ball = 0;
  const auto faces = static_cast<std::uint32_t>(spiked_ball(24, 30).polygon_count());
  for (const std::uint32_t face : row.samples.face) on_ball += face < faces ? 1 : 0;
  const PreparedMesh surface = prepare_mesh(mesh);
  double ball_area = 0;
  for (const Component& c : surface.components)
    if (c.triangle_end - c.triangle_begin == faces) ball_area = c.area;
  CHECK(static_cast<double>(on_ball) ==
        Approx(1000 * ball_area / (surface.components[0].area + surface.components[1].area)).margin(1));
}

TEST_CASE("bounded charts: under a tensor nothing is lost, and halves get charts") {
  const Row row = sample(spiked_ball(16, 3), "anisotropic", 500);
  CHECK(row.report.status == Status::ok);
  CHECK(row.samples.count() == 500);
  CHECK(row.report.method == Method::anisotropic);
  CHECK(row.report.order_reason == OrderReason::as_asked);
}

TEST_CASE("bounded charts: the same samples with 1, 2 and 8 threads") {
  const PolygonMesh mesh = merged(moved(spiked_ball(16, 30), 0.1, 9, 0, 0), spiked_ball(16, 300));
  for (const std::string_view method : {"conformal", "anisotropic"}) {
    INFO(method);
    std::vector<Row> rows;
    for (const std::size_t threads : {1u, 2u, 8u})
      rows.push_back(on_threads(threads, [&] { return sample(mesh, method, 512); }));
    for (const Row& row : rows) {
      CHECK(row.samples.points == rows[0].samples.points);
      CHECK(row.samples.triangle == rows[0].samples.triangle);
      CHECK(row.report.method == rows[0].report.method);
    }
  }
}

TEST_CASE("bounded charts: the shared needles are sampled") {
  MEANDER_NEEDS_SHARED_DATA();
  const std::filesystem::path path = shared_data("../repro/slow_flatten.ply");
  if (!std::filesystem::exists(path)) {
    WARN("skipped: " << path.filename() << " is not beside this clone");
    return;
  }
  const PolygonMesh mesh = read_mesh(FileBytes(path).bytes(), MeshFormat::ply);
  for (const std::string_view method : {"conformal", "anisotropic"}) {
    INFO(method);
    const Row row = sample(mesh, method, 2048);
    CHECK(row.report.status == Status::ok);
    CHECK(row.samples.count() == 2048);
    if (method == "conformal") CHECK(row.report.method == Method::direct);
  }
}
