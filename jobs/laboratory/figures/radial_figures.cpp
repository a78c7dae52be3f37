#include "jobs/laboratory/figures/radial_figures.h"

#include <algorithm>
#include <cstdint>

#include "io/plot/heat_map.h"

namespace meander {

RgbImage grey_map(std::span<const double> values, std::size_t side, double upper, std::size_t width) {
  HeatMapParameters look;
  look.lower = 0;
  look.upper = upper;
  look.upwards = true;
  look.pixels = std::max<std::uint32_t>(1, static_cast<std::uint32_t>(width / side));
  return heat_map(values, static_cast<std::uint32_t>(side), static_cast<std::uint32_t>(side), look);
}

PlotSeries profile_series(const std::string& name, const RadialProfile& profile,
                          const std::vector<double>& values, double scale) {
  PlotSeries series;
  series.name = name;
  series.style = SeriesStyle::line;
  for (std::size_t k = 0; k < profile.rings(); ++k)
    if (profile.reliable(k)) {
      series.x.push_back(profile.radius[k] * scale);
      series.y.push_back(values[k]);
    }
  return series;
}

}  // namespace meander
