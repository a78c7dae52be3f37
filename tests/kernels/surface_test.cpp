#include "kernels/surface/surface.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "kernels/core/status.h"
#include "kernels/surface/analytic_surface.h"
#include "kernels/surface/fundamental_forms.h"
#include "kernels/surface/height_field.h"
#include "kernels/surface/nurbs_patch.h"
#include "support/catch.h"

using namespace meander;
using std::numbers::pi;

namespace {

SurfaceJet jet_at(const ParametricSurface& surface, double u, double v) {
  SurfaceJet jet;
  surface.jets({&u, 1}, {&v, 1}, {&jet, 1});
  return jet;
}
Vector3 position_at(const ParametricSurface& surface, double u, double v) {
  Vector3 p;
  surface.positions({&u, 1}, {&v, 1}, {&p, 1});
  return p;
}
SurfaceTangents tangents_at(const ParametricSurface& surface, double u, double v) {
  SurfaceTangents t;
  surface.tangents({&u, 1}, {&v, 1}, {&t, 1});
  return t;
}

std::vector<std::pair<double, double>> random_parameters(std::size_t count) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> uniform(0.01, 0.99);
  std::vector<std::pair<double, double>> result(count);
  for (auto& [u, v] : result) {
    u = uniform(engine);
    v = uniform(engine);
  }
  return result;
}

// First and second derivatives against central differences of positions and tangents; the three evaluations
// agree with each other.
void check_derivatives(const ParametricSurface& surface, double u, double v) {
  constexpr double h = 1e-5;
  const SurfaceJet jet = jet_at(surface, u, v);
  const SurfaceTangents here = tangents_at(surface, u, v);
  CHECK(distance(jet.position, position_at(surface, u, v)) < 1e-14);
  CHECK(distance(jet.position, here.position) < 1e-14);
  CHECK(distance(jet.du, here.du) < 1e-12);
  CHECK(distance(jet.dv, here.dv) < 1e-12);
  const auto difference = [&](Vector3 above, Vector3 below) { return (0.5 / h) * (above - below); };
  const double scale = 1 + norm(jet.du) + norm(jet.dv) + norm(jet.duu) + norm(jet.duv) + norm(jet.dvv);
  const SurfaceTangents right = tangents_at(surface, u + h, v), left = tangents_at(surface, u - h, v),
                        above = tangents_at(surface, u, v + h), below = tangents_at(surface, u, v - h);
  CHECK(distance(jet.du, difference(right.position, left.position)) < 2e-7 * scale);
  CHECK(distance(jet.dv, difference(above.position, below.position)) < 2e-7 * scale);
  CHECK(distance(jet.duu, difference(right.du, left.du)) < 2e-7 * scale);
  CHECK(distance(jet.duv, difference(above.du, below.du)) < 2e-7 * scale);
  CHECK(distance(jet.duv, difference(right.dv, left.dv)) < 2e-7 * scale);
  CHECK(distance(jet.dvv, difference(above.dv, below.dv)) < 2e-7 * scale);
}

// The reason of the ItemError that `body` throws; empty when it does not.
template <class Body>
std::string reason_of(const Body& body) {
  try {
    body();
  } catch (const ItemError& error) {
    return error.what();
  }
  return {};
}

struct Transcendental {
  static constexpr std::string_view name = "transcendental";
  template <class Scalar>
  std::array<Scalar, 3> operator()(const Scalar& u, const Scalar& v) const {
    const Scalar r = square_root(Scalar(1.0) + u * u + v);
    return {exponential(u * v) / r, logarithm(Scalar(2.0) + u - v), integer_power(u - v, 3) * r};
  }
};

// A quarter of a cylinder of radius 2 and height 3 around z.
constexpr std::string_view quarter_cylinder = R"(# exact: a rational quadratic
degree 2 1
knots_u 0 0 0 1 1 1
knots_v 0 0
knots_v 1 1   # continued
point 2 0 0
point 2 0 3
point 2 2 0 0.70710678118654752
point 2 2 3 0.70710678118654752
point 0 2 0
point 0 2 3
)";

