#include "io/plot/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "io/plot/svg_writer.h"

namespace meander {

namespace {

using svg::Box;
using svg::number;
using svg::Point;
using svg::TextStyle;

constexpr double not_drawable = std::numeric_limits<double>::quiet_NaN();
constexpr double title_size = 15, label_size = 13, tick_size = 11.5, legend_size = 12, note_size = 11.5;
constexpr double legend_row = 17, legend_sample = 28, legend_padding = 7, legend_gap = 4;
constexpr Rgb text_colour{34, 34, 34}, tick_colour{68, 68, 68};

// ---- from values to px ----

bool is_drawable(double value, AxisScale scale) {
  return std::isfinite(value) && (scale == AxisScale::linear ? std::abs(value) <= 1e300 : value > 0);
}

double scaled(double value, AxisScale scale) {
  return scale == AxisScale::linear ? value : std::log10(value);
}

// In scaled units: values, or their decimal logarithms.
struct Interval {
  double lower = std::numeric_limits<double>::infinity(), upper = -lower;
  bool is_empty() const { return !(lower <= upper); }
  void include(double value, AxisScale scale) {
    if (!is_drawable(value, scale)) return;
    lower = std::min(lower, scaled(value, scale));
    upper = std::max(upper, scaled(value, scale));
  }
};

std::optional<double> usable_bound(const std::optional<double>& bound, AxisScale scale) {
  if (!bound || !is_drawable(*bound, scale)) return std::nullopt;
  return scaled(*bound, scale);
}

struct Bounds {
  std::optional<double> lower, upper;  // scaled
  bool contain(double value, AxisScale scale) const {
    if (!is_drawable(value, scale)) return false;
    const double s = scaled(value, scale);
    return (!lower || s >= *lower) && (!upper || s <= *upper);
  }
};

Bounds given_bounds(const PlotAxis& axis) {
  Bounds bounds{usable_bound(axis.lower, axis.scale), usable_bound(axis.upper, axis.scale)};
  if (bounds.lower && bounds.upper && !(*bounds.lower < *bounds.upper)) return {};
  return bounds;
}

// The range that an axis shows around the values it must hold.
Interval axis_range(const PlotAxis& axis, Interval values) {
  const Bounds given = given_bounds(axis);
  const bool log = axis.scale == AxisScale::log10;
  if (values.is_empty()) values = log ? Interval{-1, 0} : Interval{0, 1};
  if (given.lower) values = {*given.lower, std::max(*given.lower, values.upper)};
  if (given.upper) values = {std::min(values.lower, *given.upper), *given.upper};
  const double size = std::max(std::abs(values.lower), std::abs(values.upper));
  double margin = 0.04 * (values.upper - values.lower);
  // A range of hardly any length is widened, also when it was given.
  const bool too_short = !(values.upper - values.lower > 1e-9 * size);
  if (too_short) margin = log ? 0.5 : size > 0 ? 0.1 * size : 0.5;
  const bool from_zero = !log && values.lower >= 0 && values.lower < 0.25 * values.upper;
  Interval range = values;
  if (!given.lower || too_short) range.lower = from_zero && !given.lower ? 0 : values.lower - margin;
  if (!given.upper || too_short) range.upper = values.upper + margin;
  return range;
}

struct AxisMap {
  AxisScale scale = AxisScale::linear;
  Interval range;
  double first = 0, last = 1;  // px of the range's ends

