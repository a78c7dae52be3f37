// The series of a plot as drawn: lines, markers, error bars.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string_view>

#include "io/plot/plot_parts.h"

namespace meander::svg {

namespace {

std::string_view dash_attribute(LineDash dash) {
  switch (dash) {
    case LineDash::dashed:
      return " stroke-dasharray=\"7 4\"";
    case LineDash::dotted:
      return " stroke-dasharray=\"1.5 3\"";
    case LineDash::dash_dot:
      return " stroke-dasharray=\"8 3 1.5 3\"";
    case LineDash::solid:
      break;
  }
  return "";
}

constexpr std::size_t marker_kinds = 6;

// Path data of a marker: filled circle, square, triangle, diamond, triangle upside down, and the ring.
std::string marker(std::size_t kind, Point at, double r) {
  const auto polygon = [&](std::span<const Point> corners) {
    std::string path;
    for (const Point& corner : corners)
      path += fmt::format("{}{} {}", path.empty() ? 'M' : 'L', number(at.x + r * corner.x),
                          number(at.y + r * corner.y));
    return path + "z";
  };
  static constexpr std::array<Point, 4> square{{{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}}};
  static constexpr std::array<Point, 4> diamond{{{0, -1.35}, {1.35, 0}, {0, 1.35}, {-1.35, 0}}};
  static constexpr std::array<Point, 3> upwards{{{0, -1.3}, {1.2, 0.85}, {-1.2, 0.85}}};
  static constexpr std::array<Point, 3> downwards{{{0, 1.3}, {1.2, -0.85}, {-1.2, -0.85}}};
  switch (kind) {
    case 1:
      return polygon(square);
    case 2:
      return polygon(upwards);
    case 3:
      return polygon(diamond);
    case 4:
      return polygon(downwards);
    default:
      return fmt::format("M{0} {1}a{2} {2} 0 1 0 {3} 0a{2} {2} 0 1 0 {4} 0z", number(at.x - r), number(at.y),
                         number(r), number(2 * r), number(-2 * r));
  }
}

}  // namespace

std::string stroked(const std::string& path, Rgb colour, double width, LineDash dash) {
  if (path.empty()) return {};
  return fmt::format(
      "<path d=\"{}\" stroke=\"{}\" stroke-width=\"{}\" fill=\"none\" "
      "stroke-linejoin=\"round\"{}/>\n",
      path, hex_colour(colour), number(width), dash_attribute(dash));
}

std::size_t colour_index(const Plot& plot, std::size_t series) {
  return plot.series[series].colour.value_or(series);
}

Rgb colour_of(const Plot& plot, std::size_t series) {
  return plot.series[series].neutral ? neutral_colour : palette_colour(colour_index(plot, series));
}

bool has_line(const PlotSeries& series) { return series.style != SeriesStyle::points; }
bool has_markers(const PlotSeries& series) {
  return series.style == SeriesStyle::points || series.style == SeriesStyle::line_and_points;
}

std::string markers(std::span<const Point> centres, std::size_t index, Rgb colour, double r) {
  const std::size_t kind = index % marker_kinds;
  std::string path;
  for (const Point& centre : centres) path += marker(kind, centre, r);
  if (path.empty()) return {};
  // The last kind is a ring; the others have a white rim so that they stay apart on one another.
  const bool ring = kind == marker_kinds - 1;
  return fmt::format("<path d=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\"/>\n", path,
                     ring ? "#ffffff" : hex_colour(colour), ring ? hex_colour(colour) : "#ffffff",
                     ring ? "1.4" : "0.6");
}

namespace {

// The corners of a series' line; NaN where a value is skipped.
std::vector<Point> corners_of(const PlotSeries& series, const Layout& layout) {
  std::vector<Point> corners;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const Point at{layout.x(series.x[i]), layout.y(series.y[i])};
    if (series.style == SeriesStyle::steps && !corners.empty()) corners.push_back({at.x, corners.back().y});
    corners.push_back(at);
  }
  return corners;
}

std::vector<Point> centres_of(const PlotSeries& series, const Layout& layout) {
  std::vector<Point> centres;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const Point at{layout.x(series.x[i]), layout.y(series.y[i])};
    if (layout.frame.contains(at)) centres.push_back(at);
  }
  return centres;
}

// A vertical bar inside the frame; its ends have caps where the bar was not cut.
struct ErrorBar {
  double x = 0, low = 0, high = 0;
  bool low_cap = true, high_cap = true;
};

std::vector<ErrorBar> error_bars_of(const PlotSeries& series, const Layout& layout) {
  const Box& frame = layout.frame;
  std::vector<ErrorBar> bars;
  for (std::size_t i = 0; i < series.error.size(); ++i) {
    const double x = layout.x(series.x[i]), error = series.error[i];
    if (std::isnan(layout.y(series.y[i])) || !std::isfinite(error) || !(error > 0)) continue;
    if (!(x >= frame.left && x <= frame.right)) continue;
    const double below = layout.y(series.y[i] - error), above = layout.y(series.y[i] + error);
    // What cannot be drawn (NaN: below zero on a log axis, or too large) compares false: the bar ends at the
    // frame.
    ErrorBar bar{x, frame.bottom, frame.top, below <= frame.bottom, above >= frame.top};
    if (bar.low_cap) bar.low = below;
    if (bar.high_cap) bar.high = above;
    if (bar.high <= frame.bottom && bar.low >= frame.top && bar.high <= bar.low) bars.push_back(bar);
  }
  return bars;
}

std::string error_bars(const PlotSeries& series, const Layout& layout, Rgb colour) {
  std::string path;
  for (const ErrorBar& bar : error_bars_of(series, layout)) {
    path += fmt::format("M{} {}V{}", number(bar.x), number(bar.low), number(bar.high));
    if (bar.low_cap) path += fmt::format("M{} {}h6", number(bar.x - 3), number(bar.low));
    if (bar.high_cap) path += fmt::format("M{} {}h6", number(bar.x - 3), number(bar.high));
  }
  return stroked(path, colour, 1, LineDash::solid);
}

}  // namespace

std::string all_series(const Plot& plot, const Layout& layout) {
  std::string out;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& series = plot.series[i];
    const Rgb colour = colour_of(plot, i);
    out += error_bars(series, layout, colour);
    if (has_line(series))
      out += stroked(svg::clipped_path(corners_of(series, layout), layout.frame), colour, series.line_width,
                     series.dash);
    if (has_markers(series))
      out += markers(centres_of(series, layout), colour_index(plot, i), colour, series.marker_size);
  }
  return out;
}

bool passes(Point from, Point to, const Box& box) {
  return std::isfinite(from.x + from.y) && std::isfinite(to.x + to.y) && svg::clip(from, to, box);
}

bool series_pass(const Plot& plot, const Layout& layout, const Box& box) {
  for (const PlotSeries& series : plot.series) {
    const std::vector<Point> corners = corners_of(series, layout);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (passes(corners[i], corners[i], box)) return true;
      if (has_line(series) && i > 0 && passes(corners[i - 1], corners[i], box)) return true;
    }
    for (const ErrorBar& bar : error_bars_of(series, layout))
      if (passes({bar.x, bar.low}, {bar.x, bar.high}, box)) return true;
  }
  return false;
}

}  // namespace meander::svg
