// Coordinates near the ends of double and beyond those of float32: exactly n distinct finite points, or a
// status that says why not.
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "kernels/analyse/certify_samples.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model_sampler.h"
#include "support/catch.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

constexpr std::uint32_t samples = 64;

struct ExtremeMethod {
  const char* name;
  MethodChoice method;
  AlignmentForm form;
};
constexpr std::array<ExtremeMethod, 5> extreme_methods = {
    {{"auto", MethodChoice::automatic, AlignmentForm::metric},
     {"conformal", MethodChoice::conformal, AlignmentForm::metric},
     {"direct", MethodChoice::direct, AlignmentForm::metric},
     {"anisotropic, metric", MethodChoice::anisotropic, AlignmentForm::metric},
     {"anisotropic, gradient", MethodChoice::anisotropic, AlignmentForm::gradient}}};

// Everything that is measured of samples, as far as the method allows it.
SampleParameters parameters_of(const ExtremeMethod& method) {
  SampleParameters parameters;
  parameters.method = method.method;
  parameters.tensor_charts.form = method.form;
  parameters.describe.descriptors = {Descriptor::d2,        Descriptor::a3,    Descriptor::d1,
                                     Descriptor::d3,        Descriptor::d4,    Descriptor::geodesic,
                                     Descriptor::basics,    Descriptor::pairs, Descriptor::pairs_unsigned,
                                     Descriptor::harmonics, Descriptor::views, Descriptor::shapedna};
  parameters.samples = samples;
  return parameters;
}

Row sampled(const PolygonMesh& mesh, const SampleParameters& parameters) {
  std::vector<double> positions;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    positions.insert(positions.end(), {mesh.x[v], mesh.y[v], mesh.z[v]});
  Row row = ModelSampler(parameters).sample(polygon_mesh_of({positions, triangles_of(mesh)}));
  if (row.report.status == Status::ok && certificate_problems(parameters).empty())
    certify_samples(row, prepare_mesh(mesh, {}), {});
  return row;
}

PolygonMesh scaled(PolygonMesh mesh, double factor) {
  for (std::vector<double>* c : {&mesh.x, &mesh.y, &mesh.z})
    for (double& value : *c) value *= factor;
  return mesh;
}

bool all_finite(std::span<const float> values) {
  for (const float value : values)
    if (!std::isfinite(value)) return false;
  return true;
}

std::size_t distinct_points(const Samples& s) {
  std::set<std::array<float, 3>> distinct;
  for (std::size_t i = 0; i < s.count(); ++i)
    distinct.insert({s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]});
  return distinct.size();
}

void check_whole(const Row& row) {
  const ItemReport& report = row.report;
  INFO(report.reason);
  REQUIRE(report.status == Status::ok);
  CHECK(distinct_points(row.samples) == samples);
  CHECK(report.repairs[Repair::coincident_points] == 0);
  CHECK(all_finite(row.samples.points));
  CHECK(all_finite(row.samples.normals));
  CHECK(all_finite(row.samples.density));
  CHECK(all_finite(row.samples.tensor_spacing));
  for (const float spacing : row.samples.tensor_spacing) CHECK(spacing > 0);
  for (const DescriptorRow& descriptor : row.descriptors) {
    INFO(descriptor.name);
    CHECK(all_finite(descriptor.values));
  }
  CHECK(std::isfinite(report.area));
  CHECK(std::isfinite(report.measure));
  CHECK(std::isfinite(report.scale));
  CHECK(report.scale > 0);
  for (const double c : report.bbox) CHECK(std::isfinite(c));
  for (const double c : report.loc) CHECK(std::isfinite(c));
}

// The points in units of the factor that a model was scaled with, next to those of the model itself.
double largest_difference(const Row& row, double factor, const Row& plain) {
  double most = 0;
  for (std::size_t i = 0; i < row.samples.points.size(); ++i) {
    const double here = row.report.loc[i % 3] / factor + row.report.scale / factor * row.samples.points[i];
    const double there = plain.report.loc[i % 3] + plain.report.scale * plain.samples.points[i];
    most = std::max(most, std::abs(here - there));
  }
  return most;
}

}  // namespace

TEST_CASE("extreme coordinates: every size that double holds gives exactly n distinct finite points") {
  for (const ExtremeMethod& method : extreme_methods)
    for (const double size :
         thinned<double>(4, {1e39, 1e150, 1e-44, 1e-310, 1e60, 1e-38, 1e-60, 1e-150, 1e-200, 1e-300})) {
      INFO(method.name << ", " << size);
      check_whole(sampled(scaled(torus(12, 8), size), parameters_of(method)));
    }
}

