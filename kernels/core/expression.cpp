// A recursive-descent compiler to postfix code, and its evaluation in blocks.
#include "kernels/core/expression.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "kernels/core/portable_angles.h"
#include "kernels/core/portable_functions.h"
#include "kernels/core/spelling.h"

namespace meander {

namespace {

using Operation = Expression::Operation;
using Instruction = Expression::Instruction;

constexpr std::size_t block_size = 256;
constexpr int max_nesting = 200;
constexpr double max_unrolled_exponent = 16;

struct Function {
  std::string_view name;
  Operation operation;
  int arguments;
};
constexpr std::array<Function, 10> functions = {{{"sin", Operation::sin, 1},
                                                 {"cos", Operation::cos, 1},
                                                 {"tan", Operation::tan, 1},
                                                 {"exp", Operation::exp, 1},
                                                 {"log", Operation::log, 1},
                                                 {"sqrt", Operation::sqrt, 1},
                                                 {"abs", Operation::abs, 1},
                                                 {"min", Operation::min, 2},
                                                 {"max", Operation::max, 2},
                                                 {"pow", Operation::power, 2}}};

constexpr std::array<ExpressionPreset, 5> presets = {
    {{"x2y2", "x^2 * y^2", "rises from the corner at the origin"},
     {"cos3sin3", "cos(3*x) * sin(3*y) * cos(x*y) + 1", "smooth waves"},
     {"cos10", "cos(10*x*y) + 1", "hyperbolic waves"},
     {"blob", "exp(-20*((x - 0.5)^2 + (y - 0.5)^2))", "a Gaussian around the middle of the unit square"},
     {"balzer", "exp(-20*((2*x - 1)^2 + (2*y - 1)^2)) + 0.2*sin(pi*(2*x - 1))^2*sin(pi*(2*y - 1))^2",
      "a Gaussian and four bumps (Balzer, Schloemer and Deussen 2009)"}}};

// One pass over the text; the code comes out in postfix order.
class Compiler {
 public:
  Compiler(std::string_view text, ExpressionVariables variables, std::vector<Instruction>& code,
           std::vector<double>& constants)
      : text_(text), variables_(variables), code_(code), constants_(constants) {}

  void compile() {
    sum();
    if (at_ < text_.size()) fail(text_[at_] == ')' ? "a ) without its (" : "expected an operator here");
  }

  std::size_t stack_size() const { return deepest_; }

 private:
  [[noreturn]] void fail(const std::string& problem) const { fail_at(at_, problem); }
  [[noreturn]] void fail_at(std::size_t at, const std::string& problem) const {
    throw std::invalid_argument("the expression \"" + std::string(text_) + "\", column " +
                                std::to_string(at + 1) + ": " + problem);
  }

  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool take(char symbol) {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != symbol) return false;
    ++at_;
    skip_blanks();
    return true;
  }
  void expect(char symbol, const char* where) {
    if (!take(symbol)) fail(std::string("expected ") + symbol + " " + where);
  }

  void emit(Operation operation, std::uint32_t argument, int change) {
    code_.push_back({operation, argument});
    depth_ = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(depth_) + change);
    deepest_ = std::max(deepest_, depth_);
  }
  void emit_constant(double value) {
    constants_.push_back(value);
    emit(Operation::constant, static_cast<std::uint32_t>(constants_.size() - 1), 1);
  }

  void sum() { operands(&Compiler::product, '+', Operation::add, '-', Operation::subtract); }
  void product() { operands(&Compiler::sign, '*', Operation::multiply, '/', Operation::divide); }

  // Operands with either of two operators between them, left-associative.
  void operands(void (Compiler::*operand)(), char one, Operation first, char other, Operation second) {
    (this->*operand)();
    while (true) {
      const bool is_first = take(one);
      if (!is_first && !take(other)) return;
      (this->*operand)();
      emit(is_first ? first : second, 0, -1);
    }
  }

