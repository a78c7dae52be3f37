// The settings of samples of parametric surfaces: the one list behind the options of `surface`, its stored
// parameters, and the keywords of Python.
#pragma once

#include <string>
#include <string_view>

#include "kernels/core/setting.h"
#include "kernels/surface/sample_surface.h"

namespace meander {

inline constexpr Word<CurveKind> curve_words[] = {{"hilbert", CurveKind::hilbert},
                                                  {"peano", CurveKind::peano},
                                                  {"peano-meander", CurveKind::peano_meander}};

using SurfaceSettings = SettingList<SurfaceSampleParameters>;
const SurfaceSettings& surface_settings();

// Sets kind and expression from the words uniform, mean, gaussian and max, or any expression, which is not
// compiled. Returns what is wrong with a single word that is similar to one of these, or "".
std::string take_surface_density(std::string_view text, SurfaceDensity& density);

}  // namespace meander
