// Maps around a middle and their radial means, as the figures draw them.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "io/plot/svg_plot.h"
#include "kernels/analyse/radial_profile.h"
#include "kernels/render/rgb_image.h"

namespace meander {

// side x side values, black 0, white `upper`; cells as large as `width` pixels allow.
RgbImage grey_map(std::span<const double> values, std::size_t side, double upper, std::size_t width = 384);

// One value a ring (profile.mean, profile.anisotropy_db ...) over radius x scale; rings of few cells are left
// out.
PlotSeries profile_series(const std::string& name, const RadialProfile& profile,
                          const std::vector<double>& values, double scale);

}  // namespace meander
