#include "kernels/core/expression.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.h"

using namespace meander;

namespace {

double value(std::string_view text, double x = 0, double y = 0) {
  double result = 0;
  const double u = 0.25, v = 0.75, z = -2;
  const std::array<std::span<const double>, 5> inputs = {{{&u, 1}, {&v, 1}, {&x, 1}, {&y, 1}, {&z, 1}}};
  Expression(text).evaluate(inputs, {&result, 1});
  return result;
}

std::string error(std::string_view text) {
  try {
    const Expression expression(text);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return {};
}

bool says(std::string_view text, std::string_view part) {
  return error(text).find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("expression: precedence, signs and functions") {
  CHECK(value("1 + 2 * 3") == 7);
  CHECK(value("(1 + 2) * 3") == 9);
  CHECK(value("7 - 2 - 1") == 4);
  CHECK(value("8 / 4 / 2") == 1);
  CHECK(value("2^3^2") == 512);
  CHECK(value("-2^2") == -4);
  CHECK(value("2^-1") == 0.5);
  CHECK(value("2^0.5") == Approx(std::sqrt(2.0)));
  CHECK(value("--3 + +1") == 4);
  CHECK(value("2*-3") == -6);
  CHECK(value(".5e1 + 1.5E-1") == Approx(5.15));
  CHECK(value("x^3 * y^0", -2, 0) == -8);
  CHECK(value("x^17", 1.1) == Approx(std::pow(1.1, 17)));
  CHECK(value("u + 10*v + 100*z") == 0.25 + 7.5 - 200);
  CHECK(value("pi") == std::numbers::pi);
  CHECK(value("sin(x) + 2*cos(y)", 0.3, -4.1) == Approx(std::sin(0.3) + 2 * std::cos(4.1)).epsilon(1e-14));
  CHECK(value("sin(x)", 1e6) == Approx(std::sin(1e6)));
  CHECK(value("tan(x)", 0.7) == Approx(std::tan(0.7)).epsilon(1e-14));
  CHECK(value("exp(x) - log(y)", 0.7, 3) == Approx(std::exp(0.7) - std::log(3.0)));
  CHECK(value("sqrt(abs(x))", -16) == 4);
  CHECK(value("min(x, y) + 10*max(x, y)", 3, 5) == 53);
  CHECK(value("pow(x, y)", 2, -2) == 0.25);
  CHECK(value("max(0, sin(pi*u))") == Approx(std::sqrt(0.5)));
  CHECK(std::isinf(value("1/x", 0)));
  CHECK(std::isnan(value("log(x)", -1)));
}

TEST_CASE("expression: arrays of every length, and only the variables that occur") {
  for (const std::size_t n : {0u, 1u, 255u, 256u, 257u, 1000u}) {
    std::vector<double> x(n), result(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = static_cast<double>(i);
    const std::array<std::span<const double>, 5> inputs = {{{}, {}, x, {}, {}}};
    Expression("(x + 1) * (x - 1) / (1 + min(x^2, 4))").evaluate(inputs, result);
    for (std::size_t i = 0; i < n; ++i)
      CHECK(result[i] == (x[i] + 1) * (x[i] - 1) / (1 + std::min(x[i] * x[i], 4.0)));
  }
  const Expression expression("x*y + exp(1)");
  CHECK(expression.uses("x"));
  CHECK(expression.uses("y"));
  CHECK_FALSE(expression.uses("u"));
  CHECK_FALSE(expression.uses("q"));
  double result = 0;
  CHECK_THROWS_AS(expression.evaluate({}, {&result, 1}), std::invalid_argument);
}

TEST_CASE("expression: the presets are those of the survey") {
  REQUIRE(expression_presets().size() == 5);
  const double x = 0.3, y = 0.8, pi = std::numbers::pi;
  CHECK(value("x2y2", x, y) == Approx(x * x * y * y));
  CHECK(value("cos3sin3", x, y) == Approx(std::cos(3 * x) * std::sin(3 * y) * std::cos(x * y) + 1));
  CHECK(value("cos10", x, y) == Approx(std::cos(10 * x * y) + 1));
  CHECK(value("blob", 0.5, 0.5) == 1);
  CHECK(value("blob", x, y) == Approx(std::exp(-20 * (0.04 + 0.09))));
  const double cx = 2 * x - 1, cy = 2 * y - 1;
  CHECK(value("balzer", x, y) == Approx(std::exp(-20 * (cx * cx + cy * cy)) +
                                        0.2 * std::pow(std::sin(pi * cx) * std::sin(pi * cy), 2)));
  CHECK(Expression("x2y2").text() == "x^2 * y^2");
}

TEST_CASE("expression: errors say where, what, and what was meant") {
  CHECK(error("1 + * 2") ==
        "the expression \"1 + * 2\", column 5: expected a number, a name or ( instead of \"*\"");
  CHECK(says("", "column 1: expected a number, a name or ( but the text ends"));
  CHECK(says("x +", "column 4: expected a number"));
  CHECK(says("2 x", "column 3: expected an operator here"));
  CHECK(says("2x", "column 2: expected an operator between a number and a name"));
  CHECK(says("(x + 1", "column 7: expected ) to close the parenthesis"));
  CHECK(says("x)", "column 2: a ) without its ("));
  CHECK(says("1 + sine(x)", "column 5: unknown name \"sine\"; did you mean \"sin\"?"));
  CHECK(says("sqr(x)", "did you mean \"sqrt\"?"));
  CHECK(says("cos3sin", "did you mean \"cos3sin3\"?"));
  CHECK(says("x * temperature", "unknown name \"temperature\"; known are pi, u, v, x, y, z, sin"));
  CHECK(says("sin x", "column 5: expected ( after sin"));
  CHECK(says("min(x)", "column 6: expected , and a second argument of min"));
  CHECK(says("exp(x, y)", "column 1: exp has too many arguments"));
  CHECK(says("1..2", "column 3"));
  CHECK(says(std::string(1000, '(') + "x", "nested too deeply"));
  CHECK(says(std::string(5000, '-') + "x", "nested too deeply"));
  CHECK(error("x").empty());
}