NurbsNet plane_net() {
  // Control points at the Greville abscissae: the map is the identity.
  NurbsNet net;
  net.degree_u = 3;
  net.degree_v = 2;
  net.knots_u = {0, 0, 0, 0, 0.3, 0.3, 0.7, 1, 1, 1, 1};
  net.knots_v = {-1, -1, -1, 0, 1, 1, 1};
  const std::size_t nu = net.knots_u.size() - 4, nv = net.knots_v.size() - 3;
  for (std::size_t i = 0; i < nu; ++i)
    for (std::size_t j = 0; j < nv; ++j) {
      const double u = (net.knots_u[i + 1] + net.knots_u[i + 2] + net.knots_u[i + 3]) / 3,
                   v = (net.knots_v[j + 1] + net.knots_v[j + 2]) / 2;
      net.points.insert(net.points.end(), {u, v, 1 + 2 * u - 3 * v});
    }
  return net;
}

}  // namespace

TEST_CASE("surfaces: every known name makes one, others are refused") {
  REQUIRE(surface_names().size() == 7);
  for (const std::string_view name : surface_names()) {
    const auto surface = make_surface(name);
    REQUIRE(surface != nullptr);
    CHECK(surface->name() == name);
  }
  CHECK(make_surface("spher") == nullptr);
  CHECK(make_surface("sphere")->content() != make_surface("torus")->content());
}

TEST_CASE("surfaces: automatic derivatives match finite differences") {
  for (const std::string_view name : surface_names()) {
    INFO(name);
    const auto surface = make_surface(name);
    for (const auto& [u, v] : random_parameters(20)) check_derivatives(*surface, u, v);
  }
  const AnalyticSurface<Transcendental> user;
  for (const auto& [u, v] : random_parameters(20)) check_derivatives(user, u, v);
}

TEST_CASE("surfaces: seams close and poles are points") {
  for (const double t : {0.0, 0.13, 0.5, 0.77, 1.0}) {
    for (const char* name : {"sphere", "torus", "eight"})
      CHECK(distance(position_at(*make_surface(name), 0, t), position_at(*make_surface(name), 1, t)) < 1e-14);
    CHECK(distance(position_at(*make_surface("torus"), t, 0), position_at(*make_surface("torus"), t, 1)) <
          1e-14);
    // The Klein bottle closes with v turned round.
    const auto klein = make_surface("klein-bottle");
    CHECK(distance(position_at(*klein, 0, t), position_at(*klein, 1, 1 - t)) < 1e-13);
    CHECK(distance(position_at(*klein, t, 0), position_at(*klein, t, 1)) < 1e-13);
    CHECK(distance(position_at(*make_surface("sphere"), t, 0), {0, 0, -1}) < 1e-15);
    CHECK(distance(position_at(*make_surface("eight"), t, 0.5), {0, 0, 0}) < 1e-15);
  }
}

