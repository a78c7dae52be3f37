// Anisotropic sampling from a mesh to its samples: what holds for every field, exactly or nearly.
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include "kernels/analyse/box_discrepancy.h"
#include "kernels/analyse/certify_samples.h"
#include "kernels/analyse/region_counts.h"
#include "kernels/analyse/spacing.h"
#include "kernels/model/model_sampler.h"
#include "kernels/sample/point_frames.h"
#include "kernels/unit_vector.h"
#include "support/anisotropic_models.h"
#include "support/catch.h"
#include "support/hand_charts.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

constexpr std::array<AlignmentForm, 2> forms = {AlignmentForm::metric, AlignmentForm::gradient};
std::string form_name(AlignmentForm form) { return form == AlignmentForm::metric ? "metric" : "gradient"; }

std::size_t distinct_points(const Samples& samples) {
  std::set<std::array<float, 3>> distinct;
  for (std::size_t i = 0; i < samples.count(); ++i)
    distinct.insert({samples.points[3 * i], samples.points[3 * i + 1], samples.points[3 * i + 2]});
  return distinct.size();
}

// No two edges alike, one component, no symmetry.
PolygonMesh bumpy_ball() {
  PolygonMesh mesh = icosphere(3);
  for (std::size_t v = 0; v < mesh.x.size(); ++v) {
    const double x = mesh.x[v], y = mesh.y[v], z = mesh.z[v];
    const double r = 1 + 0.15 * std::sin(3 * x + 1) + 0.1 * std::cos(2.5 * y - z) + 0.2 * z;
    mesh.x[v] = 1.5 * r * x;
    mesh.y[v] = r * y;
    mesh.z[v] = 0.8 * r * z;
  }
  return mesh;
}

// Spacings 3 : 1 around the axis of a torus, more samples on the left.
double torus_size(double x) { return std::exp(0.3 * x); }
std::shared_ptr<const TensorTable> around_torus(const PolygonMesh& mesh) {
  return std::make_shared<TensorTable>(table_of(mesh, [](Vector3 p) {
    const double size = torus_size(p.x);
    return std::pair{Vector3{-p.y, p.x, 0}, std::array<double, 2>{3 * size, size}};
  }));
}

// A part of the file's triangles that is not sampled has no area, a pinched vertex, or a boundary.
PolygonMesh untidy() {
  PolygonMesh mesh =
      merged(merged(bumpy_ball(), moved(grid_plane(9, 7), 1.3, 4, 0, 0)), moved(torus(18, 9), 0.7, 0, 5, 0));
  // Triangles without area: two corners alike, and three in a line.
  mesh.corners.insert(mesh.corners.end(), {0, 0, 1});
  mesh.polygon_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
  const auto first = static_cast<std::uint32_t>(mesh.x.size());
  for (const double t : {0.0, 0.4, 1.0}) {
    mesh.x.push_back(9 + t);
    mesh.y.push_back(2 * t);
    mesh.z.push_back(-t);
  }
  mesh.corners.insert(mesh.corners.end(), {first, first + 1, first + 2});
  mesh.polygon_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
  return mesh;
}

Row sampled(const PolygonMesh& mesh, const SampleParameters& parameters) {
  std::vector<double> positions;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    positions.insert(positions.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  return ModelSampler(parameters).sample(polygon_mesh_of({positions, mesh.corners}));
}

// Root mean square of the error over boxes relative to random points.
double box_error(ChartedModel& model, std::uint32_t n, std::uint64_t seeds) {
  const PreparedMesh& mesh = model.state.surface;
  const std::vector<RotatedBox> boxes = random_boxes(mesh.x, mesh.y, mesh.z, mesh.triangles, BoxParameters{});
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Samples& samples = draw(model, n, seed);
    const std::array<double, 3> center = {mesh.center.x, mesh.center.y, mesh.center.z};
    std::vector<double> points(samples.points.begin(), samples.points.end());
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = (points[i] - center[i % 3]) / mesh.unit;
    sum += std::pow(box_error_ratio(boxes, points), 2);
  }
  return std::sqrt(sum / static_cast<double>(seeds));
}

double mean_rho(ChartedModel& model, std::uint32_t n, std::uint64_t seeds) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Samples& samples = draw(model, n, seed);
    const std::vector<double> points(samples.points.begin(), samples.points.end());
    const std::vector<double> nearest = nearest_distances(points);
    sum += std::accumulate(nearest.begin(), nearest.end(), 0.0) / static_cast<double>(nearest.size());
  }
  return sum / static_cast<double>(seeds) * std::sqrt(n / model.state.row.report.area);
}

}  // namespace