  void sign() {
    if (++nesting_ > max_nesting) fail("nested too deeply");
    if (take('-')) {
      sign();
      emit(Operation::negate, 0, 0);
    } else if (take('+')) {
      sign();
    } else {
      power();
    }
    --nesting_;
  }

  void power() {
    primary();
    if (!take('^')) return;
    const std::size_t start = code_.size();
    sign();
    // A small whole exponent is a few multiplications.
    if (code_.size() == start + 1 && code_.back().operation == Operation::constant) {
      const double exponent = constants_[code_.back().argument];
      if (exponent >= 0 && exponent <= max_unrolled_exponent && exponent == std::floor(exponent)) {
        code_.pop_back();
        --depth_;
        emit(Operation::integer_power, static_cast<std::uint32_t>(exponent), 0);
        return;
      }
    }
    emit(Operation::power, 0, -1);
  }

  void primary() {
    skip_blanks();
    if (at_ >= text_.size()) fail("expected a number, a name or ( but the text ends");
    const char c = text_[at_];
    if (take('(')) {
      sum();
      expect(')', "to close the parenthesis");
    } else if ((c >= '0' && c <= '9') || c == '.') {
      number();
    } else if (is_letter(c)) {
      name();
    } else {
      fail("expected a number, a name or ( instead of \"" + std::string(1, c) + "\"");
    }
  }

  void number() {
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc()) fail("not a number");
    at_ = static_cast<std::size_t>(end - text_.data());
    if (at_ < text_.size() && is_letter(text_[at_])) fail("expected an operator between a number and a name");
    emit_constant(value);
  }

  static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

  void name() {
    const std::size_t start = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || (text_[at_] >= '0' && text_[at_] <= '9'))) ++at_;
    const std::string_view word = text_.substr(start, at_ - start);
    if (word == "pi") return emit_constant(std::numbers::pi);
    if (const auto at = std::ranges::find(variables_, word); at != variables_.end())
      return emit(Operation::variable, static_cast<std::uint32_t>(at - variables_.begin()), 1);
    for (const Function& function : functions) {
      if (function.name != word) continue;
      expect('(', ("after " + std::string(word)).c_str());
      for (int k = 0; k < function.arguments; ++k) {
        if (k > 0) expect(',', ("and a second argument of " + std::string(word)).c_str());
        sum();
      }
      if (take(',')) fail_at(start, std::string(word) + " has too many arguments");
      expect(')', ("after the arguments of " + std::string(word)).c_str());
      return emit(function.operation, 0, 1 - function.arguments);
    }
    fail_at(start, "unknown name \"" + std::string(word) + "\"" + suggestion(word));
  }

  std::string suggestion(std::string_view word) const {
    std::vector<std::string_view> known = {"pi"};
    known.insert(known.end(), variables_.begin(), variables_.end());
    for (const Function& function : functions) known.push_back(function.name);
    if (word.size() == text_.size())
      for (const ExpressionPreset& preset : presets) known.push_back(preset.name);
    const std::string near = nearest(word, known);
    if (!near.empty()) return "; did you mean \"" + near + "\"?";
    std::string list;
    for (const std::string_view name : known)
      list += (list.empty() ? "; known are " : ", ") + std::string(name);
    return list;
  }

  std::string_view text_;
  ExpressionVariables variables_;
  std::vector<Instruction>& code_;
  std::vector<double>& constants_;
  std::size_t at_ = 0, depth_ = 0, deepest_ = 0;
  int nesting_ = 0;
};

double raised(double base, std::uint32_t exponent) {
  double result = 1;
  for (; exponent > 0; exponent >>= 1, base *= base)
    if (exponent & 1u) result *= base;
  return result;
}

// The number of operands that an operation takes from the stack.
int arity_of(Operation operation) {
  switch (operation) {
    case Operation::constant:
    case Operation::variable:
      return 0;
    case Operation::add:
    case Operation::subtract:
    case Operation::multiply:
    case Operation::divide:
    case Operation::power:
    case Operation::min:
    case Operation::max:
      return 2;
    default:
      return 1;
  }
}

