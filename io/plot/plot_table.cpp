#include "io/plot/plot_table.h"

#include <algorithm>

namespace meander {

Table plot_table(const Plot& plot) {
  for (const PlotSeries& series : plot.series) check_series(series);
  const bool errors =
      std::ranges::any_of(plot.series, [](const PlotSeries& series) { return !series.error.empty(); });
  Table table;
  table.columns = {
      {"series"}, {plot.x.label.empty() ? "x" : plot.x.label}, {plot.y.label.empty() ? "y" : plot.y.label}};
  if (errors) table.columns.push_back({"error"});
  for (const PlotSeries& series : plot.series)
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      table.rows.push_back({series.name, series.x[i], series.y[i]});
      if (!series.error.empty()) table.rows.back().push_back(series.error[i]);
    }
  return table;
}

}  // namespace meander
