#include "io/plot/svg_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "io/plot/svg_writer.h"

namespace meander {

namespace {

using svg::Box;
using svg::number;
using svg::Point;

constexpr double caption_size = 12.5, caption_line = 16, title_size = 15;

void check(const PlanarDrawing& drawing) {
  for (const PlanarPolyline& line : drawing.lines)
    if (line.x.size() != line.y.size())
      throw std::invalid_argument("svg_points: x and y of a line differ in length");
  for (const DotSet& set : drawing.dots)
    if (set.x.size() != set.y.size() || (!set.colours.empty() && set.colours.size() != set.x.size()))
      throw std::invalid_argument("svg_points: x, y and colours of dots differ in length");
  const bool increasing = drawing.x_min < drawing.x_max && drawing.y_min < drawing.y_max;
  const double size = drawing.x_max - drawing.x_min + drawing.y_max - drawing.y_min;
  if (!drawing.fit && !(increasing && std::isfinite(size)))
    throw std::invalid_argument("svg_points: the window is not finite and increasing");
}

struct Window {
  double x_min = 0, x_max = 1, y_min = 0, y_max = 1;
};

bool is_drawable(double x, double y) { return std::abs(x) <= 1e150 && std::abs(y) <= 1e150; }

Window window_of(const PlanarDrawing& drawing) {
  if (!drawing.fit) return {drawing.x_min, drawing.x_max, drawing.y_min, drawing.y_max};
  const double infinity = std::numeric_limits<double>::infinity();
  Window window{infinity, -infinity, infinity, -infinity};
  const auto include = [&](const std::vector<double>& x, const std::vector<double>& y) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (!is_drawable(x[i], y[i])) continue;
      window = {std::min(window.x_min, x[i]), std::max(window.x_max, x[i]), std::min(window.y_min, y[i]),
                std::max(window.y_max, y[i])};
    }
  };
  for (const PlanarPolyline& line : drawing.lines) include(line.x, line.y);
  for (const DotSet& set : drawing.dots) include(set.x, set.y);
  if (!(window.x_min <= window.x_max)) return {};
  double margin = 0.02 * std::max(window.x_max - window.x_min, window.y_max - window.y_min);
  if (!(margin > 0)) margin = 0.5 * std::max({1e-9, std::abs(window.x_min), std::abs(window.y_min)});
  return {window.x_min - margin, window.x_max + margin, window.y_min - margin, window.y_max + margin};
}

// The window in the middle of width x height px, one scale for both directions.
struct Placement {
  Window window;
  double scale = 1;
  Box box;

  Placement(const Window& shown, double width, double height) : window(shown) {
    const double across = window.x_max - window.x_min, up = window.y_max - window.y_min;
    const double inset = 1;  // the frame's line stays whole
    scale = std::min((width - 2 * inset) / across, (height - 2 * inset) / up);
    box.left = 0.5 * (width - scale * across);
    box.top = 0.5 * (height - scale * up);
    box.right = box.left + scale * across;
    box.bottom = box.top + scale * up;
  }
  Point operator()(double x, double y) const {
    if (!is_drawable(x, y)) return {std::numeric_limits<double>::quiet_NaN(), 0};
    return {box.left + scale * (x - window.x_min), box.bottom - scale * (y - window.y_min)};
  }
};

std::string draw_path(const std::string& path, Rgb colour, double width) {
  if (path.empty()) return {};
  return fmt::format(
      "<path d=\"{}\" stroke=\"{}\" stroke-width=\"{}\" fill=\"none\" stroke-linejoin=\"round\" "
      "stroke-linecap=\"round\"/>\n",
      path, hex_colour(colour), number(width));
}

std::string draw_line(const PlanarPolyline& line, const Placement& place) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < line.x.size(); ++i) points.push_back(place(line.x[i], line.y[i]));
  if (line.closed && points.size() > 2) points.push_back(points.front());
  if (!line.along || points.size() < 2)
    return draw_path(svg::clipped_path(points, place.box), line.colour, line.width);
  const std::size_t segments = points.size() - 1, pieces = std::min<std::size_t>(segments, 96);
  std::string out;
  for (std::size_t k = 0; k < pieces; ++k) {
    const std::size_t from = k * segments / pieces, to = (k + 1) * segments / pieces;
    const double middle = (static_cast<double>(k) + 0.5) / static_cast<double>(pieces);
    out += draw_path(svg::clipped_path(std::span(points).subspan(from, to - from + 1), place.box),
                     map_colour(ColourMap::lagoon, 0.88 * middle), line.width);
  }
  return out;
}