  // NaN for what cannot be drawn; far outside the frame px are cut so that they stay finite.
  double operator()(double value) const {
    if (!is_drawable(value, scale)) return not_drawable;
    const double t = (scaled(value, scale) - range.lower) / (range.upper - range.lower);
    return first + std::clamp(t, -1e6, 1e6) * (last - first);
  }
};

std::vector<AxisTick> ticks_of(const AxisMap& map, std::size_t most) {
  const bool log = map.scale == AxisScale::log10;
  const double lower = log ? std::pow(10.0, map.range.lower) : map.range.lower;
  const double upper = log ? std::pow(10.0, map.range.upper) : map.range.upper;
  // Logarithms at the ends of the doubles may round to 0, infinity or one number.
  if (!(lower < upper) || !std::isfinite(upper) || (log && lower < 1e-300)) return {};
  return axis_ticks(map.scale, lower, upper, most);
}

double label_width(const AxisTick& tick) { return svg::text_width(tick.label, tick_size); }

// ---- the parts of the picture ----

struct Layout {
  Box frame;
  AxisMap x, y;
  std::vector<AxisTick> x_ticks, y_ticks;
};

struct Legend {
  std::vector<std::size_t> series;
  std::vector<std::string> names;
  double width = 0, height = 0;
};

Legend legend_of(const Plot& plot) {
  Legend legend;
  const double room = std::max(40.0, 0.5 * plot.width - legend_sample - 8 - 2 * legend_padding);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    if (plot.series[i].name.empty()) continue;
    legend.series.push_back(i);
    legend.names.push_back(svg::fit_text(plot.series[i].name, legend_size, room));
    legend.width = std::max(legend.width, svg::text_width(legend.names.back(), legend_size));
  }
  legend.width += legend_sample + 8 + 2 * legend_padding;
  legend.height = legend_row * static_cast<double>(legend.series.size()) + 2 * legend_padding - 4;
  return legend;
}

// What the automatic ranges must hold.
std::pair<Interval, Interval> values_of(const Plot& plot) {
  Interval x, y;
  const Bounds x_bounds = given_bounds(plot.x), y_bounds = given_bounds(plot.y);
  for (const PlotSeries& series : plot.series)
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!is_drawable(series.x[i], plot.x.scale) || !is_drawable(series.y[i], plot.y.scale)) continue;
      if (y_bounds.contain(series.y[i], plot.y.scale)) x.include(series.x[i], plot.x.scale);
      if (!x_bounds.contain(series.x[i], plot.x.scale)) continue;
      y.include(series.y[i], plot.y.scale);
      if (series.error.empty()) continue;
      y.include(series.y[i] - series.error[i], plot.y.scale);
      y.include(series.y[i] + series.error[i], plot.y.scale);
    }
  for (const PlotGuide& guide : plot.guides)
    (guide.vertical ? x : y).include(guide.value, guide.vertical ? plot.x.scale : plot.y.scale);
  return {x, y};
}

// x ticks as many as their labels have room for.
std::vector<AxisTick> fitting_ticks(const AxisMap& map) {
  for (std::size_t most = 10;; --most) {
    std::vector<AxisTick> ticks = ticks_of(map, most);
    double end_of_last = -std::numeric_limits<double>::infinity();
    bool fits = true;
    for (const AxisTick& tick : ticks) {
      if (tick.label.empty()) continue;
      const double centre = map(tick.value), half = 0.5 * label_width(tick);
      fits = fits && centre - half >= end_of_last + 12;
      end_of_last = centre + half;
    }
    if (fits || most == 2) return ticks;
  }
}

// Of tick labels and the axis label below the frame.
double x_axis_room(const Plot& plot) { return plot.x.label.empty() ? 28 : 48; }

Layout lay_out(const Plot& plot, double right_of_frame, double below_frame) {
  Layout layout;
  const auto [x_values, y_values] = values_of(plot);
  layout.x = {plot.x.scale, axis_range(plot.x, x_values), 0, 1};
  layout.y = {plot.y.scale, axis_range(plot.y, y_values), 1, 0};
  Box& frame = layout.frame;
  frame.top = plot.title.empty() ? 14 : 36;
  frame.bottom = std::max(plot.height - x_axis_room(plot) - below_frame, frame.top + 20);
  const double rows = std::clamp(std::floor(frame.height() / 44), 2.0, 10.0);
  layout.y_ticks = ticks_of(layout.y, static_cast<std::size_t>(rows));
  double labels = 0;
  for (const AxisTick& tick : layout.y_ticks) labels = std::max(labels, label_width(tick));
  frame.left = 14 + labels + (plot.y.label.empty() ? 6 : 24);
  frame.right = std::max(plot.width - 18 - right_of_frame, frame.left + 20);
  layout.x.first = frame.left;
  layout.x.last = frame.right;
  layout.y.first = frame.bottom;
  layout.y.last = frame.top;
  layout.x_ticks = fitting_ticks(layout.x);
  return layout;
}

