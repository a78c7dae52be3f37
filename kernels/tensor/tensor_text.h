// Tensor fields as texts: "curvature", "constant:1,0,0,1,0,1", "file:tensors.txt", ...
#pragma once

#include <string>
#include <string_view>

#include "kernels/tensor/make_tensor_field.h"

namespace meander {

// The forms of the text, with bars between them.
inline constexpr std::string_view tensor_forms =
    "curvature|isotropic|attribute:NAME|face-attribute:NAME|constant:XX,XY,XZ,YY,YZ,ZZ|formula:X,Y,Z|"
    "formula:XX,XY,XZ,YY,YZ,ZZ|unit-formula:X,Y,Z|unit-formula:XX,XY,XZ,YY,YZ,ZZ|file:PATH";

// Sets kind, attribute (the path for files), constant and formula. Returns what is wrong with the text, or
// "".
std::string take_tensor(std::string_view text, TensorParameters& tensor);
// The inverse: a text that gives these parameters.
std::string tensor_text(const TensorParameters& tensor);

}  // namespace meander