TEST_CASE("curvature: sphere, torus and monkey saddle have their closed forms") {
  for (const auto& [u, v] : random_parameters(50)) {
    const FundamentalForms sphere = fundamental_forms(jet_at(*make_surface("sphere"), u, v));
    CHECK(sphere.mean == Approx(-1).epsilon(1e-10));  // the normal points outwards
    CHECK(sphere.gaussian == Approx(1).epsilon(1e-10));
    CHECK(sphere.k1 == Approx(-1).epsilon(1e-6));
    CHECK(sphere.area_element == Approx(2 * pi * pi * std::sin(pi * v)).epsilon(1e-12));
    CHECK(dot(sphere.normal, position_at(*make_surface("sphere"), u, v)) == Approx(1));

    const FundamentalForms torus = fundamental_forms(jet_at(*make_surface("torus"), u, v));
    const double c = std::cos(2 * pi * v), radius = 1 + 0.5 * c;
    CHECK(torus.gaussian == Approx(c / (0.5 * radius)).epsilon(1e-10).margin(1e-12));
    CHECK(torus.mean == Approx(-(1 + c) / radius).epsilon(1e-10).margin(1e-12));
    CHECK(torus.k2 == Approx(-2).epsilon(1e-8));
    CHECK(torus.k1 == Approx(-c / radius).epsilon(1e-8).margin(1e-9));

    const FundamentalForms saddle = fundamental_forms(jet_at(*make_surface("monkey-saddle"), u, v));
    const double x = 2 * u - 1, y = 2 * v - 1, r2 = x * x + y * y;
    const double zx = 3 * (x * x - y * y), zy = -6 * x * y, w = 1 + 9 * r2 * r2;
    CHECK(saddle.gaussian == Approx(-36 * r2 / (w * w)).epsilon(1e-10).margin(1e-12));
    const double mean =
        ((1 + zy * zy) * 6 * x + 2 * zx * zy * 6 * y - (1 + zx * zx) * 6 * x) / (2 * std::pow(w, 1.5));
    CHECK(saddle.mean == Approx(mean).epsilon(1e-10).margin(1e-12));
  }
}

TEST_CASE("curvature: forms do not depend on the frame, curvature not on the parameters") {
  const Vector3 a = {0.6, 0.0, 0.8}, b = {0.48, 0.8, -0.36}, c = cross(a, b);
  const double size = 3;
  const auto moved = [&](Vector3 p) { return size * Vector3{dot(a, p), dot(b, p), dot(c, p)}; };
  for (const auto& [u, v] : random_parameters(20)) {
    const SurfaceJet jet = jet_at(*make_surface("klein-bottle"), u, v);
    const FundamentalForms forms = fundamental_forms(jet);
    const FundamentalForms turned = fundamental_forms(
        {moved(jet.position), moved(jet.du), moved(jet.dv), moved(jet.duu), moved(jet.duv), moved(jet.dvv)});
    CHECK(turned.E == Approx(size * size * forms.E));
    CHECK(turned.M == Approx(size * forms.M).margin(1e-10));
    CHECK(turned.area_element == Approx(size * size * forms.area_element));
    CHECK(turned.k1 == Approx(forms.k1 / size).margin(1e-10));
    CHECK(turned.gaussian == Approx(forms.gaussian / (size * size)).margin(1e-10));
    // u -> 2 u + v
    const FundamentalForms sheared =
        fundamental_forms({jet.position, 2 * jet.du, jet.du + jet.dv, 4 * jet.duu, 2 * (jet.duu + jet.duv),
                           jet.duu + 2 * jet.duv + jet.dvv});
    CHECK(sheared.mean == Approx(forms.mean).margin(1e-9));
    CHECK(sheared.gaussian == Approx(forms.gaussian).margin(1e-9));
    // Parameters exchanged: the normal turns round.
    const FundamentalForms swapped =
        fundamental_forms({jet.position, jet.dv, jet.du, jet.dvv, jet.duv, jet.duu});
    CHECK(swapped.mean == Approx(-forms.mean));
    CHECK(swapped.k1 == Approx(-forms.k2));
    CHECK(swapped.gaussian == Approx(forms.gaussian));
  }
}

TEST_CASE("curvature: degenerate points are zero, never NaN") {
  for (const FundamentalForms& forms :
       {fundamental_forms(jet_at(*make_surface("sphere"), 0.3, 0.0)),
        fundamental_forms(jet_at(*make_surface("eight"), 0.3, 0.5)),
        fundamental_forms(jet_at(*make_surface("stretched-plane"), 0.0, 0.4)), fundamental_forms({}),
        fundamental_forms({{}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}),
        fundamental_forms({{}, {1e200, 0, 0}, {0, 1e200, 0}, {}, {}, {}}),
        fundamental_forms({{}, {NAN, 0, 0}, {0, 1, 0}, {}, {}, {}})}) {
    CHECK(forms.area_element < 1e-14);
    for (const double value : {forms.E, forms.F, forms.G, forms.L, forms.M, forms.N, forms.area_element,
                               forms.mean, forms.gaussian, forms.k1, forms.k2, norm(forms.normal)})
      CHECK(std::isfinite(value));
    CHECK(forms.mean == 0);
    CHECK(forms.gaussian == 0);
  }
}