std::string axes(const Plot& plot, const Layout& layout) {
  const Box& frame = layout.frame;
  std::string grid, ticks, labels;
  const TextStyle tick_style{tick_size, TextAnchor::middle, tick_colour, false, false, false};
  for (const AxisTick& tick : layout.x_ticks) {
    const double x = layout.x(tick.value);
    ticks += fmt::format("M{} {}v{}", number(x), number(frame.bottom), tick.major ? 5 : 3);
    if (tick.major) grid += fmt::format("M{} {}V{}", number(x), number(frame.bottom), number(frame.top));
    if (tick.label.empty()) continue;
    labels += svg::text(tick.label, {x, frame.bottom + 19}, tick_style);
  }
  for (const AxisTick& tick : layout.y_ticks) {
    const double y = layout.y(tick.value);
    ticks += fmt::format("M{} {}h{}", number(frame.left), number(y), tick.major ? -5 : -3);
    if (tick.major) grid += fmt::format("M{} {}H{}", number(frame.left), number(y), number(frame.right));
    if (tick.label.empty()) continue;
    TextStyle style = tick_style;
    style.anchor = TextAnchor::end;
    labels += svg::text(tick.label, {frame.left - 8, y + 0.36 * tick_size}, style);
  }
  std::string out;
  if (!grid.empty()) out += fmt::format("<path d=\"{}\" stroke=\"#e3e3e3\" fill=\"none\"/>\n", grid);
  out += fmt::format("<path d=\"M{} {}V{}H{}{}\" stroke=\"#555555\" fill=\"none\"/>\n", number(frame.left),
                     number(frame.top), number(frame.bottom), number(frame.right), ticks);
  out += labels;
  const double centre = 0.5 * (frame.left + frame.right), middle = 0.5 * (frame.top + frame.bottom);
  if (!plot.x.label.empty())
    out += svg::text(svg::fit_text(plot.x.label, label_size, plot.width - 20), {centre, frame.bottom + 38},
                     {label_size, TextAnchor::middle, text_colour, false, false, false});
  if (!plot.y.label.empty())
    out += svg::text(svg::fit_text(plot.y.label, label_size, plot.height - 10), {18, middle},
                     {label_size, TextAnchor::middle, text_colour, false, true, false});
  if (!plot.title.empty())
    out += svg::text(svg::fit_text(plot.title, title_size, plot.width - 16), {centre, 23},
                     {title_size, TextAnchor::middle, text_colour, true, false, false});
  return out;
}

// ---- series ----

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

// Whether a line, marker or error bar passes through the box.
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

Box text_box(std::string_view text, Point at, TextAnchor anchor) {
  const double width = svg::text_width(text, note_size);
  const double left = at.x - width * (anchor == TextAnchor::start    ? 0
                                      : anchor == TextAnchor::middle ? 0.5
                                                                     : 1);
  return {left, at.y - 0.8 * note_size, left + width, at.y + 0.25 * note_size};
}

// ---- guides, annotations, legend ----

// Where a guide runs and its text stands.
struct PlacedGuide {
  Point from, to, text;
  TextAnchor anchor = TextAnchor::end;
};

// The text goes to the first of four places along the guide that no series passes through, else to the first.
std::optional<PlacedGuide> place_guide(const Plot& plot, const PlotGuide& guide, const Layout& layout) {
  const Box& frame = layout.frame;
  const double at = guide.vertical ? layout.x(guide.value) : layout.y(guide.value);
  PlacedGuide placed;
  placed.from = guide.vertical ? Point{at, frame.bottom} : Point{frame.left, at};
  placed.to = guide.vertical ? Point{at, frame.top} : Point{frame.right, at};
  if (!frame.contains(placed.from)) return std::nullopt;
  std::vector<std::pair<Point, TextAnchor>> places;
  if (guide.vertical)
    for (const double y : {frame.top + 10, frame.bottom - 6}) {
      places.push_back({{at + 5, y}, TextAnchor::start});
      places.push_back({{at - 5, y}, TextAnchor::end});
    }
  else
    for (const double y : {at - 5, at + 14}) {
      places.push_back({{frame.right - 4, y}, TextAnchor::end});
      places.push_back({{frame.left + 6, y}, TextAnchor::start});
    }
  std::erase_if(places, [&](const auto& place) {
    const Box box = text_box(guide.text, place.first, place.second);
    return box.left < frame.left || box.right > frame.right || box.top < frame.top ||
           box.bottom > frame.bottom;
  });
  if (places.empty())
    places.push_back({{frame.right, guide.vertical ? frame.top + 10 : at - 5}, TextAnchor::end});
  const auto free = std::ranges::find_if(places, [&](const auto& place) {
    return !series_pass(plot, layout, text_box(guide.text, place.first, place.second));
  });
  std::tie(placed.text, placed.anchor) = free != places.end() ? *free : places.front();
  return placed;
}