TEST_CASE("anisotropic sampling: exactly n distinct points, whatever the mesh, the field and the form") {
  const PolygonMesh meshes[] = {icosphere(2),      torus(20, 10), grid_plane(8, 8),
                                moebius_strip(12), untidy(),      tetrahedron()};
  for (const PolygonMesh& mesh : meshes)
    for (const AlignmentForm form : forms)
      for (const TensorKind kind : {TensorKind::curvature, TensorKind::constant, TensorKind::isotropic}) {
        INFO(mesh.polygon_count() << " faces, " << form_name(form) << ", kind " << static_cast<int>(kind));
        SampleParameters parameters = anisotropic(kind, form);
        if (kind == TensorKind::constant) parameters.tensor.constant = {1, 0.2, 0, 3, 0.1, 0.6};
        for (const std::uint32_t n : {1u, 257u}) {
          parameters.samples = n;
          const Row row = sampled(mesh, parameters);
          INFO(row.report.reason);
          REQUIRE(row.report.status == Status::ok);
          CHECK(distinct_points(row.samples) == n);
          REQUIRE(row.samples.tensor_direction.size() == 3 * n);
          REQUIRE(row.samples.tensor_spacing.size() == 2 * n);
          for (std::size_t i = 0; i < n; ++i) {
            CHECK(std::isfinite(row.samples.tensor_spacing[2 * i]));
            CHECK(row.samples.tensor_spacing[2 * i] >= row.samples.tensor_spacing[2 * i + 1]);
            CHECK(row.samples.tensor_spacing[2 * i + 1] > 0);
          }
          REQUIRE(row.descriptors.size() == anisotropy_names.size());
          for (std::size_t k = 0; k < anisotropy_names.size(); ++k)
            CHECK(row.descriptors[k].name == anisotropy_names[k]);
        }
      }
}

TEST_CASE("anisotropic sampling: the same samples for every number of threads") {
  for (const AlignmentForm form : forms) {
    SampleParameters parameters = anisotropic(TensorKind::curvature, form);
    parameters.samples = 1000;
    Row rows[2];
    for (const std::size_t threads : {1u, 4u})
      rows[threads > 1] = on_threads(threads, [&] {
        return sampled(merged(torus(90, 60), moved(bumpy_ball(), 1, 3, 0, 0)), parameters);
      });
    REQUIRE(rows[0].report.status == Status::ok);
    CHECK(rows[0].samples.points == rows[1].samples.points);
    CHECK(rows[0].samples.face == rows[1].samples.face);
    CHECK(rows[0].samples.tensor_direction == rows[1].samples.tensor_direction);
    CHECK(rows[0].samples.tensor_spacing == rows[1].samples.tensor_spacing);
    for (std::size_t k = 0; k < rows[0].descriptors.size(); ++k)
      CHECK(rows[0].descriptors[k].values == rows[1].descriptors[k].values);
  }
}

TEST_CASE("anisotropic sampling: invariant to moving, rotating and scaling the model") {
  const PolygonMesh ball = bumpy_ball();
  for (const AlignmentForm form : forms) {
    INFO(form_name(form));
    // A power of two and nothing else: bit by bit.
    PolygonMesh large = ball;
    for (std::vector<double>* axis : {&large.x, &large.y, &large.z})
      for (double& value : *axis) value *= 4;
    SampleParameters parameters = anisotropic(TensorKind::curvature, form);
    ChartedModel of_ball = charted(ball, parameters), of_large = charted(large, parameters);
    const Samples still = draw(of_ball, 1000, 1), scaled = draw(of_large, 1000, 1);
    CHECK(scaled.face == still.face);
    CHECK(scaled.barycentric == still.barycentric);
    CHECK(scaled.tensor_direction == still.tensor_direction);
  }
  // Turned: roundings differ, so that a sample now and then may lie beyond the border of an element. The
  // field turns with the model (curvatures are measured against the bounding box, which does not), and there
  // is one segment (several are visited in the order of a curve in space).
  std::vector<double> tips;
  for (std::size_t v = 0; v < ball.vertex_count(); ++v)
    tips.insert(tips.end(), {2, 0.5 * ball.z[v], 0.4 + 0.2 * ball.x[v]});
  const PolygonMesh turned_tips = moved(polygon_mesh(tips, {}), 1, 0, 0, 0);
  auto table = std::make_shared<TensorTable>(), turned_table = std::make_shared<TensorTable>();
  table->columns = turned_table->columns = 3;
  table->values = tips;
  for (std::size_t v = 0; v < ball.vertex_count(); ++v)
    turned_table->values.insert(turned_table->values.end(),
                                {turned_tips.x[v], turned_tips.y[v], turned_tips.z[v]});
  ChartedModel still_model = charted(ball, anisotropic(), table),
               turned_model = charted(moved(ball, 3.7, 1, -2, 5), anisotropic(), turned_table);
  REQUIRE(still_model.state.segments.report.segments == 1);
  const Samples still = draw(still_model, 1000, 1), turned = draw(turned_model, 1000, 1);
  std::size_t same = 0;
  for (std::size_t i = 0; i < 1000; ++i)
    same += turned.face[i] == still.face[i] &&
            std::abs(turned.barycentric[2 * i] - still.barycentric[2 * i]) < 1e-4F &&
            std::abs(turned.tensor_spacing[2 * i] / still.tensor_spacing[2 * i] / 3.7F - 1) < 1e-4F;
  CHECK(same >= 990);
}

