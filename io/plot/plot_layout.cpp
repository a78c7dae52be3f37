// From the values of a plot to px: ranges, ticks, the frame, and the axes as drawn.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "io/plot/plot_parts.h"

namespace meander::svg {

namespace {

constexpr double not_drawable = std::numeric_limits<double>::quiet_NaN();
constexpr double title_size = 15, label_size = 13, tick_size = 11.5;
constexpr Rgb tick_colour{68, 68, 68};

bool is_drawable(double value, AxisScale scale) {
  return std::isfinite(value) && (scale == AxisScale::linear ? std::abs(value) <= 1e300 : value > 0);
}

double scaled(double value, AxisScale scale) {
  return scale == AxisScale::linear ? value : std::log10(value);
}

}  // namespace

void Interval::include(double value, AxisScale scale) {
  if (!is_drawable(value, scale)) return;
  lower = std::min(lower, scaled(value, scale));
  upper = std::max(upper, scaled(value, scale));
}

double AxisMap::operator()(double value) const {
  if (!is_drawable(value, scale)) return not_drawable;
  const double t = (scaled(value, scale) - range.lower) / (range.upper - range.lower);
  return first + std::clamp(t, -1e6, 1e6) * (last - first);
}

namespace {

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

std::vector<AxisTick> ticks_of(const AxisMap& map, std::size_t most) {
  const bool log = map.scale == AxisScale::log10;
  const double lower = log ? std::pow(10.0, map.range.lower) : map.range.lower;
  const double upper = log ? std::pow(10.0, map.range.upper) : map.range.upper;
  // Logarithms at the ends of the doubles may round to 0, infinity or one number.
  if (!(lower < upper) || !std::isfinite(upper) || (log && lower < 1e-300)) return {};
  return axis_ticks(map.scale, lower, upper, most);
}

double label_width(const AxisTick& tick) { return svg::text_width(tick.label, tick_size); }

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

}  // namespace

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

}  // namespace meander::svg
