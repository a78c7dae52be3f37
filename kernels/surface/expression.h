// Densities given as text: an expression in u, v, x, y, z, compiled once, evaluated over arrays.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace meander {

// The values of the variables, one per point; spans of variables that the expression does not use may be
// empty.
struct ExpressionInputs {
  std::span<const double> u, v, x, y, z;
};

// Grammar (blanks are free; names are case-sensitive):
//
//   sum     = product { ("+" | "-") product }
//   product = sign { ("*" | "/") sign }
//   sign    = ("-" | "+") sign | power
//   power   = primary [ "^" sign ]                      right-associative: 2^3^2 = 2^9, -x^2 = -(x^2)
//   primary = number | variable | "pi" | "(" sum ")" | function "(" sum { "," sum } ")"
//   number   like 1, .5, 2.5e-3;   variable: u v x y z
//   function of one argument: sin cos tan exp log sqrt abs;   of two: min max pow
//
// The whole text may also be the name of a preset: see expression_presets().
class Expression {
 public:
  // Throws std::invalid_argument with the position (1-based column), what was expected, and for an unknown
  // name the nearest known one.
  explicit Expression(std::string_view text);

  // result[i] = value at point i; NaN and infinities come out as the arithmetic gives them. `count` points =
  // result.size(). About 1 to 30 ns an operation and point. Thread-safe.
  void evaluate(const ExpressionInputs& inputs, std::span<double> result) const;

  // Whether the variable ('u', 'v', 'x', 'y' or 'z') occurs.
  bool uses(char variable) const;
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
    std::uint32_t argument = 0;  // number of the constant or variable; the exponent of integer_power
  };

 private:
  std::string text_;
  std::vector<Instruction> code_;
  std::vector<double> constants_;
  std::size_t stack_size_ = 0;
};

// A named density of the survey and its figures; x, y run over the unit square of the plane.
struct ExpressionPreset {
  std::string_view name, text, meaning;
};
// x2y2, cos3sin3, cos10, blob, balzer.
std::span<const ExpressionPreset> expression_presets();

}  // namespace meander
