// Parameters from settings by name and text.
#pragma once

#include "kernels/model/sample_parameters.h"
#include "kernels/public/settings.h"
#include "kernels/surface/sample_surface.h"

namespace meander {

// Throw std::invalid_argument with a sentence for everything that is wrong.
SampleParameters parameters_of(const Settings& settings);
SurfaceSampleParameters surface_parameters_of(const Settings& settings);

}  // namespace meander