std::string draw_dots(const DotSet& set, const Placement& place) {
  std::string circles;
  for (std::size_t i = 0; i < set.x.size(); ++i) {
    const Point at = place(set.x[i], set.y[i]);
    if (!place.box.contains(at)) continue;
    circles +=
        fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\"", number(at.x), number(at.y), number(set.radius));
    if (!set.colours.empty()) circles += fmt::format(" fill=\"{}\"", hex_colour(set.colours[i]));
    circles += "/>\n";
  }
  if (circles.empty()) return {};
  return fmt::format("<g fill=\"{}\">\n{}</g>\n", hex_colour(set.colour), circles);
}

// Without the caption.
std::string drawing_elements(const PlanarDrawing& drawing, double width, double height) {
  const Placement place(window_of(drawing), width, height);
  std::string out;
  for (const PlanarPolyline& line : drawing.lines) out += draw_line(line, place);
  for (const DotSet& set : drawing.dots) out += draw_dots(set, place);
  if (drawing.frame)
    out += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#555555\"/>\n",
        number(place.box.left), number(place.box.top), number(place.box.width()), number(place.box.height()));
  return out;
}

struct Panel {
  std::string elements, caption;
};

// Lays panels out row by row; each row is as high as its longest caption asks for.
std::string lay_out(const std::vector<Panel>& panels, const PanelGrid& grid) {
  const bool sizes = grid.panel_width >= 20 && grid.panel_height >= 20 && grid.gap >= 0 &&
                     grid.panel_width <= 10000 && grid.panel_height <= 10000 && grid.gap <= 1000;
  if (!sizes)
    throw std::invalid_argument("svg_panels: panels must measure 20 to 10000 px, gaps 0 to 1000 px");
  const std::size_t count = panels.size();
  const std::size_t even_rows = (count + 3) / 4;
  std::size_t columns = grid.columns > 0 ? grid.columns
                        : even_rows > 0  ? (count + even_rows - 1) / even_rows
                                         : 1;
  columns = std::clamp<std::size_t>(columns, 1, std::max<std::size_t>(count, 1));
  const double margin = 12;
  const double width = 2 * margin + static_cast<double>(columns) * (grid.panel_width + grid.gap) - grid.gap;
  double top = margin;
  std::string out;
  if (!grid.title.empty()) {
    out += svg::text(svg::fit_text(grid.title, title_size, width - 2 * margin), {0.5 * width, top + 14},
                     {title_size, TextAnchor::middle, {34, 34, 34}, true, false, false});
    top += 28;
  }
  for (std::size_t first = 0; first < count; first += columns) {
    std::size_t caption_lines = 0;
    for (std::size_t i = first; i < std::min(count, first + columns); ++i) {
      const double left = margin + static_cast<double>(i - first) * (grid.panel_width + grid.gap);
      out += fmt::format("<g transform=\"translate({} {})\">\n{}</g>\n", number(left), number(top),
                         panels[i].elements);
      const auto lines = svg::wrap_text(panels[i].caption, caption_size, grid.panel_width);
      caption_lines = std::max(caption_lines, lines.size());
      for (std::size_t k = 0; k < lines.size(); ++k)
        out += svg::text(lines[k],
                         {left + 0.5 * grid.panel_width,
                          top + grid.panel_height + 18 + caption_line * static_cast<double>(k)},
                         {caption_size, TextAnchor::middle, {34, 34, 34}, false, false, false});
    }
    const double captions = caption_lines > 0 ? 8 + caption_line * static_cast<double>(caption_lines) : 0;
    top += grid.panel_height + captions + (first + columns < count ? grid.gap : 0);
  }
  return svg::document(width, top + margin, grid.title, out);
}

}  // namespace

std::string svg_panels(std::span<const PlanarDrawing> drawings, const PanelGrid& grid) {
  std::vector<Panel> panels;
  for (const PlanarDrawing& drawing : drawings) {
    check(drawing);
    panels.push_back({drawing_elements(drawing, grid.panel_width, grid.panel_height), drawing.caption});
  }
  return lay_out(panels, grid);
}

std::string svg_panels(std::span<const Plot> plots, const PanelGrid& grid) {
  std::vector<Panel> panels;
  for (const Plot& given : plots) {
    Plot plot = given;
    plot.width = grid.panel_width;
    plot.height = grid.panel_height;
    panels.push_back({plot_elements(plot), {}});
  }
  return lay_out(panels, grid);
}

std::string svg_points(const PlanarDrawing& drawing, double width, double height) {
  check(drawing);
  // No paper above and below a flat drawing.
  const Window window = window_of(drawing);
  const double needed = 2 + (width - 2) * (window.y_max - window.y_min) / (window.x_max - window.x_min);
  return svg_panels(std::span(&drawing, 1),
                    {{}, 1, width, std::clamp(needed, std::min(20.0, height), height), 0});
}

}  // namespace meander