TEST_CASE("NURBS: a quarter cylinder is exact") {
  const auto surface = parse_nurbs_patch(quarter_cylinder);
  CHECK(surface->name() == "nurbs");
  double area = 0;
  constexpr int n = 64;
  for (int i = 0; i < n; ++i) {
    const double u = (i + 0.5) / n;
    const SurfaceJet jet = jet_at(*surface, u, 0.3);
    CHECK(std::hypot(jet.position.x, jet.position.y) == Approx(2).epsilon(1e-14));
    CHECK(jet.position.z == Approx(0.9));
    const FundamentalForms forms = fundamental_forms(jet);
    CHECK(std::abs(forms.mean) == Approx(0.25).epsilon(1e-10));
    CHECK(std::abs(forms.gaussian) < 1e-12);
    area += forms.area_element / n;
    check_derivatives(*surface, std::min(u, 0.99), 0.3);
  }
  CHECK(area == Approx(3 * pi).epsilon(1e-4));
  CHECK(distance(position_at(*surface, 0, 0), {2, 0, 0}) < 1e-15);
  CHECK(distance(position_at(*surface, 1, 1), {0, 2, 3}) < 1e-15);
}

TEST_CASE("NURBS: a B-spline reproduces a plane, across knots too") {
  const auto surface = make_nurbs_patch(plane_net());
  for (const double u : {0.0, 0.1, 0.3, 0.5, 0.7, 0.99, 1.0})
    for (const double v : {0.0, 0.25, 0.5, 0.8, 1.0}) {
      const SurfaceJet jet = jet_at(*surface, u, v);
      CHECK(distance(jet.position, {u, 2 * v - 1, 1 + 2 * u - 3 * (2 * v - 1)}) < 1e-14);
      CHECK(distance(jet.du, {1, 0, 2}) < 1e-13);
      CHECK(distance(jet.dv, {0, 2, -6}) < 1e-13);
      CHECK(norm(jet.duu) + norm(jet.duv) + norm(jet.dvv) < 1e-11);
    }
  NurbsNet other = plane_net();
  other.points[5] += 1;
  CHECK(make_nurbs_patch(other)->content() != surface->content());
}

TEST_CASE("NURBS: a curved net of uneven weights has consistent derivatives") {
  NurbsNet net = plane_net();
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> uniform(0.5, 2);
  for (std::size_t k = 0; k < net.points.size(); ++k) net.points[k] += 0.2 * uniform(engine);
  for (std::size_t k = 0; k < net.points.size() / 3; ++k) net.weights.push_back(uniform(engine));
  const auto surface = make_nurbs_patch(net);
  for (const auto& [u, v] : random_parameters(20)) check_derivatives(*surface, u, v);
}

TEST_CASE("NURBS: errors name the line") {
  const auto reason = [](std::string_view text) { return reason_of([&] { parse_nurbs_patch(text); }); };
  CHECK(reason("") == "line 1: no degree in the text");
  CHECK(reason("knots_u 0 0 1 1\n") == "line 1: the degrees must come first");
  CHECK(reason("# x\ndegree 1\n") == "line 2: two degrees are needed");
  CHECK(reason("degree 1 99\n") == "line 1: a degree must be a whole number from 1 to 15");
  CHECK(reason("degree 1 1\nknot 0 1\n") == "line 2: \"knot\" is none of degree, knots_u, knots_v, point");
  CHECK(reason("degree 1 1\nknots_u 0 0 one\n") == "line 2: \"one\" is not a finite number");
  CHECK(reason("degree 1 1\nknots_u 0 1\nknots_u 0.5\n").starts_with("line 3: knots must ascend"));
  CHECK(reason("degree 1 1\npoint 1 2\n").starts_with("line 2: a point has 3 coordinates"));
  CHECK(reason("degree 1 1\npoint 1 2 3 0\n") == "line 2: a weight must be positive");
  CHECK(reason("degree 1 1\nknots_u 0 0 1 1\nknots_v 0 0 1 1\npoint 0 0 0\n") ==
        "line 4 (the last): there are 1 control points, degrees and knots ask for 4");
  CHECK(reason("degree 1 1\nknots_u 0 0 0 0\nknots_v 0 0 1 1\n").find("knots_u span no interval") !=
        std::string::npos);
  CHECK(reason(quarter_cylinder).empty());
}

