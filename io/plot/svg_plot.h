// Curves over a pair of axes as a standalone SVG picture.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/plot/colour.h"

namespace meander {

enum class AxisScale { linear, log10 };

// Without bounds the axis covers the drawable values of all series (with their error bars; only those inside
// the other axis's bounds) and the guides, and a small margin; a linear one whose values are not negative and
// come near zero starts at zero. A bound that is not finite, or not positive on a log axis, is ignored, and
// both are when they do not increase.
struct PlotAxis {
  std::string label{};
  AxisScale scale = AxisScale::linear;
  std::optional<double> lower{}, upper{};
};

enum class SeriesStyle { line, points, line_and_points, steps };  // steps: y[i] holds from x[i] to x[i+1]
enum class LineDash { solid, dashed, dotted, dash_dot };

struct PlotSeries {
  std::string name{};            // empty: not in the legend
  std::vector<double> x{}, y{};  // as many of one as of the other
  std::vector<double> error{};   // empty, or half-lengths of vertical error bars, one per value
  SeriesStyle style = SeriesStyle::line_and_points;
  std::optional<std::size_t> colour{};  // palette_colour; none: the series' number. The marker follows it
  bool neutral = false;                 // grey whatever the colour: reference slopes and theory
  LineDash dash = LineDash::solid;
  double line_width = 1.6;  // px
  double marker_size = 3;   // px, half the width of a marker
};

// Throws std::invalid_argument when x, y or error differ in length.
void check_series(const PlotSeries& series);

// A straight line over the whole frame.
struct PlotGuide {
  double value = 0;
  bool vertical = false;  // at x = value; otherwise at y = value
  std::string text{};     // beside one of its ends, may be empty
};

enum class TextAnchor { start, middle, end };

// Text at a point of the axes' space; outside the frame it is left out.
struct PlotAnnotation {
  double x = 0, y = 0;
  std::string text{};
  TextAnchor anchor = TextAnchor::start;
  std::optional<std::size_t> colour{};  // palette_colour; none: dark grey
};

// automatic: the corner of the frame that nothing touches; without one right of the frame, or below it when
// the names are long for the picture.
enum class LegendPlace { automatic, none, right, below, top_left, top_right, bottom_left, bottom_right };

struct Plot {
  std::string title{};  // empty: none
  PlotAxis x{}, y{};
  std::vector<PlotSeries> series{};
  std::vector<PlotGuide> guides{};
  std::vector<PlotAnnotation> annotations{};
  LegendPlace legend = LegendPlace::automatic;
  double width = 640, height = 420;  // px, the whole picture; from 160 x 120 to 10000 x 10000
};

// A whole <svg> element: UTF-8, white background, no scripts, no ids, nothing loaded, font `sans-serif`.
// Texts are escaped; in all of them ^{...} is raised and _{...} lowered (io/plot/markup.h). Lines are cut at
// the frame; markers are drawn whole when their centre is inside. Values that are not finite, or not positive
// on a log axis, are skipped and leave a gap in the line; an error bar that reaches them on a log axis ends
// at the frame. Without any drawable value the axes are [0, 1] ([0.1, 1] on log). The same plot gives the
// same bytes. O(values). Throws std::invalid_argument when x, y or error of a series differ in length or a
// side of the picture is out of range.
std::string svg_plot(const Plot& plot);

// A tick of an axis. The label has a real minus sign and powers of ten as 10^{3}, 2.5×10^{-6}; minor ticks
// have none.
struct AxisTick {
  double value = 0;
  std::string label{};
  bool major = true;
};

// Ticks inside [lower, upper] (finite, increasing; positive on log10), ascending. linear: multiples of 1, 2
// or 5 times a power of ten, the finest step with at most `most` of them. log10: every power of ten or every
// k-th one so that at most `most` are labelled, the others minor; 2..9 times them are minor ticks when all
// are labelled. With fewer than two powers of ten inside, the values 1, 2, 5 times a power are labelled, and
// with fewer than two of those, the ticks are linear. `most` is at least 2. Throws std::invalid_argument.
std::vector<AxisTick> axis_ticks(AxisScale scale, double lower, double upper, std::size_t most);

}  // namespace meander
