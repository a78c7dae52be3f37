// Densities by formulas: masses against closed forms, samples against masses, and what is refused.
#include "kernels/density/formula_density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "kernels/analyse/chi_square.h"
#include "kernels/density/density_pieces.h"
#include "kernels/density/pieces.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/model/model.h"
#include "kernels/rays/embree_locator.h"
#include "support/catch.h"
#include "support/test_meshes.h"
#include "support/threads.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

DensityParameters by_formula(const std::string& text, DensityKind kind = DensityKind::formula) {
  DensityParameters parameters;
  parameters.kind = kind;
  parameters.formula = text;
  return parameters;
}

double integral(const PolygonMesh& file, const DensityParameters& parameters) {
  const PreparedMesh mesh = prepare_mesh(file);
  return file_measure(mesh, measure_of(mesh, make_formula_density(file, mesh, parameters), false).total());
}
double integral(const PolygonMesh& file, const std::string& text) { return integral(file, by_formula(text)); }

// The unit square at z = 0 with its texture coordinates, as two triangles.
PolygonMesh square() {
  PolygonMesh mesh = grid_plane(1, 1);
  mesh.coordinates.values = {0, 0, 1, 0, 1, 1, 0, 1};
  mesh.coordinates.corner.clear();
  for (const std::uint32_t v : mesh.corners)
    mesh.coordinates.corner.push_back(mesh.x[v] > 0.5 ? (mesh.y[v] > 0.5 ? 2 : 1)
                                                      : (mesh.y[v] > 0.5 ? 3 : 0));
  return mesh;
}

Model sampled(const PolygonMesh& file, const std::string& formula, SequenceKind sequence,
              std::uint32_t samples) {
  static const EmbreeDevice device;
  SampleParameters parameters;
  parameters.density = by_formula(formula);
  parameters.sequence = sequence;
  parameters.samples = samples;
  REQUIRE(validate(parameters).empty());
  Model model;
  model.file = file;
  model.key = make_random_key(3, {});
  run_stages(stages_of(parameters, &device), model);
  return model;
}

// The status and the sentence.
std::pair<Status, std::string> failure_of(const PolygonMesh& file, const std::string& formula) {
  try {
    integral(file, formula);
  } catch (const ItemError& error) {
    return {error.status(), error.what()};
  }
  return {Status::ok, ""};
}

}  // namespace

TEST_CASE("formula density: masses of formulas linear over triangles are exact") {
  // The cube [-1, 1]^3; each face has the area 4.
  CHECK(integral(cube(), "3") == Approx(72).epsilon(1e-14));
  CHECK(integral(cube(), "2 + x") == Approx(48).epsilon(1e-14));
  CHECK(integral(cube(), "(4 + x - 2*y + z/2) / 8") == Approx(12).epsilon(1e-14));
  CHECK(integral(cube(), "max(nz, 0)") == Approx(4).epsilon(1e-14));
  CHECK(integral(cube(), "nx^2 * (1 + x)") == Approx(8).epsilon(1e-14));
  CHECK(integral(square(), "u") == Approx(0.5).epsilon(1e-14));
  CHECK(integral(square(), "3*u + v") == Approx(2).epsilon(1e-14));
  CHECK(make_formula_density(cube(), prepare_mesh(cube()), by_formula("2 + x")).corner.size() == 36);
}

TEST_CASE("formula density: masses of other formulas are close to the integral") {
  CHECK(integral(cube(), "x^2") == Approx(8 + 16 / 3.0).epsilon(1e-5));
  CHECK(integral(square(), "exp(-20*((x - 0.5)^2 + (y - 0.5)^2))") ==
        Approx(std::numbers::pi / 20 * std::pow(std::erf(std::sqrt(5.0)), 2)).epsilon(1e-5));
  // 40 waves along the square, 6 pieces and a half to a wave.
  CHECK(integral(square(), "1 + sin(80*pi*x)") == Approx(1).epsilon(1e-4));
  const PreparedMesh mesh = prepare_mesh(square());
  const Density density = make_formula_density(square(), mesh, by_formula("x*y"));
  REQUIRE(density.in_pieces());
  const TriangleSource source = source_of(mesh, density, 0);
  double worst = 0;
  for (double b1 = 0.02; b1 < 0.95; b1 += 0.031)
    for (double b2 = 0.01; b1 + b2 < 1; b2 += 0.029) {
      const Vector3 at = mesh.center + mesh.unit * source.at(b1, b2);
      worst = std::max(worst, std::abs(source.density_at(b1, b2) - at.x * at.y));
    }
  CHECK(worst < 0.005);
}