TEST_CASE(
    "height field: both interpolations pass through the heights, and reproduce polynomials of their degree") {
  constexpr std::size_t width = 7, height = 5;
  std::vector<float> plane, bilinear, quadratic;
  for (std::size_t j = 0; j < height; ++j)
    for (std::size_t i = 0; i < width; ++i) {
      plane.push_back(static_cast<float>(i) + 2 * static_cast<float>(j));
      bilinear.push_back(static_cast<float>(i * j));
      quadratic.push_back(static_cast<float>(i * i) - static_cast<float>(j * i));
    }
  for (const HeightInterpolation kind : {HeightInterpolation::bilinear, HeightInterpolation::bicubic}) {
    const HeightFieldParameters parameters = {kind, 2, 3, 0.5};
    const auto flat = make_height_field(plane, width, height, parameters);
    for (const double u : {0.0, 0.07, 0.5, 0.93, 1.0})
      for (const double v : {0.0, 0.11, 0.6, 1.0}) {
        const SurfaceJet jet = jet_at(*flat, u, v);
        CHECK(distance(jet.position, {2 * u, 3 * v, 3 * u + 4 * v}) < 1e-13);
        CHECK(distance(jet.du, {2, 0, 3}) < 1e-13);
        CHECK(distance(jet.dv, {0, 3, 4}) < 1e-13);
        CHECK(norm(jet.duu) + norm(jet.duv) + norm(jet.dvv) < 1e-11);
      }
    const auto rough = make_height_field(quadratic, width, height, parameters);
    for (std::size_t k = 0; k < width * height; ++k) {
      const double u = static_cast<double>(k % width) / (width - 1),
                   v = static_cast<double>(k / width) / (height - 1);
      CHECK(position_at(*rough, u, v).z == Approx(0.5 * quadratic[k]).margin(1e-13));
    }
    for (const auto& [u, v] : {std::pair{0.4, 0.35}, {0.55, 0.6}, {0.05, 0.9}})
      check_derivatives(*rough, u, v);
    CHECK(jet_at(*make_height_field(bilinear, width, height, parameters), 0.4, 0.35).position.z ==
          Approx(0.5 * 6 * 0.4 * 4 * 0.35));
  }
  // Inside, Catmull-Rom is exact for quadratics.
  const SurfaceJet inner = jet_at(*make_height_field(quadratic, width, height), 0.45, 0.4);
  CHECK(inner.position.z == Approx(36 * 0.45 * 0.45 - 24 * 0.45 * 0.4));
  CHECK(inner.duu.z == Approx(72));
  CHECK(inner.duv.z == Approx(-24));
}

TEST_CASE("height field: invalid arguments are refused") {
  const std::vector<float> heights(12, 1.0f);
  CHECK(reason_of([&] { make_height_field(heights, 5, 2); }) == "there are 12 heights, not 5 x 2");
  CHECK(reason_of([&] { make_height_field(heights, 12, 1); }) ==
        "a height field needs at least 2 x 2 heights, not 12 x 1");
  HeightFieldParameters parameters;
  parameters.extent_x = 0;
  CHECK_FALSE(reason_of([&] { make_height_field(heights, 4, 3, parameters); }).empty());
  std::vector<float> broken = heights;
  broken[7] = NAN;
  CHECK(reason_of([&] { make_height_field(broken, 4, 3); }) ==
        "the height in column 3 of row 1 is not finite");
}
