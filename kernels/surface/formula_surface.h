// Parametric surfaces from formulas given as text.
#pragma once

#include <memory>
#include <string_view>

#include "kernels/surface/surface.h"

namespace meander {

// Takes three expressions in u and v (kernels/core/expression.h), separated by commas: x, y, z, as "u, v,
// sin(6*u)". The name is the text without blanks. Derivatives are exact; they may be infinite, as those of
// sqrt(u) at 0. A point without a finite position, or without first derivatives (0 / 0), throws ItemError
// (non_finite, with u and v) from every evaluation that meets it. Throws std::invalid_argument for other
// texts, with the position in the formula.
std::unique_ptr<ParametricSurface> make_formula_surface(std::string_view text);

// Whether a text has a comma outside of parentheses: no other name of a surface has one.
bool is_surface_formula(std::string_view text);

}  // namespace meander
