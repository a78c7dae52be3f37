// Formulas given as text, compiled once, evaluated over arrays.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/jets.h"

namespace meander {

// The names that a formula may use besides functions and pi: letters and underscores.
using ExpressionVariables = std::span<const std::string_view>;
// The names of a parametric surface: its parameters and the point in space.
inline constexpr std::array<std::string_view, 5> surface_variables = {"u", "v", "x", "y", "z"};

// The values of each variable, one a point, in the order of the names; empty spans are allowed for variables
// that the expression does not use.
template <class Scalar>
using ExpressionInputs = std::span<const std::span<const Scalar>>;

// Grammar (blanks are free; names are case-sensitive):
//
//   sum     = product { ("+" | "-") product }
//   product = sign { ("*" | "/") sign }
//   sign    = ("-" | "+") sign | power
//   power   = primary [ "^" sign ]                      right-associative: 2^3^2 = 2^9, -x^2 = -(x^2)
//   primary = number | variable | "pi" | "(" sum ")" | function "(" sum { "," sum } ")"
//   number   like 1, .5, 2.5e-3
//   function of one argument: sin cos tan exp log sqrt abs;   of two: min max pow
//
// The whole text may also be the name of a preset: see expression_presets().
class Expression {
 public:
  // Throws std::invalid_argument, which gives the position (a column from 1), what was expected, and for an
  // unknown name the nearest known one.
  explicit Expression(std::string_view text, ExpressionVariables variables = surface_variables);

  // result[i] = value at point i, for result.size() points; NaN and infinities come out as the arithmetic
  // gives them. Throws std::invalid_argument where a variable in use has fewer values. O(operations x
  // points). Thread-safe.
  void evaluate(ExpressionInputs<double> inputs, std::span<double> result) const;
  // Evaluates with derivatives. Those of abs, min and max are of the branch that is taken; powers with a
  // variable exponent have derivatives where their base is positive, and NaN elsewhere.
  void evaluate(ExpressionInputs<Jet1> inputs, std::span<Jet1> result) const;
  void evaluate(ExpressionInputs<Jet2> inputs, std::span<Jet2> result) const;

  // Whether the variable occurs.
  bool uses(std::string_view variable) const;
  // The same by the number of the variable.
  bool uses(std::size_t variable) const { return used_[variable]; }

  // The degree of the expression as a polynomial in numbers of which each variable is a polynomial of the
  // given degree (in the order of the names; 0: a constant). It is an upper bound: x - x has the degree of x.
  // Returns not_polynomial where the text does not show one.
  static constexpr std::uint32_t not_polynomial = 1000000;
  std::uint32_t degree(std::span<const std::uint32_t> of_variables) const;
  const std::string& text() const { return text_; }

  // Flat postfix code.
  enum class Operation : std::uint8_t {
    constant,
    variable,
    negate,
    add,
    subtract,
    multiply,
    divide,
    power,
    integer_power,
    sin,
    cos,
    tan,
    exp,
    log,
    sqrt,
    abs,
    min,
    max
  };
  struct Instruction {
    Operation operation;
    // The number of the constant or variable, or the exponent of integer_power.
    std::uint32_t argument = 0;
  };

 private:
  template <class Scalar>
  void evaluate_blocks(ExpressionInputs<Scalar> inputs, std::span<Scalar> result) const;

  std::string text_;
  std::vector<std::string> variables_;
  std::vector<bool> used_;  // by variable
  std::vector<Instruction> code_;
  std::vector<double> constants_;
  std::size_t stack_size_ = 0;
};

// Splits a list of formulas at the commas outside of parentheses: "u, v, max(u, v)" has three.
std::vector<std::string_view> split_formulas(std::string_view text);

// A named density of Quinn et al., "Fast low-discrepancy sampling of parametric surfaces and meshes"; x, y
// run over the unit square of the plane.
struct ExpressionPreset {
  std::string_view name, text, meaning;
};
// Lists x2y2, cos3sin3, cos10, blob and balzer.
std::span<const ExpressionPreset> expression_presets();

}  // namespace meander