TEST_CASE("anisotropic sampling: regions get their share of the integral of 1 / (s1 s2)") {
  const PolygonMesh mesh = merged(torus(48, 24), moved(torus(30, 16), 0.5, 4, 0, 0));
  for (const AlignmentForm form : forms) {
    INFO(form_name(form));
    ChartedModel model = charted(mesh, anisotropic(TensorKind::table, form), around_torus(mesh));
    constexpr std::uint32_t n = 1500;
    // By the stages' own masses: components (segments) are runs of the curve.
    std::vector<std::uint32_t> of_component(model.state.segments.mesh.triangle_count());
    std::uint32_t number = 0;
    for (const Component& component : model.state.segments.mesh.components) {
      for (std::uint32_t t = component.triangle_begin; t < component.triangle_end; ++t)
        of_component[t] = number;
      ++number;
    }
    const Samples& samples = draw(model, n, 5);
    const auto triangles = sample_triangles(model.state.file, model.state.segments.mesh, samples);
    const RegionCounts runs =
        region_counts(of_component, model.state.segments.measure.masses, triangles, number);
    for (std::uint32_t c = 0; c < number; ++c)
      CHECK(std::abs(static_cast<double>(runs.counts[c]) - runs.expected[c]) <= 2);
    // By the formula, on octants of both tori.
    const PreparedMesh& whole = model.state.surface;
    std::vector<std::uint32_t> octant(whole.triangle_count());
    std::vector<double> measure(whole.triangle_count());
    for (std::uint32_t t = 0; t < octant.size(); ++t) {
      Vector3 p;
      for (std::uint32_t k = 0; k < 3; ++k) p = p + whole.position(whole.triangles[3 * t + k]);
      p = whole.center + whole.unit / 3 * p;
      octant[t] = (p.x < 0 ? 1u : 0u) + (p.y < 0 ? 2u : 0u) + (p.z < 0 ? 4u : 0u) + (p.x > 2 ? 8u : 0u);
      measure[t] = whole.area[t] / std::pow(torus_size(p.x), 2);
    }
    const RegionCounts octants = region_counts(octant, measure, samples.triangle, 16);
    INFO("dispersion " << octants.dispersion << " worst " << octants.worst);
    CHECK(octants.dispersion < 0.6);
    CHECK(octants.worst < 2);
  }
}

TEST_CASE("anisotropic sampling: the isotropic tensor gives samples as good as conformal") {
  const SampleParameters conformal = parameters_for("conformal");
  ChartedModel plain = charted(torus(60, 36), conformal),
               equal = charted(torus(60, 36), anisotropic(TensorKind::isotropic));
  const double plain_error = box_error(plain, 1000, 8), equal_error = box_error(equal, 1000, 8);
  INFO(plain_error << " against " << equal_error);
  CHECK(equal_error == Approx(plain_error).epsilon(0.15));
  CHECK(mean_rho(equal, 1000, 4) == Approx(mean_rho(plain, 1000, 4)).epsilon(0.04));
  CHECK(equal.state.segments.report.mean_spacing_ratio == Approx(1));
  CHECK(equal.state.segments.report.accepted_share == 1);
}