TEST_CASE("formula density: curvature and lengths are in units of the file, or of the unit box") {
  const PolygonMesh sphere = moved(icosphere(5, 2), 1, 10, -3, 5);
  const double area = integral(sphere, "1");
  CHECK(integral(sphere, "mean") == Approx(area / 2).epsilon(2e-3));
  CHECK(integral(sphere, "gaussian") == Approx(4 * std::numbers::pi).epsilon(5e-3));
  CHECK(integral(sphere, "x") == Approx(10 * area).epsilon(1e-6));
  const auto in_box = [&](const std::string& text) {
    return integral(sphere, by_formula(text, DensityKind::unit_formula)) / area;
  };
  CHECK(in_box("mean") == Approx(2).epsilon(2e-3));
  CHECK(in_box("gaussian") == Approx(4).epsilon(5e-3));
  CHECK(in_box("z") == Approx(0.5).epsilon(1e-5));
  CHECK(in_box("x*x") == Approx(0.25 + 0.25 / 3).epsilon(1e-3));
}

TEST_CASE("formula density: samples are as dense as the formula says", "[statistics]") {
  // 16 x 16 cells; independent points, whose counts chi-square knows, and the default's, which vary less.
  const std::string formula = "x^2 + 0.1 + sin(7*y)^2";
  constexpr std::size_t across = 16;
  std::vector<double> expected;
  for (std::size_t j = 0; j < across; ++j)
    for (std::size_t i = 0; i < across; ++i) {
      const double a = i / 16.0, b = (i + 1) / 16.0, c = j / 16.0, d = (j + 1) / 16.0;
      const double squares = (b * b * b - a * a * a) / 3 * (d - c);
      const double waves = ((d - c) / 2 - (std::sin(14 * d) - std::sin(14 * c)) / 28) * (b - a);
      expected.push_back(squares + 0.1 / 256 + waves);
    }
  for (const SequenceKind sequence : {SequenceKind::random, SequenceKind::shifted, SequenceKind::spaced}) {
    CAPTURE(static_cast<int>(sequence));
    const Model model = sampled(square(), formula, sequence, 20000);
    const Samples& samples = model.row.samples;
    std::vector<std::uint64_t> counts(across * across);
    double worst = 0;
    for (std::size_t i = 0; i < samples.count(); ++i) {
      const auto x = static_cast<double>(samples.points[3 * i]),
                 y = static_cast<double>(samples.points[3 * i + 1]);
      const auto cell = [](double value) {
        return std::min(across - 1, static_cast<std::size_t>(std::max(0.0, value) * across));
      };
      ++counts[across * cell(y) + cell(x)];
      const double value = x * x + 0.1 + std::pow(std::sin(7 * y), 2);
      worst = std::max(worst, std::abs(value - static_cast<double>(samples.density[i])));
    }
    CHECK(worst < 0.02);
    const ChiSquare test = chi_square_test(counts, expected);
    CHECK(test.p_value > 1e-4);
    if (sequence == SequenceKind::shifted) CHECK(test.statistic < test.degrees / 4);
  }
}

TEST_CASE("formula density: no samples where it is zero") {
  const Model model = sampled(square(), "max(x - 0.5, 0)", SequenceKind::shifted, 5000);
  const std::vector<float>& points = model.row.samples.points;
  float least = 1;
  for (std::size_t i = 0; i < points.size(); i += 3) least = std::min(least, points[i]);
  CHECK(least > 0.497F);
}

TEST_CASE("formula density: an invalid density is a status with a reason") {
  using Failure = std::pair<Status, std::string>;
  const auto fails = [](const PolygonMesh& file, const std::string& formula, Status status,
                        const std::string& sentence) {
    CAPTURE(formula);
    const Failure failure = failure_of(file, formula);
    CHECK(failure.first == status);
    CHECK_THAT(failure.second, ContainsSubstring(sentence));
  };
  fails(square(), "x - 0.25", Status::unreadable,
        "the density `x - 0.25` is -0.25 on face 0, at x = 0, y = 0, z = 0; a density must be finite and not "
        "negative");
  fails(square(), "x^2 - 0.25", Status::unreadable, "a density must be finite and not negative");
  fails(square(), "log(x)", Status::unreadable, "the density `log(x)` is -");
  fails(square(), "1 / z", Status::unreadable, "is inf on face 0");
  fails(square(), "sqrt(-1 - z)", Status::unreadable, "nan on face 0");
  fails(square(), "1e39", Status::unreadable, "too large: densities are stored in float32");
  fails(square(), "z", Status::zero_density, "the density `z` is zero on the whole surface");
  fails(square(), "abs(z)", Status::zero_density, "is zero on the whole surface");
  fails(cube(), "u", Status::missing_attribute, "uses texture coordinates, u or v, but the file has none");
  PolygonMesh half = square();
  half.coordinates.corner[4] = no_index;
  fails(half, "u*v", Status::missing_attribute, "uses texture coordinates, u or v, but face");
  CHECK(failure_of(half, "x").first == Status::ok);
  // Rounding is no mistake.
  CHECK(failure_of(square(), "(x - 1e-13) * 1").first == Status::ok);
}

