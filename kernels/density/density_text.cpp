#include "kernels/density/density_text.h"

namespace meander {

namespace {

constexpr std::string_view formula_prefix = "formula:", unit_formula_prefix = "unit-formula:";
constexpr std::string_view vertex_prefix = "attribute:", face_prefix = "face-attribute:";

}  // namespace

std::optional<FormulaText> formula_in(std::string_view text) {
  for (const std::string_view prefix : {formula_prefix, unit_formula_prefix})
    if (text.starts_with(prefix))
      return FormulaText{prefix == unit_formula_prefix, std::string(text.substr(prefix.size()))};
  return std::nullopt;
}

std::string formula_text(bool unit_box, std::string_view formula) {
  return std::string(unit_box ? unit_formula_prefix : formula_prefix) + std::string(formula);
}

std::string take_density(std::string_view text, DensityParameters& density) {
  if (text.starts_with(vertex_prefix) || text.starts_with(face_prefix)) {
    density.kind =
        text.starts_with(vertex_prefix) ? DensityKind::vertex_attribute : DensityKind::face_attribute;
    density.attribute = text.substr(text.find(':') + 1);
    return "";
  }
  if (const std::optional<FormulaText> formula = formula_in(text)) {
    density.kind = formula->unit_box ? DensityKind::unit_formula : DensityKind::formula;
    density.formula = formula->text;
    return "";
  }
  if (take_word(density_words, text, density.kind)) return "";
  return "`" + std::string(text) + "` is not one of " + joined_texts(all_words(density_words), "|") +
         "|attribute:NAME|face-attribute:NAME|formula:TEXT|unit-formula:TEXT";
}

std::string density_text(const DensityParameters& density) {
  if (density.kind == DensityKind::vertex_attribute) return std::string(vertex_prefix) + density.attribute;
  if (density.kind == DensityKind::face_attribute) return std::string(face_prefix) + density.attribute;
  if (density.kind == DensityKind::formula || density.kind == DensityKind::unit_formula)
    return formula_text(density.kind == DensityKind::unit_formula, density.formula);
  return text_of(density_words, density.kind);
}

}  // namespace meander