TEST_CASE("anisotropic sampling: lifted samples define the pointnet frame, and spacings are in its units") {
  SampleParameters parameters = anisotropic();
  parameters.samples = 500;
  parameters.curved = true;
  const PolygonMesh mesh = moved(merged(torus(30, 16), moved(icosphere(1), 0.3, 3, 0, 0)), 5, 10, 20, 30);
  const Row plain = sampled(mesh, parameters);
  parameters.normalize = NormalizeKind::pointnet;
  const Row row = sampled(mesh, parameters);
  REQUIRE(row.report.status == Status::ok);
  CHECK(row.samples.barycentric == plain.samples.barycentric);
  CHECK(row.samples.tensor_direction == plain.samples.tensor_direction);
  Vector3 mean;
  double farthest = 0;
  for (std::size_t i = 0; i < 500; ++i) {
    const Vector3 point = file_point(ItemReport(), row.samples.points, i);
    mean = mean + 1.0 / 500 * point;
    farthest = std::max(farthest, norm(point));
    CHECK(distance(file_point(row.report, row.samples.points, i),
                   file_point(plain.report, plain.samples.points, i)) < 1e-5);
    for (const std::size_t k : {2 * i, 2 * i + 1})
      CHECK(row.report.scale * static_cast<double>(row.samples.tensor_spacing[k]) ==
            Approx(plain.samples.tensor_spacing[k]).epsilon(1e-6));
  }
  CHECK(norm(mean) < 1e-7);
  CHECK(std::abs(farthest - 1) <= 0x1p-24);
  // The same in the order of the curve.
  parameters.order = OrderKind::curve;
  const Row ordered = sampled(mesh, parameters);
  CHECK(ordered.report.loc == row.report.loc);
  CHECK(ordered.report.scale == row.report.scale);
}

TEST_CASE("anisotropic sampling: stored directions and spacings are those of the field") {
  const PolygonMesh mesh = torus(60, 30);
  for (const NormalizeKind normalize :
       {NormalizeKind::none, NormalizeKind::unit_sphere, NormalizeKind::pointnet}) {
    SampleParameters parameters = anisotropic();
    parameters.normalize = normalize;
    ChartedModel model = charted(mesh, parameters, around_torus(mesh));
    constexpr std::uint32_t n = 2000;
    const Samples& samples = draw(model, n, 3);
    const ItemReport& report = model.state.row.report;
    double area = 0, across = 0, off_plane = 0, length = 0, ratio = 0, worst_density = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Vector3 p, d;
      double* const out[] = {&p.x, &p.y, &p.z};
      double* const along[] = {&d.x, &d.y, &d.z};
      for (std::size_t k = 0; k < 3; ++k) {
        *out[k] = report.loc[k] + report.scale * static_cast<double>(samples.points[3 * i + k]);
        *along[k] = static_cast<double>(samples.tensor_direction[3 * i + k]);
      }
      Vector3 corner[3];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = samples.corners[3 * i + k];
        corner[k] = {mesh.x[v], mesh.y[v], mesh.z[v]};
      }
      const Vector3 normal = unit(cross(corner[1] - corner[0], corner[2] - corner[0]));
      off_plane = std::max(off_plane, std::abs(dot(normal, d)));
      length = std::max(length, std::abs(norm(d) - 1));
      across = std::max(across, norm(cross(d, unit({-p.y, p.x, 0}))));
      const double s1 = report.scale * static_cast<double>(samples.tensor_spacing[2 * i]);
      const double s2 = report.scale * static_cast<double>(samples.tensor_spacing[2 * i + 1]);
      area += s1 * s2;
      ratio = std::max(ratio, std::abs(s1 / s2 / 3 - 1));
      // One sample's cell: the measure of the whole over n, at this density.
      worst_density =
          std::max(worst_density,
                   std::abs(s1 * s2 * static_cast<double>(samples.density[i]) * n / report.measure - 1));
    }
    CHECK(off_plane < 1e-6);
    CHECK(length < 1e-6);
    CHECK(across < 0.12);  // the secant of a sixtieth of a turn: 0.05, and as much between the tangents
    CHECK(ratio < 0.05);   // vertex values of a turning direction, meaned within triangles
    CHECK(worst_density < 1e-4);
    CHECK(area == Approx(report.area).epsilon(0.01));
  }
}