double absolute(double x) { return std::abs(x); }
template <class Jet>
Jet absolute(const Jet& x) {
  return value_of(x) < 0 ? -x : x;
}

// Replaces the value by that of the plain operation, which products with a reciprocal may miss by a last bit.
double with_value(double, double value) { return value; }
template <class Jet>
Jet with_value(Jet x, double value) {
  x.f = value;
  return x;
}

template <class Scalar>
Scalar whole_power(const Scalar& x, std::uint32_t n) {
  const double base = value_of(x), exponent = n;
  return chain(x, raised(base, n), n > 0 ? exponent * raised(base, n - 1) : 0.0,
               n > 1 ? exponent * (exponent - 1) * raised(base, n - 2) : 0.0);
}

double any_power(double x, double y) { return portable::pow(x, y); }
bool is_constant(const Jet1& x) { return x.u == 0 && x.v == 0; }
bool is_constant(const Jet2& x) { return x.u == 0 && x.v == 0 && x.uu == 0 && x.uv == 0 && x.vv == 0; }

template <class Jet>
Jet any_power(const Jet& x, const Jet& y) {
  const double value = portable::pow(x.f, y.f);
  if (is_constant(y))
    return chain(x, value, y.f * portable::pow(x.f, y.f - 1), y.f * (y.f - 1) * portable::pow(x.f, y.f - 2));
  return with_value(exponential(y * logarithm(x)), value);
}

template <class Scalar>
void apply(const Instruction& instruction, Scalar* a, std::size_t count) {
  const auto map = [&](const auto& f) {
    for (std::size_t i = 0; i < count; ++i) a[i] = f(a[i]);
  };
  switch (instruction.operation) {
    case Operation::negate:
      return map([](const Scalar& x) { return -x; });
    case Operation::integer_power:
      return map([n = instruction.argument](const Scalar& x) { return whole_power(x, n); });
    case Operation::sin:
      return map([](const Scalar& x) { return cosine_sine(x).sine; });
    case Operation::cos:
      return map([](const Scalar& x) { return cosine_sine(x).cosine; });
    case Operation::tan:
      return map([](const Scalar& x) {
        const auto [cosine, sine] = cosine_sine(x);
        return with_value(sine / cosine, value_of(sine) / value_of(cosine));
      });
    case Operation::exp:
      return map([](const Scalar& x) { return exponential(x); });
    case Operation::log:
      return map([](const Scalar& x) { return logarithm(x); });
    case Operation::sqrt:
      return map([](const Scalar& x) { return square_root(x); });
    default:
      return map([](const Scalar& x) { return absolute(x); });
  }
}

template <class Scalar>
void combine(Operation operation, Scalar* a, const Scalar* b, std::size_t count) {
  const auto map = [&](const auto& f) {
    for (std::size_t i = 0; i < count; ++i) a[i] = f(a[i], b[i]);
  };
  switch (operation) {
    case Operation::add:
      return map([](const Scalar& x, const Scalar& y) { return x + y; });
    case Operation::subtract:
      return map([](const Scalar& x, const Scalar& y) { return x - y; });
    case Operation::multiply:
      return map([](const Scalar& x, const Scalar& y) { return x * y; });
    case Operation::divide:
      return map(
          [](const Scalar& x, const Scalar& y) { return with_value(x / y, value_of(x) / value_of(y)); });
    case Operation::power:
      return map([](const Scalar& x, const Scalar& y) { return any_power(x, y); });
    case Operation::min:
      return map([](const Scalar& x, const Scalar& y) { return value_of(y) < value_of(x) ? y : x; });
    default:
      return map([](const Scalar& x, const Scalar& y) { return value_of(x) < value_of(y) ? y : x; });
  }
}

}  // namespace

std::span<const ExpressionPreset> expression_presets() { return presets; }