std::string guides(const Plot& plot, const Layout& layout) {
  std::string out;
  for (const PlotGuide& guide : plot.guides) {
    const std::optional<PlacedGuide> placed = place_guide(plot, guide, layout);
    if (!placed) continue;
    out += svg::line(placed->from, placed->to, hex_colour(neutral_colour), 1, " stroke-dasharray=\"5 4\"");
  }
  return out;
}

std::string guide_texts(const Plot& plot, const Layout& layout) {
  std::string out;
  for (const PlotGuide& guide : plot.guides) {
    const std::optional<PlacedGuide> placed = place_guide(plot, guide, layout);
    if (!placed || guide.text.empty()) continue;
    out += svg::text(guide.text, placed->text, {note_size, placed->anchor, {85, 85, 85}, false, false, true});
  }
  return out;
}

std::string annotations(const Plot& plot, const Layout& layout) {
  std::string out;
  for (const PlotAnnotation& note : plot.annotations) {
    const Point at{layout.x(note.x), layout.y(note.y)};
    if (!layout.frame.contains(at)) continue;
    const Rgb colour = note.colour ? palette_colour(*note.colour) : text_colour;
    out += svg::text(note.text, at, {note_size, note.anchor, colour, false, false, true});
  }
  return out;
}

// Whether nothing drawn passes through the box.
bool is_free(const Plot& plot, const Layout& layout, const Box& box) {
  const auto text_passes = [&](const std::string& text, Point at, TextAnchor anchor) {
    const Box other = text_box(text, at, anchor);
    return other.left <= box.right && other.right >= box.left && other.top <= box.bottom &&
           other.bottom >= box.top;
  };
  if (series_pass(plot, layout, box)) return false;
  for (const PlotGuide& guide : plot.guides) {
    const std::optional<PlacedGuide> placed = place_guide(plot, guide, layout);
    if (!placed) continue;
    if (passes(placed->from, placed->to, box)) return false;
    if (!guide.text.empty() && text_passes(guide.text, placed->text, placed->anchor)) return false;
  }
  return std::ranges::none_of(plot.annotations, [&](const PlotAnnotation& note) {
    return text_passes(note.text, {layout.x(note.x), layout.y(note.y)}, note.anchor);
  });
}

Box corner_box(const Legend& legend, const Box& frame, LegendPlace place) {
  const bool left = place == LegendPlace::top_left || place == LegendPlace::bottom_left;
  const bool top = place == LegendPlace::top_left || place == LegendPlace::top_right;
  const double x = left ? frame.left + 9 : frame.right - 9 - legend.width;
  const double y = top ? frame.top + 8 : frame.bottom - 8 - legend.height;
  return {x, y, x + legend.width, y + legend.height};
}

// Columns and rows of a legend under the frame.
struct LegendTable {
  std::size_t columns = 1, rows = 1;
  double height = 0;
};

LegendTable table_below(const Plot& plot, const Legend& legend) {
  LegendTable table;
  const std::size_t count = legend.series.size();
  const double room = std::max(1.0, std::floor((plot.width - 20) / (legend.width + legend_gap)));
  table.rows = (count + static_cast<std::size_t>(room) - 1) / static_cast<std::size_t>(room);
  table.columns = (count + table.rows - 1) / table.rows;
  table.height = legend_row * static_cast<double>(table.rows) + 8;
  return table;
}

LegendPlace free_place(const Plot& plot, const Layout& layout, const Legend& legend) {
  const bool small =
      legend.width <= 0.6 * layout.frame.width() && legend.height <= 0.7 * layout.frame.height();
  for (const LegendPlace place :
       {LegendPlace::top_right, LegendPlace::bottom_left, LegendPlace::top_left, LegendPlace::bottom_right}) {
    Box box = corner_box(legend, layout.frame, place);
    box = {box.left - 7, box.top - 7, box.right + 7, box.bottom + 7};
    if (small && is_free(plot, layout, box)) return place;
  }
  const bool narrow = legend.width <= 0.33 * plot.width && legend.height <= layout.frame.height();
  return !narrow && table_below(plot, legend).height <= 0.25 * plot.height ? LegendPlace::below
                                                                           : LegendPlace::right;
}