TEST_CASE("anisotropic sampling: a user density multiplies that of the tensor") {
  PolygonMesh mesh = grid_plane(32, 32);
  ScalarAttribute weight{"weight", {}};
  for (const double x : mesh.x) weight.values.push_back(1 + 3 * x);
  mesh.vertex_attributes.push_back(weight);
  const auto table = std::make_shared<TensorTable>(table_of(mesh, [](Vector3 p) {
    const double size = 1 + p.y;  // density 1 / (2 (1 + y)^2)
    return std::pair{Vector3{1, 0.5, 0}, std::array<double, 2>{2 * size, size}};
  }));
  const double left = *std::min_element(mesh.x.begin(), mesh.x.end()),
               low = *std::min_element(mesh.y.begin(), mesh.y.end());
  const double wide = *std::max_element(mesh.x.begin(), mesh.x.end()) - left,
               high = *std::max_element(mesh.y.begin(), mesh.y.end()) - low;
  SampleParameters parameters = anisotropic();
  parameters.density.kind = DensityKind::vertex_attribute;
  parameters.density.attribute = "weight";
  ChartedModel model = charted(mesh, parameters, table);
  constexpr std::uint32_t n = 2000;
  std::vector<double> counts(16, 0.0), expected(16, 0.0);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Samples& samples = draw(model, n, seed);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = (static_cast<double>(samples.points[3 * i]) - left) / wide,
                   y = (static_cast<double>(samples.points[3 * i + 1]) - low) / high;
      ++counts[static_cast<std::size_t>(std::min(3.0, 4 * x)) +
               4 * static_cast<std::size_t>(std::min(3.0, 4 * y))];
    }
  }
  const auto x_integral = [&](double x) { return (1 + 3 * left) * x + 1.5 * wide * x * x; };
  const auto y_integral = [&](double y) { return -1 / (1 + low + high * y); };
  const double total = (x_integral(1) - x_integral(0)) * (y_integral(1) - y_integral(0));
  for (std::size_t c = 0; c < 16; ++c) {
    const double x = 0.25 * static_cast<double>(c % 4), y = 0.25 * static_cast<double>(c / 4);
    expected[c] =
        4 * n * (x_integral(x + 0.25) - x_integral(x)) * (y_integral(y + 0.25) - y_integral(y)) / total;
    CHECK(counts[c] == Approx(expected[c]).epsilon(0.01).margin(2 * std::sqrt(expected[c])));
  }
}

TEST_CASE("anisotropic sampling: file attributes can be tensors, like a table") {
  PolygonMesh mesh = torus(24, 12);
  // Turned by other angles everywhere: on a symmetric mesh the last bits of tensors decide where it is cut.
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double x = mesh.x[v], y = mesh.y[v], angle = 0.1 * std::sin(std::atan2(y, x) + 3 * mesh.z[v] + 1);
    mesh.x[v] = x * std::cos(angle) - y * std::sin(angle);
    mesh.y[v] = x * std::sin(angle) + y * std::cos(angle);
  }
  const TensorTable table = *around_torus(mesh);
  constexpr std::array<const char*, 6> names = {"S_xx", "S_xy", "S_xz", "S_yy", "S_yz", "S_zz"};
  for (std::size_t k = 0; k < 6; ++k) {
    mesh.vertex_attributes.push_back({names[k], {}});
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
      mesh.vertex_attributes.back().values.push_back(table.values[6 * v + k]);
  }
  SampleParameters parameters = anisotropic(TensorKind::vertex_attribute);
  parameters.tensor.attribute = "S";
  ChartedModel by_name = charted(mesh, parameters),
               by_table = charted(mesh, anisotropic(), std::make_shared<TensorTable>(table));
  CHECK(draw(by_name, 300, 1).points == draw(by_table, 300, 1).points);
  // The metric of the same tensor: S^-2.
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double size = torus_size(mesh.x[v]), along = 1 / (9 * size * size);
    const double across = 1 / (size * size), extra = along - across;
    const double r = std::hypot(mesh.x[v], mesh.y[v]), x = -mesh.y[v] / r, y = mesh.x[v] / r;
    const std::array<double, 6> metric = {
        across + extra * x * x, extra * x * y, 0, across + extra * y * y, 0, across};
    for (std::size_t k = 0; k < 6; ++k) mesh.vertex_attributes[k].values[v] = metric[k];
  }
  parameters.tensor.form = TensorForm::metric;
  ChartedModel by_metric = charted(mesh, parameters);
  const Samples metric = draw(by_metric, 300, 1), spacing = draw(by_table, 300, 1);
  std::size_t same = 0;
  for (std::size_t i = 0; i < 300; ++i) same += metric.face[i] == spacing.face[i];
  CHECK(same >= 295);
  // Vectors on faces.
  for (const char* const suffix : {"v_x", "v_y", "v_z"})
    mesh.face_attributes.push_back(
        {suffix, std::vector<double>(mesh.polygon_count(), suffix[2] == 'z' ? 4 : 0)});
  parameters.tensor = {};
  parameters.tensor.kind = TensorKind::face_attribute;
  parameters.tensor.attribute = "v";
  ChartedModel by_face = charted(mesh, parameters);
  const Samples& upright = draw(by_face, 300, 1);
  for (std::size_t i = 0; i < 300; ++i) {
    const double ratio = static_cast<double>(upright.tensor_spacing[2 * i]) /
                         static_cast<double>(upright.tensor_spacing[2 * i + 1]);
    CHECK(ratio < 4.001);
  }
  CHECK(by_face.state.segments.report.mean_spacing_ratio > 2);
}

