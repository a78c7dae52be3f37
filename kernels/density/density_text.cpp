#include "kernels/density/density_text.h"

namespace meander {

namespace {

constexpr std::string_view formula_prefix = "formula:", unit_formula_prefix = "unit-formula:";

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
  std::string forms;
  for (const DensityForm& form : density_forms()) {
    const bool takes_text = form.text_member != nullptr;
    if (takes_text ? text.starts_with(form.text) : text == form.text) {
      density.kind = form.value;
      if (takes_text) density.*form.text_member = text.substr(std::string_view(form.text).size());
      return "";
    }
    const bool is_named = form.text_member == &DensityParameters::attribute;
    forms += (forms.empty() ? "" : "|") + std::string(form.text) +
             (is_named     ? "NAME"
              : takes_text ? "TEXT"
                           : "");
  }
  return "`" + std::string(text) + "` is not one of " + forms;
}

std::string density_text(const DensityParameters& density) {
  const DensityForm& form = form_of(density);
  return form.text + (form.text_member != nullptr ? density.*form.text_member : std::string());
}

std::string density_help() {
  std::string help;
  for (const DensityForm& form : density_forms()) help += (help.empty() ? "" : ", ") + std::string(form.help);
  return help;
}

}  // namespace meander
