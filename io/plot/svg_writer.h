// What the SVG pictures share: numbers, texts and their widths, lines cut at a frame, the enclosing element.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/plot/colour.h"
#include "io/plot/svg_plot.h"

namespace meander::svg {

struct Point {
  double x = 0, y = 0;
};

// In px, y downwards.
struct Box {
  double left = 0, top = 0, right = 0, bottom = 0;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
  bool contains(Point p) const { return p.x >= left && p.x <= right && p.y >= top && p.y <= bottom; }
};

// Rounded to 1/100 px, without needless zeros; for finite numbers.
std::string number(double value);

// Estimated width of a text in a common sans-serif font, rather too wide than too narrow.
double text_width(std::string_view text, double size);

// The text, or its longest beginning that fits with an ellipsis.
std::string fit_text(std::string_view text, double size, double width);

// Words broken into lines of at most that width; a longer word is cut by fit_text.
std::vector<std::string> wrap_text(std::string_view text, double size, double width);

struct TextStyle {
  double size = 12;
  TextAnchor anchor = TextAnchor::start;
  Rgb colour{34, 34, 34};
  bool bold = false, upright = false;  // upright: read from below
  bool halo = false;                   // a white rim, to stand on lines
};

// `at`: the base line's point that the anchor names. Escapes the text; ^{...} in it is raised and _{...}
// lowered.
std::string text(std::string_view content, Point at, const TextStyle& style);

std::string line(Point from, Point to, std::string_view stroke, double width, std::string_view more = {});

// The part of a segment inside the box, in its direction; none when it misses the box (Liang and Barsky
// 1984).
std::optional<std::pair<Point, Point>> clip(Point from, Point to, const Box& box);

// Path data of a polyline cut at the box; a point with NaN interrupts it. Empty when nothing is inside.
std::string clipped_path(std::span<const Point> points, const Box& box);

// The whole file around its elements.
std::string document(double width, double height, std::string_view title, std::string_view elements);

}  // namespace meander::svg

namespace meander {

// What svg_plot puts inside the document, with its top left corner at the origin.
std::string plot_elements(const Plot& plot);

}  // namespace meander