std::vector<std::string_view> split_formulas(std::string_view text) {
  std::vector<std::string_view> parts;
  int nesting = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(') ++nesting;
    if (text[i] == ')') --nesting;
    if (text[i] != ',' || nesting != 0) continue;
    parts.push_back(text.substr(begin, i - begin));
    begin = i + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

Expression::Expression(std::string_view text, ExpressionVariables variables)
    : text_(text), variables_(variables.begin(), variables.end()) {
  for (const ExpressionPreset& preset : presets)
    if (preset.name == text) text_ = preset.text;
  Compiler compiler(text_, variables, code_, constants_);
  compiler.compile();
  stack_size_ = compiler.stack_size();
  used_.assign(variables_.size(), false);
  for (const Instruction& instruction : code_)
    if (instruction.operation == Operation::variable) used_[instruction.argument] = true;
}

bool Expression::uses(std::string_view variable) const {
  const auto at = std::ranges::find(variables_, variable);
  return at != variables_.end() && used_[static_cast<std::size_t>(at - variables_.begin())];
}

std::uint32_t Expression::degree(std::span<const std::uint32_t> of_variables) const {
  const auto capped = [](std::uint64_t degree) {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(degree, not_polynomial));
  };
  std::vector<std::uint32_t> stack;
  for (const Instruction& instruction : code_) {
    std::uint32_t second = 0;
    if (arity_of(instruction.operation) == 2) {
      second = stack.back();
      stack.pop_back();
    }
    if (arity_of(instruction.operation) == 0) stack.push_back(0);
    std::uint32_t& degree = stack.back();
    switch (instruction.operation) {
      case Operation::constant:
        break;
      case Operation::variable:
        degree = of_variables[instruction.argument];
        break;
      case Operation::negate:
        break;
      case Operation::add:
      case Operation::subtract:
        degree = std::max(degree, second);
        break;
      case Operation::multiply:
        degree = capped(std::uint64_t{degree} + second);
        break;
      case Operation::divide:
        if (second > 0) degree = not_polynomial;
        break;
      case Operation::integer_power:
        degree = capped(std::uint64_t{degree} * instruction.argument);
        break;
      default:
        if (degree > 0 || second > 0) degree = not_polynomial;
    }
  }
  return stack.back();
}

template <class Scalar>
void Expression::evaluate_blocks(ExpressionInputs<Scalar> inputs, std::span<Scalar> result) const {
  for (std::size_t k = 0; k < variables_.size(); ++k)
    if (used_[k] && (k >= inputs.size() || inputs[k].size() < result.size()))
      throw std::invalid_argument("the expression needs the variable " + variables_[k]);
  const std::size_t block = std::min(block_size, result.size());
  std::vector<Scalar> stack(stack_size_ * block);
  for (std::size_t begin = 0; begin < result.size(); begin += block_size) {
    const std::size_t count = std::min(block_size, result.size() - begin);
    std::size_t depth = 0;
    for (const Instruction& instruction : code_) {
      const int arity = arity_of(instruction.operation);
      if (arity == 0) ++depth;
      Scalar* top = stack.data() + (depth - 1) * block;
      if (instruction.operation == Operation::constant)
        std::fill_n(top, count, Scalar(constants_[instruction.argument]));
      else if (instruction.operation == Operation::variable)
        std::copy_n(inputs[instruction.argument].data() + begin, count, top);
      else if (arity == 1)
        apply(instruction, top, count);
      else
        combine(instruction.operation, stack.data() + (--depth - 1) * block, top, count);
    }
    std::copy_n(stack.data(), count, result.data() + begin);
  }
}

void Expression::evaluate(ExpressionInputs<double> inputs, std::span<double> result) const {
  evaluate_blocks(inputs, result);
}
void Expression::evaluate(ExpressionInputs<Jet1> inputs, std::span<Jet1> result) const {
  evaluate_blocks(inputs, result);
}
void Expression::evaluate(ExpressionInputs<Jet2> inputs, std::span<Jet2> result) const {
  evaluate_blocks(inputs, result);
}

}  // namespace meander
