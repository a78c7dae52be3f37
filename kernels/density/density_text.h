// Densities as texts: "uniform", "attribute:NAME", "formula:1 + x^2", ...
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "kernels/core/setting.h"
#include "kernels/density/density.h"

namespace meander {

// A formula is given as "formula:TEXT", in lengths of the file, or "unit-formula:TEXT", of the unit box.
struct FormulaText {
  bool unit_box;
  std::string text;
};
// Null for other texts. The formula is not compiled.
std::optional<FormulaText> formula_in(std::string_view text);
// The inverse.
std::string formula_text(bool unit_box, std::string_view formula);

// Sets kind, attribute and formula. Returns what is wrong with the text, or "".
std::string take_density(std::string_view text, DensityParameters& density);
// The text that gives these.
std::string density_text(const DensityParameters& density);
// What every kind is, for the help of options.
std::string density_help();

}  // namespace meander