TEST_CASE("formula density: succeeds and fails the same for any number of threads", "[release]") {
  PolygonMesh sphere = icosphere(6);  // enough triangles for many blocks
  const PreparedMesh mesh = prepare_mesh(sphere);
  sphere.coordinates.values = {0.5, 0.5};
  sphere.coordinates.corner.assign(sphere.corners.size(), 0);
  for (std::size_t c = 30000; c < sphere.corners.size(); c += 20011) sphere.coordinates.corner[c] = no_index;
  struct Outcome {
    std::vector<double> pieces, corners;
    std::string failure;
    bool operator==(const Outcome&) const = default;
  };
  const auto with = [&](std::size_t threads, const std::string& formula) {
    return on_threads(threads, [&]() -> Outcome {
      try {
        const Density density = make_formula_density(sphere, mesh, by_formula(formula));
        return {density.piece_mean, density.corner, {}};
      } catch (const ItemError& error) {
        return {{}, {}, error.what()};
      }
    });
  };
  for (const char* formula :
       {"2 + x + mean", "x*x + mean", "1 + x*y", "0.9 - z*z", "0.9 - z", "1 + u", "u*v"}) {
    CAPTURE(formula);
    const Outcome one = with(1, formula);
    const bool fails = formula[0] == '0' || std::string_view(formula).find('u') != std::string_view::npos;
    CHECK(one.failure.empty() != fails);
    for (int repeat = 0; repeat < 5; ++repeat) CHECK(with(8, formula) == one);
  }
}

TEST_CASE("formula density: samples at curve vertices are redrawn by the density, at any scale") {
  const auto points = [](const std::string& formula) {
    static const EmbreeDevice device;
    SampleParameters parameters = parameters_for("direct");
    parameters.density = by_formula(formula);
    parameters.place = PlaceKind::vertex;
    parameters.samples = 3000;
    Model model;
    model.file = square();
    model.key = make_random_key(3, {});
    run_stages(stages_of(parameters, &device), model);
    return model.row.samples.points;
  };
  CHECK(points("max(x - 0.5, 0)") == points("1024*max(x - 0.5, 0)"));
  const std::vector<float> on_right = points("max(x - 0.5, 0)");
  float least = 1;
  for (std::size_t i = 0; i < on_right.size(); i += 3) least = std::min(least, on_right[i]);
  CHECK(least > 0.49F);
}

TEST_CASE("formula density: invalid parameters are found before a model is read") {
  SampleParameters parameters;
  const auto problems = [&](const std::string& formula) {
    parameters.density = by_formula(formula);
    const std::vector<std::string> all = validate(parameters);
    return all.empty() ? std::string() : all.front();
  };
  CHECK(problems("1 + x") == "");
  CHECK_THAT(problems("1 + "), ContainsSubstring("column 5"));
  CHECK_THAT(problems("nw"), ContainsSubstring("did you mean"));
  CHECK_THAT(problems(""), ContainsSubstring("the text ends"));
  parameters.method = MethodChoice::anisotropic;
  CHECK(problems("1 + x") == "");
  CHECK_THAT(problems("x^2"), ContainsSubstring("does not go with the method anisotropic"));
  parameters.method = MethodChoice::automatic;
  parameters.topology = false;
  CHECK(problems("x^2") == "");
  CHECK_THAT(problems("mean"), ContainsSubstring("a curvature density needs the topology"));
}

TEST_CASE("Expression::degree: recognizes polynomials and their degree") {
  constexpr std::array<std::uint32_t, 5> degrees = {1, 1, 1, 2, 0};  // u v x y z
  const auto degree = [&](const char* text) { return Expression(text).degree(degrees); };
  CHECK(degree("3") == 0);
  CHECK(degree("sin(z) / exp(z)") == 0);
  CHECK(degree("-x + 2*u - v/3") == 1);
  CHECK(degree("x*y + u") == 3);
  CHECK(degree("y^3") == 6);
  CHECK(degree("x^0") == 0);
  CHECK(degree("((x^16)^16)^16") == 4096);
  CHECK(degree("(((((x^16)^16)^16)^16)^16)^16") == Expression::not_polynomial);
  for (const char* text : {"abs(x)", "min(x, 1)", "max(1, x)", "1/x", "2^x", "x^z", "sqrt(x)", "sin(x) + x"})
    CHECK(degree(text) >= Expression::not_polynomial);
}
