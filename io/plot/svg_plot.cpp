#include "io/plot/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "io/plot/plot_parts.h"

namespace meander {

namespace {

using namespace svg;

constexpr double legend_size = 12, note_size = 11.5;
constexpr double legend_row = 17, legend_sample = 28, legend_padding = 7, legend_gap = 4;

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
