// Internal to svg_plot: where the parts of a plot lie, and how axes and series are drawn.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "io/plot/colour.h"
#include "io/plot/svg_plot.h"
#include "io/plot/svg_writer.h"

namespace meander::svg {

inline constexpr Rgb text_colour{34, 34, 34};

// In scaled units: values, or their decimal logarithms.
struct Interval {
  double lower = std::numeric_limits<double>::infinity(), upper = -lower;
  bool is_empty() const { return !(lower <= upper); }
  void include(double value, AxisScale scale);  // unless it cannot be drawn
};

struct AxisMap {
  AxisScale scale = AxisScale::linear;
  Interval range;
  double first = 0, last = 1;  // px of the range's ends

  // NaN for what cannot be drawn; far outside the frame px are cut so that they stay finite.
  double operator()(double value) const;
};

struct Layout {
  Box frame;
  AxisMap x, y;
  std::vector<AxisTick> x_ticks, y_ticks;
};

// Of tick labels and the axis label below the frame.
double x_axis_room(const Plot& plot);
// The frame, its axes and their ticks, with room for a legend right of the frame or below it.
Layout lay_out(const Plot& plot, double right_of_frame, double below_frame);
// Grid, ticks, labels and title.
std::string axes(const Plot& plot, const Layout& layout);

std::string stroked(const std::string& path, Rgb colour, double width, LineDash dash);
std::size_t colour_index(const Plot& plot, std::size_t series);
Rgb colour_of(const Plot& plot, std::size_t series);
bool has_line(const PlotSeries& series);
bool has_markers(const PlotSeries& series);
// Markers of the kind that goes with a colour, `r` half their width.
std::string markers(std::span<const Point> centres, std::size_t index, Rgb colour, double r);
std::string all_series(const Plot& plot, const Layout& layout);
bool passes(Point from, Point to, const Box& box);
// Whether a line, marker or error bar passes through the box.
bool series_pass(const Plot& plot, const Layout& layout, const Box& box);

}  // namespace meander::svg
