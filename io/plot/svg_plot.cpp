#include "io/plot/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
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
constexpr double legend_row = 17, legend_sample = 28, legend_padding = 7;
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

double label_width(const AxisTick& tick) {
  double width = svg::text_width(tick.label, tick_size);
  if (tick.power_ten) width += svg::text_width(std::to_string(*tick.power_ten), 0.76 * tick_size);
  return width;
}

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
  const double room = std::max(40.0, 0.42 * plot.width - legend_sample - 8 - 2 * legend_padding);
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

Layout lay_out(const Plot& plot, double right_of_frame) {
  Layout layout;
  const auto [x_values, y_values] = values_of(plot);
  layout.x = {plot.x.scale, axis_range(plot.x, x_values), 0, 1};
  layout.y = {plot.y.scale, axis_range(plot.y, y_values), 1, 0};
  Box& frame = layout.frame;
  frame.top = plot.title.empty() ? 14 : 36;
  frame.bottom = plot.height - (plot.x.label.empty() ? 28 : 48);
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
  const TextStyle tick_style{tick_size, TextAnchor::middle, tick_colour, false, false, false, {}};
  for (const AxisTick& tick : layout.x_ticks) {
    const double x = layout.x(tick.value);
    ticks += fmt::format("M{} {}v{}", number(x), number(frame.bottom), tick.major ? 5 : 3);
    if (tick.major) grid += fmt::format("M{} {}V{}", number(x), number(frame.bottom), number(frame.top));
    if (tick.label.empty()) continue;
    TextStyle style = tick_style;
    style.exponent = tick.power_ten;
    labels += svg::text(tick.label, {x, frame.bottom + 19}, style);
  }
  for (const AxisTick& tick : layout.y_ticks) {
    const double y = layout.y(tick.value);
    ticks += fmt::format("M{} {}h{}", number(frame.left), number(y), tick.major ? -5 : -3);
    if (tick.major) grid += fmt::format("M{} {}H{}", number(frame.left), number(y), number(frame.right));
    if (tick.label.empty()) continue;
    TextStyle style = tick_style;
    style.anchor = TextAnchor::end;
    style.exponent = tick.power_ten;
    labels += svg::text(tick.label, {frame.left - 8, y + 0.36 * tick_size}, style);
  }
  std::string out;
  if (!grid.empty()) out += fmt::format("<path d=\"{}\" stroke=\"#e3e3e3\" fill=\"none\"/>\n", grid);
  out += fmt::format("<path d=\"M{} {}V{}H{}{}\" stroke=\"#555555\" fill=\"none\"/>\n", number(frame.left),
                     number(frame.top), number(frame.bottom), number(frame.right), ticks);
  out += labels;
  const double centre = 0.5 * (frame.left + frame.right), middle = 0.5 * (frame.top + frame.bottom);
  if (!plot.x.label.empty())
    out += svg::text(svg::fit_text(plot.x.label, label_size, plot.width - 20), {centre, plot.height - 10},
                     {label_size, TextAnchor::middle, text_colour, false, false, false, {}});
  if (!plot.y.label.empty())
    out += svg::text(svg::fit_text(plot.y.label, label_size, plot.height - 10), {18, middle},
                     {label_size, TextAnchor::middle, text_colour, false, true, false, {}});
  if (!plot.title.empty())
    out += svg::text(svg::fit_text(plot.title, title_size, plot.width - 16), {centre, 23},
                     {title_size, TextAnchor::middle, text_colour, true, false, false, {}});
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

std::string error_bars(const PlotSeries& series, const Layout& layout, Rgb colour) {
  std::string path;
  for (std::size_t i = 0; i < series.error.size(); ++i) {
    const double x = layout.x(series.x[i]), error = series.error[i];
    if (std::isnan(layout.y(series.y[i])) || !std::isfinite(error) || !(error > 0)) continue;
    if (!(x >= layout.frame.left && x <= layout.frame.right)) continue;
    const double below = layout.y(series.y[i] - error), above = layout.y(series.y[i] + error);
    // Not drawable: below zero on a log axis, or beyond the doubles.
    const double foot = std::isnan(below) ? layout.frame.bottom : below;
    const double head = std::isnan(above) ? layout.frame.top : above;
    const double low = std::min(foot, layout.frame.bottom), high = std::max(head, layout.frame.top);
    if (!(high <= low)) continue;
    path += fmt::format("M{} {}V{}", number(x), number(low), number(high));
    if (low == foot && !std::isnan(below)) path += fmt::format("M{} {}h6", number(x - 3), number(low));
    if (high == head && !std::isnan(above)) path += fmt::format("M{} {}h6", number(x - 3), number(high));
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

// ---- guides, annotations, legend ----

std::string guides(const Plot& plot, const Layout& layout) {
  const Box& frame = layout.frame;
  std::string out;
  for (const PlotGuide& guide : plot.guides) {
    const double at = guide.vertical ? layout.x(guide.value) : layout.y(guide.value);
    TextStyle style{note_size, TextAnchor::end, {85, 85, 85}, false, false, true, {}};
    const double width = svg::text_width(guide.text, note_size);
    Point from, to, place;
    if (guide.vertical) {
      from = {at, frame.bottom};
      to = {at, frame.top};
      const bool to_the_right = at + 5 + width <= frame.right;
      style.anchor = to_the_right ? TextAnchor::start : TextAnchor::end;
      place = {to_the_right ? at + 5 : at - 5, frame.top + 12};
    } else {
      from = {frame.left, at};
      to = {frame.right, at};
      place = {frame.right - 4, at - frame.top > 16 ? at - 5 : at + 14};
    }
    if (!frame.contains(from)) continue;
    out += svg::line(from, to, hex_colour(neutral_colour), 1, " stroke-dasharray=\"5 4\"");
    if (!guide.text.empty()) out += svg::text(guide.text, place, style);
  }
  return out;
}

std::string annotations(const Plot& plot, const Layout& layout) {
  std::string out;
  for (const PlotAnnotation& note : plot.annotations) {
    const Point at{layout.x(note.x), layout.y(note.y)};
    if (!layout.frame.contains(at)) continue;
    const Rgb colour = note.colour ? palette_colour(*note.colour) : text_colour;
    out += svg::text(note.text, at, {note_size, note.anchor, colour, false, false, true, {}});
  }
  return out;
}

// Whether anything drawn passes through the box.
bool is_free(const Plot& plot, const Layout& layout, const Box& box) {
  const auto hits = [&](Point from, Point to) {
    return std::isfinite(from.x + from.y) && std::isfinite(to.x + to.y) && svg::clip(from, to, box);
  };
  for (const PlotSeries& series : plot.series) {
    const std::vector<Point> corners = corners_of(series, layout);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (hits(corners[i], corners[i])) return false;
      if (has_line(series) && i > 0 && hits(corners[i - 1], corners[i])) return false;
    }
  }
  for (const PlotGuide& guide : plot.guides) {
    const double at = guide.vertical ? layout.x(guide.value) : layout.y(guide.value);
    const Box& frame = layout.frame;
    if (guide.vertical ? hits({at, frame.bottom}, {at, frame.top})
                       : hits({frame.left, at}, {frame.right, at}))
      return false;
  }
  for (const PlotAnnotation& note : plot.annotations) {
    const Point at{layout.x(note.x), layout.y(note.y)};
    const double width = svg::text_width(note.text, note_size);
    const double start = note.anchor == TextAnchor::start    ? at.x
                         : note.anchor == TextAnchor::middle ? at.x - 0.5 * width
                                                             : at.x - width;
    if (hits({start, at.y}, {start + width, at.y}) || hits({start, at.y - 9}, {start + width, at.y - 9}))
      return false;
  }
  return true;
}

Box corner_box(const Legend& legend, const Box& frame, LegendPlace place) {
  const bool left = place == LegendPlace::top_left || place == LegendPlace::bottom_left;
  const bool top = place == LegendPlace::top_left || place == LegendPlace::top_right;
  const double x = left ? frame.left + 9 : frame.right - 9 - legend.width;
  const double y = top ? frame.top + 8 : frame.bottom - 8 - legend.height;
  return {x, y, x + legend.width, y + legend.height};
}

LegendPlace free_place(const Plot& plot, const Layout& layout, const Legend& legend) {
  if (legend.width > 0.6 * layout.frame.width() || legend.height > 0.7 * layout.frame.height())
    return LegendPlace::right;
  for (const LegendPlace place :
       {LegendPlace::top_right, LegendPlace::bottom_left, LegendPlace::top_left, LegendPlace::bottom_right}) {
    Box box = corner_box(legend, layout.frame, place);
    box = {box.left - 7, box.top - 7, box.right + 7, box.bottom + 7};
    if (is_free(plot, layout, box)) return place;
  }
  return LegendPlace::right;
}

std::string draw_legend(const Plot& plot, const Legend& legend, const Box& box, bool inside) {
  std::string out;
  if (inside)
    out += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"3\" fill=\"#ffffff\" "
        "fill-opacity=\"0.9\" stroke=\"#cccccc\"/>\n",
        number(box.left), number(box.top), number(box.width()), number(box.height()));
  for (std::size_t k = 0; k < legend.series.size(); ++k) {
    const std::size_t i = legend.series[k];
    const PlotSeries& series = plot.series[i];
    const double y = box.top + legend_padding + legend_row * (static_cast<double>(k) + 0.5) - 2;
    const double x = box.left + legend_padding;
    if (has_line(series))
      out += stroked(fmt::format("M{} {}h{}", number(x), number(y), number(legend_sample)),
                     colour_of(plot, i), series.line_width, series.dash);
    const Point centre{x + 0.5 * legend_sample, y};
    if (has_markers(series))
      out +=
          markers({&centre, 1}, colour_index(plot, i), colour_of(plot, i), std::max(series.marker_size, 2.5));
    out += svg::text(legend.names[k], {x + legend_sample + 8, y + 0.36 * legend_size},
                     {legend_size, TextAnchor::start, text_colour, false, false, false, {}});
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
  Layout layout = lay_out(plot, 0);
  LegendPlace place = legend.series.empty() ? LegendPlace::none : plot.legend;
  if (place == LegendPlace::automatic) place = free_place(plot, layout, legend);
  if (place == LegendPlace::right) layout = lay_out(plot, legend.width);
  std::string out =
      axes(plot, layout) + guides(plot, layout) + all_series(plot, layout) + annotations(plot, layout);
  if (place == LegendPlace::right) {
    const double left = layout.frame.right + 8;
    out += draw_legend(plot, legend, {left, layout.frame.top - 2, left + legend.width, plot.height}, false);
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
