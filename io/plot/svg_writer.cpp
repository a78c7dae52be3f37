#include "io/plot/svg_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "io/plot/markup.h"
#include "io/utf8.h"

namespace meander::svg {

namespace {

constexpr std::string_view ellipsis = "\u2026";

// Widths of the wide common font (DejaVu Sans) in em, by kinds of characters.
double character_width(std::string_view character) {
  if (character.size() > 2 && static_cast<unsigned char>(character[0]) >= 0xE3) return 1.0;  // CJK and beyond
  const char c = character[0];
  if (character.size() > 1) return 0.66;
  if (std::string_view("ijl'|").find(c) != std::string_view::npos) return 0.29;
  if (std::string_view(" .,:;!()[]ftrI/-\\").find(c) != std::string_view::npos) return 0.39;
  if (std::string_view("mwMW%@").find(c) != std::string_view::npos) return 0.95;
  if ((c >= 'A' && c <= 'Z') || c == '+' || c == '=' || c == '<' || c == '>') return 0.74;
  return 0.62;
}

std::size_t character_length(std::string_view text) {
  return std::max<std::size_t>(1, utf8_sequence_length(text));
}

constexpr double small_share = 0.76;  // size of raised and lowered text

// Escaped, with the raised and lowered runs as tspans that come back to the base line.
std::string marked_up(std::string_view text, double size) {
  std::string out;
  double below = 0;  // where the last run stands, px under the base line
  for (const TextRun& run : text_runs(text)) {
    const double wanted = size * (run.shift < 0 ? -0.4 : run.shift > 0 ? 0.22 : 0);
    if (run.shift == 0 && below == 0)
      out += escape_markup(run.text);
    else
      out += fmt::format("<tspan dy=\"{}\" font-size=\"{}\">{}</tspan>", number(wanted - below),
                         number(run.shift == 0 ? size : small_share * size), escape_markup(run.text));
    below = wanted;
  }
  return out;
}

}  // namespace

std::string number(double value) {
  std::string digits = fmt::format("{:.2f}", value);
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits.pop_back();
  return digits == "-0" ? "0" : digits;
}

double text_width(std::string_view text, double size) {
  double width = 0;
  for (const TextRun& run : text_runs(text)) {
    std::string_view rest = run.text;
    const double run_size = run.shift == 0 ? size : small_share * size;
    while (!rest.empty()) {
      const std::size_t length = character_length(rest);
      width += run_size * character_width(rest.substr(0, length));
      rest.remove_prefix(length);
    }
  }
  return width;
}

std::string fit_text(std::string_view text, double size, double width) {
  if (text_width(text, size) <= width) return std::string(text);
  const double left = width - text_width(ellipsis, size);
  std::size_t end = 0;
  while (end < text.size()) {
    const std::size_t next = end + character_length(text.substr(end));
    if (text_width(text.substr(0, next), size) > left) break;
    end = next;
  }
  return std::string(text.substr(0, end)) + std::string(ellipsis);
}

std::vector<std::string> wrap_text(std::string_view text, double size, double width) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t start = text.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) break;
    text.remove_prefix(start);
    const std::size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
    const std::string word = fit_text(text.substr(0, end), size, width);
    text.remove_prefix(end);
    if (!lines.empty() && text_width(lines.back() + " " + word, size) <= width)
      lines.back() += " " + word;
    else
      lines.push_back(word);
  }
  return lines;
}

std::string text(std::string_view content, Point at, const TextStyle& style) {
  std::string place =
      fmt::format("x=\"{}\" y=\"{}\" font-size=\"{}\"", number(at.x), number(at.y), number(style.size));
  if (style.anchor == TextAnchor::middle) place += " text-anchor=\"middle\"";
  if (style.anchor == TextAnchor::end) place += " text-anchor=\"end\"";
  if (style.bold) place += " font-weight=\"bold\"";
  if (style.upright) place += fmt::format(" transform=\"rotate(-90 {} {})\"", number(at.x), number(at.y));
  const std::string inner = marked_up(content, style.size);
  std::string out;
  // The rim is a text of its own below the other: not every viewer knows paint-order.
  if (style.halo)
    out += fmt::format(
        "<text {} fill=\"#ffffff\" stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\" "
        "aria-hidden=\"true\">{}</text>\n",
        place, inner);
  return out + fmt::format("<text {} fill=\"{}\">{}</text>\n", place, hex_colour(style.colour), inner);
}

std::string line(Point from, Point to, std::string_view stroke, double width, std::string_view more) {
  return fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n",
                     number(from.x), number(from.y), number(to.x), number(to.y), stroke, number(width), more);
}

std::optional<std::pair<Point, Point>> clip(Point from, Point to, const Box& box) {
  const double dx = to.x - from.x, dy = to.y - from.y;
  double enter = 0, leave = 1;
  // Inside where p t <= q for each of the four sides.
  const std::array<std::pair<double, double>, 4> sides{{{-dx, from.x - box.left},
                                                        {dx, box.right - from.x},
                                                        {-dy, from.y - box.top},
                                                        {dy, box.bottom - from.y}}};
  for (const auto& [p, q] : sides) {
    if (p == 0) {
      if (!(q >= 0)) return std::nullopt;
    } else if (p < 0) {
      enter = std::max(enter, q / p);
    } else {
      leave = std::min(leave, q / p);
    }
  }
  if (!(enter <= leave)) return std::nullopt;
  const auto at = [&](double t) {
    return Point{std::clamp(from.x + t * dx, box.left, box.right),
                 std::clamp(from.y + t * dy, box.top, box.bottom)};
  };
  return std::pair{enter > 0 ? at(enter) : from, leave < 1 ? at(leave) : to};
}

std::string clipped_path(std::span<const Point> points, const Box& box) {
  std::string path;
  bool joined = false;  // the path's last point is points[i]
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Point from = points[i], to = points[i + 1];
    const bool drawable = std::isfinite(from.x + from.y) && std::isfinite(to.x + to.y);
    const auto inside = drawable ? clip(from, to, box) : std::nullopt;
    if (!inside) {
      joined = false;
      continue;
    }
    if (!joined) path += fmt::format("M{} {}", number(inside->first.x), number(inside->first.y));
    path += fmt::format("L{} {}", number(inside->second.x), number(inside->second.y));
    joined = box.contains(to);
  }
  return path;
}

std::string document(double width, double height, std::string_view title, std::string_view elements) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" "
      "height=\"{1}\" viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\">\n",
      number(width), number(height));
  if (!title.empty()) {
    std::string plain;
    for (const TextRun& run : text_runs(title))
      (plain += run.shift < 0 ? "^" : run.shift > 0 ? "_" : "") += run.text;
    out += "<title>" + escape_markup(plain) + "</title>\n";
  }
  out += fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#ffffff\"/>\n", number(width), number(height));
  out += elements;
  return out + "</svg>\n";
}

}  // namespace meander::svg