// One entry: sample and name; at: the middle of its left end.
std::string legend_entry(const Plot& plot, const Legend& legend, std::size_t entry, Point at) {
  const std::size_t i = legend.series[entry];
  const PlotSeries& series = plot.series[i];
  std::string out;
  if (has_line(series))
    out += stroked(fmt::format("M{} {}h{}", number(at.x), number(at.y), number(legend_sample)),
                   colour_of(plot, i), series.line_width, series.dash);
  const Point centre{at.x + 0.5 * legend_sample, at.y};
  if (has_markers(series))
    out +=
        markers({&centre, 1}, colour_index(plot, i), colour_of(plot, i), std::max(series.marker_size, 2.5));
  return out + svg::text(legend.names[entry], {at.x + legend_sample + 8, at.y + 0.36 * legend_size},
                         {legend_size, TextAnchor::start, text_colour, false, false, false});
}

std::string draw_legend_below(const Plot& plot, const Legend& legend, const Layout& layout) {
  const LegendTable table = table_below(plot, legend);
  const double column_width = legend.width + legend_gap;
  const double width = static_cast<double>(table.columns) * column_width - legend_gap;
  // Under the middle of the frame where that fits into the picture.
  const double centre = 0.5 * (layout.frame.left + layout.frame.right);
  const double left = std::max(6.0, std::min(centre - 0.5 * width, plot.width - 6 - width));
  const double top = layout.frame.bottom + x_axis_room(plot);
  std::string out;
  for (std::size_t k = 0; k < legend.series.size(); ++k) {
    const auto column = static_cast<double>(k / table.rows), row = static_cast<double>(k % table.rows);
    out += legend_entry(plot, legend, k,
                        {left + legend_padding + column * column_width, top + legend_row * (row + 0.5)});
  }
  return out;
}

std::string draw_legend(const Plot& plot, const Legend& legend, const Box& box, bool inside) {
  std::string out;
  if (inside)
    out += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"3\" fill=\"#ffffff\" "
        "fill-opacity=\"0.9\" stroke=\"#cccccc\"/>\n",
        number(box.left), number(box.top), number(box.width()), number(box.height()));
  for (std::size_t k = 0; k < legend.series.size(); ++k) {
    const double y = box.top + legend_padding + legend_row * (static_cast<double>(k) + 0.5) - 2;
    out += legend_entry(plot, legend, k, {box.left + legend_padding, y});
  }
  return out;
}

}  // namespace

void check_series(const PlotSeries& series) {
  if (series.x.size() != series.y.size() || (!series.error.empty() && series.error.size() != series.x.size()))
    throw std::invalid_argument("series \"" + series.name + "\": x, y and error differ in length");
}

std::string plot_elements(const Plot& plot) {
  for (const PlotSeries& series : plot.series) check_series(series);
  if (!(plot.width >= 160 && plot.width <= 10000 && plot.height >= 120 && plot.height <= 10000))
    throw std::invalid_argument("svg_plot: the picture must measure 160 x 120 to 10000 x 10000 px");
  const Legend legend = legend_of(plot);
  Layout layout = lay_out(plot, 0, 0);
  LegendPlace place = legend.series.empty() ? LegendPlace::none : plot.legend;
  if (place == LegendPlace::automatic) place = free_place(plot, layout, legend);
  if (place == LegendPlace::right) layout = lay_out(plot, legend.width, 0);
  if (place == LegendPlace::below) layout = lay_out(plot, 0, table_below(plot, legend).height);
  std::string out = axes(plot, layout) + guides(plot, layout) + all_series(plot, layout) +
                    guide_texts(plot, layout) + annotations(plot, layout);
  if (place == LegendPlace::right) {
    const double left = layout.frame.right + 8;
    out += draw_legend(plot, legend, {left, layout.frame.top - 2, left + legend.width, plot.height}, false);
  } else if (place == LegendPlace::below) {
    out += draw_legend_below(plot, legend, layout);
  } else if (place != LegendPlace::none) {
    out += draw_legend(plot, legend, corner_box(legend, layout.frame, place), true);
  }
  return out;
}

std::string svg_plot(const Plot& plot) {
  const std::string elements = plot_elements(plot);
  return svg::document(plot.width, plot.height, plot.title, elements);
}

}  // namespace meander
