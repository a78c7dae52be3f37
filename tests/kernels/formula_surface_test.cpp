#include "kernels/surface/formula_surface.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/core/expression.h"
#include "kernels/core/status.h"
#include "kernels/surface/sample_surface.h"
#include "support/catch.h"

using namespace meander;
using Catch::Matchers::ContainsSubstring;

namespace {

struct Scattered {
  std::vector<double> u, v;
};

// In (0, 1)^2, away from the borders.
Scattered scattered(std::size_t count) {
  Scattered made;
  for (std::size_t i = 0; i < count; ++i) {
    made.u.push_back(0.05 + 0.9 * std::fmod(0.618034 * static_cast<double>(i), 1));
    made.v.push_back(0.05 + 0.9 * std::fmod(0.754878 * static_cast<double>(i), 1));
  }
  return made;
}

double farthest(const Vector3& a, const Vector3& b) { return norm(a - b); }

}  // namespace

TEST_CASE("formula surface: positions and derivatives match the built-in surface of that name") {
  constexpr std::array<std::pair<const char*, const char*>, 3> surfaces = {
      {{"torus", "(1 + 0.5*cos(2*pi*v))*cos(2*pi*u), (1 + 0.5*cos(2*pi*v))*sin(2*pi*u), 0.5*sin(2*pi*v)"},
       {"stretched-plane", "u^8, v, 0"},
       {"monkey-saddle", "2*u - 1, 2*v - 1, (2*u - 1)^3 - 3*(2*u - 1)*(2*v - 1)^2"}}};
  const Scattered at = scattered(300);
  for (const auto& [name, formula] : surfaces) {
    CAPTURE(name);
    const auto known = make_surface(name), made = make_formula_surface(formula);
    std::vector<SurfaceJet> a(at.u.size()), b(at.u.size());
    std::vector<SurfaceTangents> tangents(at.u.size());
    std::vector<Vector3> positions(at.u.size());
    known->jets(at.u, at.v, a);
    made->jets(at.u, at.v, b);
    made->tangents(at.u, at.v, tangents);
    made->positions(at.u, at.v, positions);
    double worst = 0;
    for (std::size_t i = 0; i < at.u.size(); ++i) {
      worst = std::max({worst, farthest(a[i].position, b[i].position), farthest(a[i].du, b[i].du),
                        farthest(a[i].dv, b[i].dv), farthest(a[i].duu, b[i].duu) / 50,
                        farthest(a[i].duv, b[i].duv) / 50, farthest(a[i].dvv, b[i].dvv) / 50});
      REQUIRE(farthest(positions[i], b[i].position) == 0);
      REQUIRE(farthest(tangents[i].position, b[i].position) == 0);
      REQUIRE(farthest(tangents[i].du, b[i].du) == 0);
    }
    CHECK(worst < 1e-13);
  }
}

TEST_CASE("expression: derivatives of every function match finite differences") {
  const Scattered at = scattered(40);
  constexpr double step = 1e-4;
  for (const char* text : {"sin(3*u*v)", "cos(u - v)", "tan(u*v)", "exp(u*u - v)", "log(u + 2*v)",
                           "sqrt(u*v + 1)", "abs(u - 2)", "min(u*u, 2)", "max(-1, u*v)", "pow(u + 1, v)",
                           "u^v", "2^u", "u^2.5", "u^5 * v^2", "(u - v) / (1 + u*v)", "-u^0"}) {
    CAPTURE(text);
    constexpr std::array<std::string_view, 2> names = {"u", "v"};
    const Expression expression(text, names);
    const auto value = [&](double u, double v) {
      const std::array<std::span<const double>, 2> inputs = {{{&u, 1}, {&v, 1}}};
      double result = 0;
      expression.evaluate(inputs, {&result, 1});
      return result;
    };
    for (std::size_t i = 0; i < at.u.size(); ++i) {
      const double u = at.u[i], v = at.v[i];
      const Jet2 by_u(u, 1, 0), by_v(v, 0, 1);
      const std::array<std::span<const Jet2>, 2> inputs = {{{&by_u, 1}, {&by_v, 1}}};
      Jet2 jet;
      expression.evaluate(inputs, {&jet, 1});
      REQUIRE(jet.f == value(u, v));
      const double up = value(u + step, v), down = value(u - step, v), right = value(u, v + step),
                   left = value(u, v - step);
      REQUIRE(jet.u == Approx((up - down) / (2 * step)).margin(2e-6));
      REQUIRE(jet.v == Approx((right - left) / (2 * step)).margin(2e-6));
      REQUIRE(jet.uu == Approx((up - 2 * jet.f + down) / (step * step)).margin(2e-5));
      REQUIRE(jet.vv == Approx((right - 2 * jet.f + left) / (step * step)).margin(2e-5));
      REQUIRE(jet.uv == Approx((value(u + step, v + step) - value(u + step, v - step) -
                                value(u - step, v + step) + value(u - step, v - step)) /
                               (4 * step * step))
                            .margin(2e-5));
    }
  }
}