TEST_CASE("anisotropic sampling: geodesic descriptors do not depend on segments") {
  SampleParameters parameters = anisotropic(TensorKind::constant, AlignmentForm::gradient);
  parameters.tensor.constant = {1, 0, 0, 1, 0, 4};
  parameters.tensor_charts.segment.count = 12;
  parameters.samples = 400;
  parameters.describe.descriptors = {Descriptor::d2, Descriptor::geodesic};
  const Row row = sampled(icosphere(3), parameters);
  REQUIRE(row.report.status == Status::ok);
  REQUIRE(row.descriptors.size() == 3 + anisotropy_names.size());
  CHECK(row.descriptors[3].values[0] >= 12);  // segments
  // Along a sphere: sin(theta) / 2 in theta, whose mean is pi / 2; 32 bins to three times that. The stretched
  // samples are a little denser at the poles, in pairs as a whole hardly.
  const std::vector<float>& bins = row.descriptors[1].values;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    const double width = 1.5 * std::numbers::pi / 32,
                 from = std::min(width * static_cast<double>(b), std::numbers::pi),
                 to = std::min(from + width, std::numbers::pi);
    CHECK(static_cast<double>(bins[b]) == Approx(0.5 * (std::cos(from) - std::cos(to))).margin(0.02));
  }
}

TEST_CASE("anisotropic sampling: a missing tensor has its own status, an invalid one is unreadable") {
  SampleParameters parameters = anisotropic(TensorKind::vertex_attribute);
  parameters.tensor.attribute = "grain";
  parameters.samples = 50;
  const Row missing = sampled(icosphere(1), parameters);
  CHECK(missing.report.status == Status::missing_attribute);
  CHECK_THAT(missing.report.reason, ContainsSubstring("grain"));
  CHECK(missing.samples.points.empty());
  CHECK(missing.descriptors.empty());
  parameters = anisotropic(TensorKind::table);
  const auto table = std::make_shared<TensorTable>();
  table->values.assign(6 * 7, 1);  // seven rows for another number of vertices
  parameters.tensor.table = table;
  const Row length = sampled(icosphere(1), parameters);
  CHECK(length.report.status == Status::unreadable);
  CHECK_FALSE(length.report.reason.empty());
}

TEST_CASE("anisotropic sampling: spacings so extreme that segments have no finite chart are sampled") {
  const PolygonMesh mesh = grid_plane(20, 20);
  TensorTable table;
  for (const double x : mesh.x) {
    const double metric = std::pow(10.0, 600 * x - 300);
    table.values.insert(table.values.end(), {metric, 0, 0, metric, 0, metric});
  }
  for (const AlignmentForm form : forms) {
    INFO(form_name(form));
    SampleParameters parameters = anisotropic(TensorKind::table);
    parameters.tensor.table = std::make_shared<TensorTable>(table);
    parameters.tensor.form = TensorForm::metric;
    parameters.tensor_charts.form = form;
    parameters.tensor_charts.segment.count = 16;
    parameters.samples = 100;
    const Row row = sampled(mesh, parameters);
    CHECK(row.report.status == Status::ok);
    CHECK(row.samples.count() == 100);
  }
}

TEST_CASE("anisotropic sampling: parameters out of range are named") {
  SampleParameters parameters = anisotropic();
  parameters.tensor.max_ratio = 0.5;
  parameters.tensor_charts.segment.count = 0;
  parameters.tensor_charts.max_bisections = 17;
  CHECK(validate(parameters).size() == 3);
  CHECK(certificate_problems(parameters).size() == 1);
  CHECK_THROWS_AS(sampled(icosphere(1), parameters), std::invalid_argument);
  parameters.method = MethodChoice::conformal;
  CHECK(validate(anisotropic()).empty());
}