TEST_CASE("extreme coordinates: a model scaled by a power of two is sampled at the same places") {
  for (const ExtremeMethod& method : extreme_methods) {
    const SampleParameters parameters = parameters_of(method);
    const Row plain = sampled(torus(12, 8), parameters);
    REQUIRE(plain.report.status == Status::ok);
    for (const int exponent : thinned<int>(3, {-1000, -140, 500, -500, -100, 100, 127, 200})) {
      INFO(method.name << ", 2^" << exponent);
      const double factor = std::ldexp(1.0, exponent);
      const Row row = sampled(scaled(torus(12, 8), factor), parameters);
      check_whole(row);
      CHECK(row.samples.face == plain.samples.face);
      CHECK(row.samples.barycentric == plain.samples.barycentric);
      CHECK(largest_difference(row, factor, plain) <= 2e-7);
      REQUIRE(row.descriptors.size() == plain.descriptors.size());
      for (std::size_t d = 0; d < row.descriptors.size(); ++d)
        for (std::size_t k = 0; k < row.descriptors[d].values.size(); ++k)
          CHECK(row.descriptors[d].values[k] == Approx(plain.descriptors[d].values[k]).margin(1e-3));
    }
  }
}

TEST_CASE("extreme coordinates: one triangle of the smallest positive double") {
  constexpr double least = std::numeric_limits<double>::denorm_min();
  for (const ExtremeMethod& method : extreme_methods) {
    INFO(method.name);
    const Row row =
        sampled(polygon_mesh({0, 0, 0, least, 0, 0, 0, least, 0}, {{0, 1, 2}}), parameters_of(method));
    check_whole(row);
    CHECK(row.report.scale == least);
  }
}

TEST_CASE("extreme coordinates: far from the origin, and one far vertex beside a small part") {
  PolygonMesh spike = scaled(torus(12, 8), 1e33), needle = torus(12, 8);
  spike.x[17] = needle.x[17] = 1e39;
  const PolygonMesh apart =
      merged(torus(12, 8), polygon_mesh({0, 0, 0, 1e39, 0, 0, 0, 1e39, 0}, {{0, 1, 2}}));
  PolygonMesh far_and_large = scaled(torus(12, 8), 1e40), far_and_small = scaled(torus(12, 8), 1e-60);
  for (double& x : far_and_large.x) x += 1e46;
  for (double& x : far_and_small.x) x += 1e-54;
  for (const ExtremeMethod& method : extreme_methods) {
    INFO(method.name);
    const SampleParameters parameters = parameters_of(method);
    for (const PolygonMesh& mesh : {spike, apart, far_and_large, far_and_small})
      check_whole(sampled(mesh, parameters));
    // Against the square of its diagonal, its area is nothing.
    CHECK(sampled(needle, parameters).report.status == Status::zero_area);
  }
}

TEST_CASE("extreme coordinates: normalized, lifted onto the curved surface, and with a curvature density") {
  for (const double size : {1e39, 1e-60, 1e-310}) {
    INFO(size);
    const PolygonMesh mesh = scaled(torus(12, 8), size);
    SampleParameters parameters = parameters_of(extreme_methods[1]);
    parameters.curved = true;
    check_whole(sampled(mesh, parameters));
    parameters = parameters_of(extreme_methods[1]);
    parameters.density.kind = DensityKind::mean;
    check_whole(sampled(mesh, parameters));
    for (const NormalizeKind kind : {NormalizeKind::unit_box, NormalizeKind::unit_sphere,
                                     NormalizeKind::unit_diagonal, NormalizeKind::pointnet}) {
      parameters = parameters_of(extreme_methods[1]);
      parameters.normalize = kind;
      const Row row = sampled(mesh, parameters);
      check_whole(row);
      for (const float c : row.samples.points) CHECK(std::abs(c) <= 1.000001f);
    }
  }
}

TEST_CASE("extreme coordinates: sizes that double cannot measure are non_finite, with a reason") {
  for (const ExtremeMethod& method : extreme_methods)
    for (const double size : {1e200, 1e300, 1.2e308}) {
      INFO(method.name << ", " << size);
      const Row row = sampled(scaled(torus(12, 8), size), parameters_of(method));
      CHECK(row.report.status == Status::non_finite);
      CHECK(row.report.reason.find("too large") != std::string::npos);
      CHECK(row.samples.count() == 0);
    }
}

TEST_CASE("extreme coordinates: coordinates within float32 are stored unchanged") {
  for (const double size : {1e-37, 1e-30, 1.0, 1e30, 5e35}) {
    INFO(size);
    const Row row = sampled(scaled(torus(12, 8), size), parameters_of(extreme_methods[1]));
    REQUIRE(row.report.status == Status::ok);
    CHECK(row.report.scale == 1);
    CHECK(row.report.loc == std::array<double, 3>{0, 0, 0});
  }
}
