#include "jobs/laboratory/figures/figure_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/file/atomic_file.h"
#include "io/plot/plot_table.h"
#include "io/plot/png_writer.h"
#include "io/table/csv_writer.h"
#include "kernels/analyse/slope_fit.h"
#include "kernels/core/status.h"

namespace meander {

bool is_figure_file(const std::string& name) {
  const auto digit = [&](std::size_t at) { return at < name.size() && name[at] >= '0' && name[at] <= '9'; };
  return (name.starts_with("figure") && digit(6) && digit(7)) || name.starts_with("table1") ||
         name.starts_with("histogram_floor") || name.starts_with("spaced_") || name.starts_with("metro_");
}

// Only names that were looked at before the first figure was drawn.
std::filesystem::path FigureSet::file(const std::string& name) const {
  if (!is_figure_file(name)) throw ItemError(Status::internal, "`" + name + "` is no name of a figure");
  return folder_ / name;
}

void FigureSet::begin(const std::string& heading) {
  note_(heading);
  page.figures.push_back({heading, {}, {}, {}, {}});
}

void FigureSet::plot(const std::string& stem, const Plot& plot, const std::string& caption) {
  replace_file(file(stem + ".svg"), svg_plot(plot));
  replace_file(file(stem + ".csv"), csv_text(plot_table(plot)));
  page.figures.back().images.push_back({stem + ".svg", plot.title, caption});
  page.figures.back().data.push_back(stem + ".csv");
}

void FigureSet::drawing(const std::string& stem, const std::string& svg, const std::string& caption) {
  replace_file(file(stem + ".svg"), svg);
  page.figures.back().images.push_back({stem + ".svg", caption, caption});
}

void FigureSet::picture(const std::string& stem, const RgbImage& image, const std::string& caption) {
  write_png(file(stem + ".png"), image);
  page.figures.back().images.push_back({stem + ".png", caption, caption});
}

void FigureSet::table(const std::string& stem, const std::string& caption, const Table& table) {
  replace_file(file(stem + ".csv"), csv_text(table));
  page.figures.back().tables.push_back({caption, table});
  page.figures.back().data.push_back(stem + ".csv");
}

void FigureSet::data(const std::string& name, const std::string& bytes) {
  replace_file(file(name), bytes);
  page.figures.back().data.push_back(name);
}

void FigureSet::text(const std::string& label, const std::string& text) {
  page.figures.back().paragraphs.push_back({label, text});
}

void FigureSet::attempt(const std::string& mesh, const std::function<void()>& draw) {
  try {
    draw();
  } catch (const ItemError& error) {
    const std::string reason = mesh + ": " + std::string(name_of(error.status())) + ": " + error.what();
    note_("  " + reason);
    text("Not drawn", reason);
  }
}

namespace {

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double standard_error_of(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double mean = mean_of(values);
  double squares = 0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const double n = static_cast<double>(values.size());
  return std::sqrt(squares / (n - 1) / n);
}

}  // namespace

PlotSeries plot_series(const ErrorSeries& errors, std::size_t colour) {
  PlotSeries series;
  series.name = errors.name;
  series.x = errors.counts;
  for (const std::vector<double>& runs : errors.runs) {
    series.y.push_back(mean_of(runs));
    series.error.push_back(standard_error_of(runs));
  }
  series.colour = colour;
  series.marker_size = 2;
  return series;
}

Table slope_table(const std::vector<ErrorSeries>& all, double least, const std::vector<double>& shown) {
  Table table{{{"method"}, {"slope", 3}, {"its error", 2}, {"from"}, {"to"}, {"runs"}}, {}};
  for (const double n : shown) table.columns.push_back({fmt::format("at {}", n), 3});
  for (const ErrorSeries& series : all) {
    std::vector<double> counts, errors;
    for (std::size_t i = 0; i < series.counts.size(); ++i)
      if (series.counts[i] >= least && mean_of(series.runs[i]) > 0) {
        counts.push_back(series.counts[i]);
        errors.push_back(mean_of(series.runs[i]));
      }
    std::vector<TableCell> row = {series.name};
    if (counts.size() > 2) {
      const SlopeFit fit = fit_slope(counts, errors);
      row.insert(row.end(), {fit.slope, fit.standard_error, static_cast<std::uint64_t>(counts.front()),
                             static_cast<std::uint64_t>(counts.back()), series.runs.back().size()});
    } else {
      row.resize(6);
    }
    for (const double n : shown) {
      const auto at = std::find(series.counts.begin(), series.counts.end(), n);
      row.emplace_back();
      if (at != series.counts.end())
        row.back() = mean_of(series.runs[static_cast<std::size_t>(at - series.counts.begin())]);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Plot error_plot(const std::string& title, const std::vector<ErrorSeries>& series,
                const std::string& measure) {
  Plot plot;
  plot.title = title;
  plot.x = {"points", AxisScale::log10, {}, {}};
  plot.y = {measure, AxisScale::log10, {}, {}};
  for (std::size_t i = 0; i < series.size(); ++i) plot.series.push_back(plot_series(series[i], i));
  plot.legend = LegendPlace::right;
  plot.width = 720;
  plot.height = 460;
  return plot;
}

}  // namespace meander
