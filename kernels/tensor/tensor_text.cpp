#include "kernels/tensor/tensor_text.h"

#include <array>
#include <charconv>
#include <optional>

#include "kernels/density/density_text.h"

namespace meander {

namespace {

constexpr std::string_view vertex = "attribute:", face = "face-attribute:", constant = "constant:",
                           file = "file:";

bool parse_six(std::string_view text, std::array<double, 6>& numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string_view number = text.substr(0, text.find(','));
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), numbers[i]);
    if (error != std::errc{} || end != number.data() + number.size()) return false;
    if (number.size() == text.size()) return i + 1 == numbers.size();
    text.remove_prefix(number.size() + 1);
  }
  return false;
}

// The shortest decimals that read back.
std::string six_text(const std::array<double, 6>& numbers) {
  std::string text;
  for (const double number : numbers) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    text += (text.empty() ? "" : ",") + std::string(digits.data(), end.ptr);
  }
  return text;
}

}  // namespace

std::string take_tensor(std::string_view text, TensorParameters& tensor) {
  const auto name = [&](TensorKind kind, std::string_view prefix) {
    tensor.kind = kind;
    tensor.attribute = text.substr(prefix.size());
    return std::string();
  };
  if (text == "curvature" || text == "isotropic") {
    tensor.kind = text == "curvature" ? TensorKind::curvature : TensorKind::isotropic;
    return "";
  }
  if (text.starts_with(vertex)) return name(TensorKind::vertex_attribute, vertex);
  if (text.starts_with(face)) return name(TensorKind::face_attribute, face);
  if (text.starts_with(file)) return name(TensorKind::table, file);
  if (text.starts_with(constant)) {
    std::array<double, 6> numbers{};
    if (!parse_six(text.substr(constant.size()), numbers))
      return "`" + std::string(text) + "` needs six numbers XX,XY,XZ,YY,YZ,ZZ";
    tensor.kind = TensorKind::constant;
    tensor.constant = numbers;
    return "";
  }
  if (const std::optional<FormulaText> formula = formula_in(text)) {
    tensor.kind = formula->unit_box ? TensorKind::unit_formula : TensorKind::formula;
    tensor.formula = formula->text;
    return "";
  }
  return "`" + std::string(text) + "` is not one of " + std::string(tensor_forms);
}

std::string tensor_text(const TensorParameters& tensor) {
  switch (tensor.kind) {
    case TensorKind::curvature:
      return "curvature";
    case TensorKind::isotropic:
      return "isotropic";
    case TensorKind::vertex_attribute:
      return std::string(vertex) + tensor.attribute;
    case TensorKind::face_attribute:
      return std::string(face) + tensor.attribute;
    case TensorKind::constant:
      return std::string(constant) + six_text(tensor.constant);
    case TensorKind::table:
      return std::string(file) + tensor.attribute;
    case TensorKind::formula:
    case TensorKind::unit_formula:
      return formula_text(tensor.kind == TensorKind::unit_formula, tensor.formula);
  }
  return "";
}

}  // namespace meander