TEST_CASE("formula surface: clamped parts are flat, and their root has its area") {
  SurfaceSampleParameters parameters;
  parameters.samples = 2000;
  const SurfaceSamples samples = sample_surface(
      *make_formula_surface("u, v, sqrt(max(0, 0.09 - (u - 0.5)^2 - (v - 0.5)^2))"), parameters);
  // Half a sphere of radius 0.3 on a plate with a hole of that radius.
  CHECK(samples.area == Approx(1 + std::numbers::pi * 0.09).epsilon(5e-3));
  std::size_t on_plate = 0;
  for (std::size_t i = 2; i < samples.points.size(); i += 3) on_plate += samples.points[i] == 0 ? 1 : 0;
  CHECK(static_cast<double>(on_plate) / 2000 ==
        Approx((1 - std::numbers::pi * 0.09) / (1 + std::numbers::pi * 0.09)).margin(0.01));
}

TEST_CASE("expression: second derivatives with a constant exponent") {
  constexpr std::array<std::string_view, 1> names = {"u"};
  const Jet2 at(0.5, 1, 0);
  const std::array<std::span<const Jet2>, 1> inputs = {{{&at, 1}}};
  Jet2 jet;
  Expression("2^((u - 0.5)^2)", names).evaluate(inputs, {&jet, 1});
  CHECK(jet.u == 0);
  CHECK(jet.uu == Approx(2 * std::numbers::ln2));
}

TEST_CASE("formula surface: name and content follow its text, ignoring blanks") {
  const auto a = make_formula_surface("u, v, u*v"), b = make_formula_surface("u,v, u * v"),
             c = make_formula_surface("u, v, u+v");
  CHECK(a->name() == "u,v,u*v");
  CHECK(a->content() == b->content());
  CHECK(a->content() != c->content());
  CHECK(is_surface_formula("u, v, min(u, v)"));
  CHECK_FALSE(is_surface_formula("min(u, v)"));
  CHECK_FALSE(is_surface_formula("torus"));
}

TEST_CASE("formula surface: invalid texts are refused, and non-finite points are failures") {
  CHECK_THROWS_WITH(make_formula_surface("u, v"), ContainsSubstring("has 2 formulas"));
  CHECK_THROWS_WITH(make_formula_surface("u, v, x"), ContainsSubstring("unknown name \"x\""));
  CHECK_THROWS_AS(make_formula_surface(",,"), std::invalid_argument);
  const std::vector<double> u = {0.5, 0}, v = {0.5, 0.25};
  std::vector<Vector3> positions(2);
  std::vector<SurfaceTangents> tangents(2);
  const auto pole = make_formula_surface("u, v, 1/u");
  CHECK_THROWS_WITH(pole->positions(u, v, positions),
                    ContainsSubstring("the surface `u,v,1/u` has no position at u = 0, v = 0.25"));
  CHECK_THROWS_AS(pole->tangents(u, v, tangents), ItemError);
  CHECK_NOTHROW(make_formula_surface("u, v, sqrt(u)")->tangents(u, v, tangents));
  // 0 / 0: an area that would be lost without a word.
  CHECK_THROWS_WITH(
      make_formula_surface("u, v, (u - 0.5)^v")
          ->tangents(std::vector<double>{0.25}, std::vector<double>{2.0}, std::span(tangents).first(1)),
      ContainsSubstring("has no derivative at u = 0.25"));
}
