// A recursive-descent compiler to postfix code, and its evaluation in blocks.
#include "kernels/surface/expression.h"

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

constexpr std::string_view variables = "uvxyz";
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
  Compiler(std::string_view text, std::vector<Instruction>& code, std::vector<double>& constants)
      : text_(text), code_(code), constants_(constants) {}

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

  void sum() {
    product();
    while (true) {
      if (take('+')) {
        product();
        emit(Operation::add, 0, -1);
      } else if (take('-')) {
        product();
        emit(Operation::subtract, 0, -1);
      } else {
        return;
      }
    }
  }

  void product() {
    sign();
    while (true) {
      if (take('*')) {
        sign();
        emit(Operation::multiply, 0, -1);
      } else if (take('/')) {
        sign();
        emit(Operation::divide, 0, -1);
      } else {
        return;
      }
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
      fail(std::string("expected a number, a name or ( instead of \"") + c + "\"");
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
    if (const std::size_t number = word.size() == 1 ? variables.find(word[0]) : std::string_view::npos;
        number != std::string_view::npos)
      return emit(Operation::variable, static_cast<std::uint32_t>(number), 1);
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
    for (std::size_t k = 0; k < variables.size(); ++k) known.push_back(variables.substr(k, 1));
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

// Number of operands that an operation takes from the stack.
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

void apply(const Instruction& instruction, double* a, std::size_t count) {
  const auto map = [&](const auto& f) {
    for (std::size_t i = 0; i < count; ++i) a[i] = f(a[i]);
  };
  switch (instruction.operation) {
    case Operation::negate:
      return map([](double x) { return -x; });
    case Operation::integer_power:
      return map([n = instruction.argument](double x) { return raised(x, n); });
    case Operation::sin:
      return map([](double x) { return direction_of(x).sine; });
    case Operation::cos:
      return map([](double x) { return direction_of(x).cosine; });
    case Operation::tan:
      return map([](double x) {
        const auto [cosine, sine] = direction_of(x);
        return sine / cosine;
      });
    case Operation::exp:
      return map([](double x) { return portable::exp(x); });
    case Operation::log:
      return map([](double x) { return portable::log(x); });
    case Operation::sqrt:
      return map([](double x) { return std::sqrt(x); });
    default:
      return map([](double x) { return std::abs(x); });
  }
}

void combine(Operation operation, double* a, const double* b, std::size_t count) {
  const auto map = [&](const auto& f) {
    for (std::size_t i = 0; i < count; ++i) a[i] = f(a[i], b[i]);
  };
  switch (operation) {
    case Operation::add:
      return map([](double x, double y) { return x + y; });
    case Operation::subtract:
      return map([](double x, double y) { return x - y; });
    case Operation::multiply:
      return map([](double x, double y) { return x * y; });
    case Operation::divide:
      return map([](double x, double y) { return x / y; });
    case Operation::power:
      return map([](double x, double y) { return portable::pow(x, y); });
    case Operation::min:
      return map([](double x, double y) { return y < x ? y : x; });
    default:
      return map([](double x, double y) { return x < y ? y : x; });
  }
}

}  // namespace

std::span<const ExpressionPreset> expression_presets() { return presets; }

Expression::Expression(std::string_view text) : text_(text) {
  for (const ExpressionPreset& preset : presets)
    if (preset.name == text) text_ = preset.text;
  Compiler compiler(text_, code_, constants_);
  compiler.compile();
  stack_size_ = compiler.stack_size();
}

bool Expression::uses(char variable) const {
  const std::size_t number = variables.find(variable);
  return std::any_of(code_.begin(), code_.end(), [&](const Instruction& instruction) {
    return instruction.operation == Operation::variable && instruction.argument == number;
  });
}

void Expression::evaluate(const ExpressionInputs& inputs, std::span<double> result) const {
  const std::array<std::span<const double>, 5> input = {inputs.u, inputs.v, inputs.x, inputs.y, inputs.z};
  for (const char c : variables)
    if (uses(c) && input[variables.find(c)].size() < result.size())
      throw std::invalid_argument(std::string("the expression needs the variable ") + c);
  std::vector<double> stack(stack_size_ * block_size);
  for (std::size_t begin = 0; begin < result.size(); begin += block_size) {
    const std::size_t count = std::min(block_size, result.size() - begin);
    std::size_t depth = 0;
    for (const Instruction& instruction : code_) {
      const int arity = arity_of(instruction.operation);
      if (arity == 0) ++depth;
      double* top = stack.data() + (depth - 1) * block_size;
      if (instruction.operation == Operation::constant)
        std::fill_n(top, count, constants_[instruction.argument]);
      else if (instruction.operation == Operation::variable)
        std::copy_n(input[instruction.argument].data() + begin, count, top);
      else if (arity == 1)
        apply(instruction, top, count);
      else
        combine(instruction.operation, stack.data() + (--depth - 1) * block_size, top, count);
    }
    std::copy_n(stack.data(), count, result.data() + begin);
  }
}

}  // namespace meander
